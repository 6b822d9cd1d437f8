"""How far probabilities of places can be trusted: `python -m benchmarks.ports.calibration --count 24 --seed 4711`.

Cases with physics outside the library are diagnosed; of the first law the log evidence of every component is kept with
whether that component is an accepted one. The temperature is what makes the accepted components most probable (maximum
likelihood), which is compared with the one in use; reliability is listed by bins of the largest probability. Seeds that
calibrate are not to be used for reporting.
"""

import argparse
from itertools import pairwise

import numpy as np
from benchmarks.ports.experiments import experiments

from expdesign.arrays import FloatArray
from expdesign.diagnosis.diagnose import diagnose
from expdesign.ports.location import SHARE, TEMPERATURE

_BINS = (0.0, 0.5, 0.8, 0.95, 1.0001)


def probabilities(evidence: FloatArray, temperature: float, share: float) -> FloatArray:
    """As `expdesign.ports.location.places` makes them."""
    weights = np.exp((evidence - evidence.max()) / max(temperature, share * float(evidence.max())))
    result: FloatArray = weights / weights.sum()
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=24)
    parser.add_argument("--seed", type=int, default=4711)
    parser.add_argument("--only", default="outside")
    chosen = parser.parse_args()
    seen: list[tuple[FloatArray, FloatArray]] = []
    for case, robot, recordings in experiments(chosen.count, chosen.seed, chosen.only):
        found = diagnose(robot, recordings)
        accepted = {name for effect in case.truth["effects"] for name in effect["components"]}
        if found.laws is None:
            print(f"{case.truth['case']} {sorted(accepted)}: no law ({found.verdict})", flush=True)
            continue
        places = found.laws.parts[0].places
        evidence = np.array([place.log_evidence for place in places])
        right = np.array([str(place.component) in accepted for place in places])
        seen.append((evidence, right))
        first = ", ".join(f"{place.component} {place.log_evidence:.1f}" for place in places[:3])
        mark = "right" if right[0] else "wrong"
        print(f"{case.truth['case']} {sorted(accepted)}: {first}; {mark}; {found.verdict}", flush=True)
    for share in (0.0, SHARE, 0.01, 0.02, 0.04, 0.08):
        for temperature in (1.0, 2.0, 4.0, 8.0, TEMPERATURE, 32.0):
            each = [float(probabilities(e, temperature, share)[r > 0].sum()) for e, r in seen]
            likelihood = float(np.log(np.maximum(each, 1e-6)).mean()) if each else float("nan")
            print(f"share {share:g}, temperature {temperature:g}: mean log probability {likelihood:.3f}")
    first_ones = [(float(probabilities(e, TEMPERATURE, SHARE)[0]), bool(r[0])) for e, r in seen]
    for low, high in pairwise(_BINS):
        inside = [right for probability, right in first_ones if low <= probability < high]
        if inside:
            print(f"probability {low:g} to {min(high, 1.0):g}: {sum(inside)} of {len(inside)} right")


if __name__ == "__main__":
    main()
