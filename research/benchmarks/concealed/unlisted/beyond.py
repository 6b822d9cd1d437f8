"""After the campaign: `python -m research.benchmarks.concealed.unlisted.beyond` generates, asks and scores.

Whatever changes with time or remembers is hidden (drift, warming, creep, settling); the diagnosis sees the series of
the first two thirds of the time, and the judge those of the last third, time beyond the recorded by half of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from ..bench import Order
from ..case import Case, generate
from ..experiments import Experiment
from ..pipeline import arguments, conduct
from ..robots import HEXAPODS
from .cases import draw_case

KINDS = (
    ("left_out", "thermal_drift"),
    ("left_out", "creep"),
    ("form", "other_drift"),
    ("form", "other_creep"),
    ("alone", "warm_leg"),
    ("alone", "sinking_floor"),
    ("form", "thermal_drift"),
    ("form", "creep"),
)
"""Family and physics, known and with its entries there in the last two."""
SEEN = 2.0 / 3.0


def first_part(experiment: Experiment) -> Experiment:
    """The series that ended within the first two thirds of the time are seen; the later ones are the judge's."""
    whole = pd.concat([experiment.rows, experiment.later]).sort_values("sequence", ignore_index=True)
    ends = whole.groupby("series")["time_s"].transform("max").to_numpy(dtype=float)
    seen = ends <= SEEN * ends.max()
    rows, later = (whole[chosen].reset_index(drop=True) for chosen in (seen, ~seen))
    return replace(experiment, rows=rows, later=later, fitted=np.ones(len(rows), dtype=bool))


def orders(count: int, seed: int) -> list[Order]:
    """All kinds in turn, on random hexapods."""
    rng = np.random.default_rng([seed, 0])
    kinds = [KINDS[number % len(KINDS)] for number in range(count)]
    return [Order(family, (physics,), str(rng.choice(list(HEXAPODS)))) for family, physics in kinds]


def main() -> None:
    parser = arguments(__doc__, jobs=1)
    parser.add_argument("--count", type=int, default=24, help="cases")
    chosen = parser.parse_args()
    chosen.only = []

    def draw(seed: int) -> Iterator[Case]:
        return generate(
            partial(draw_case, arranged=first_part), orders(chosen.count, seed)[: chosen.limit], seed, chosen.jobs
        )

    conduct(chosen, draw, "After the end of the campaign", f"-beyond{'' if chosen.seed is None else '-development'}")


if __name__ == "__main__":
    main()
