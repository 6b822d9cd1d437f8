"""FIGAROH's posture selection on a pool of information matrices; runs where FIGAROH is installed.

    python figaroh_worker.py pool.npz COUNT result.json [--detmax]

The pool holds `information` (j, p, p). FIGAROH's SOCP gives weights, of which its own rule takes the largest; its
DetMax exchanges.
"""

import json
import random
import sys
import time
import warnings

import numpy as np

warnings.simplefilter("ignore")


def main() -> None:
    # Imported before the clock starts.
    from figaroh.optimal.base_optimal_calibration import Detmax, SOCPOptimizer  # noqa: PLC0415

    pool_path, count, result_path = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    matrices = np.load(pool_path)["information"]
    # Its solver fails on numbers that are not of the order of one; the choice does not depend on their unit.
    matrices = matrices / np.trace(matrices, axis1=1, axis2=2).mean()

    class Remembering(Detmax):  # type: ignore[misc]
        """DetMax, whose last set is otherwise lost: its `cur_set` stays empty."""

        def get_critD(self, set):  # type: ignore[no-untyped-def]
            self.last = list(set)
            return super().get_critD(set)

    pool = dict(enumerate(matrices))
    random.seed(1)
    start, wall = time.process_time(), time.perf_counter()
    if "--detmax" in sys.argv:
        exchange = Remembering(pool, count)
        exchange.main_algo()
        chosen = [int(i) for i in exchange.last]
    else:
        _, ranked = SOCPOptimizer(pool, {"NbSample": len(matrices)}).solve()
        chosen = [int(i) for i in list(ranked)[:count]]
    seconds, wall = time.process_time() - start, time.perf_counter() - wall
    with open(result_path, "w", encoding="utf-8") as file:
        json.dump({"seconds": seconds, "wall": wall, "chosen": chosen}, file)


if __name__ == "__main__":
    main()
