"""This program: `expdesign diagnose` and `expdesign predict`, its answer brought into the form of the benchmark."""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd

_READINGS = [f"d{axis}" for axis in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")]


def main() -> int:
    """Diagnose, predict, write the answer."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("case", type=Path)
    parser.add_argument("answer", type=Path)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        out, predicted = Path(folder) / "diagnosis", Path(folder) / "predicted.csv"
        _expdesign("diagnose", chosen.case / "robot.yaml", chosen.case / "recordings.csv", "--out", out)
        _expdesign("predict", out / "model.yaml", chosen.case / "points.csv", "--out", predicted)
        diagnosis, rows = json.loads((out / "diagnosis.json").read_text(encoding="utf-8")), pd.read_csv(predicted)
    place = (diagnosis.get("location") or {}).get("component") or []
    effects = diagnosis["effects"]
    if not place and effects:
        place = effects[0]["component"]
    answer = {
        "mismatch": diagnosis["verdict"] != "consistent",
        "location": [place] if isinstance(place, str) else place,
        "physics": [{"name": each["physics"], "probability": each["probability"]} for each in effects],
        "predictions": {name: rows[name].tolist() for name in _READINGS if name in rows},
    }
    chosen.answer.write_text(json.dumps(answer), encoding="utf-8")
    return 0


def _expdesign(*words: object) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "expdesign", *map(str, words)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        print(done.stderr.strip()[-1000:], file=sys.stderr)
        raise SystemExit(done.returncode)


if __name__ == "__main__":
    sys.exit(main())
