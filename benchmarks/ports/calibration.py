"""How far probabilities of places can be trusted: `python -m benchmarks.ports.calibration FILE ...`.

The files are answers of `benchmarks.ports.practice`: of the first component the log evidence of every rival is kept
with the accepted components. The temperature is what makes the accepted components most probable (maximum likelihood),
which is compared with the one in use; reliability is listed by bins of the largest probability. Seeds that calibrate
are not to be used for reporting.
"""

import argparse
import json
from itertools import pairwise
from pathlib import Path

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.diagnosis.evidence.options import EVIDENCE

_BINS = (0.0, 0.5, 0.7, 0.85, 0.95, 1.0001)


def probabilities(evidence: FloatArray, temperature: float, share: float) -> FloatArray:
    """As `expdesign.diagnosis.evidence.places.places` makes them."""
    weights = np.exp((evidence - evidence.max()) / max(temperature, share * float(evidence.max())))
    result: FloatArray = weights / weights.sum()
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", type=Path, nargs="+")
    chosen = parser.parse_args()
    answers = [json.loads(line) for file in chosen.files for line in file.read_text(encoding="utf-8").splitlines()]
    seen = []
    for answer in answers:
        if answer.get("evidence") and answer["kinds"]:
            evidence = np.array([log_evidence for _, log_evidence, _ in answer["evidence"]])
            seen.append((evidence, np.array([name in answer["accepted"] for name, _, _ in answer["evidence"]])))
    print(f"{len(answers)} cases, {len(seen)} with laws; first component right in {sum(bool(r[0]) for _, r in seen)}")
    for share in (0.0, 0.0025, EVIDENCE.share, 0.01, 0.02, 0.04):
        for temperature in (4.0, 8.0, EVIDENCE.temperature, 32.0, 64.0):
            each = [float(probabilities(e, temperature, share)[r].sum()) for e, r in seen]
            likelihood = float(np.log(np.maximum(each, 1e-6)).mean())
            print(f"share {share:g}, temperature {temperature:g}: mean log probability {likelihood:.3f}")
    first_ones = [(float(probabilities(e, EVIDENCE.temperature, EVIDENCE.share)[0]), bool(r[0])) for e, r in seen]
    for low, high in pairwise(_BINS):
        inside = [right for probability, right in first_ones if low <= probability < high]
        if inside:
            print(f"probability {low:g} to {min(high, 1.0):g}: {sum(inside)} of {len(inside)} right")


if __name__ == "__main__":
    main()
