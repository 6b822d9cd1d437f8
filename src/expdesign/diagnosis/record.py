"""`diagnosis.json` (file-formats.md, diagnosis.json)."""

from typing import Any

import numpy as np
import pandas as pd

from expdesign.diagnosis.diagnose import Diagnosis
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.locate import LEVEL


def diagnosis_record(diagnosis: Diagnosis, next_experiment: str | None) -> dict[str, Any]:
    """The document of a diagnosis."""
    base, errors = diagnosis.base, diagnosis.errors
    known = diagnosis.noise.known
    readings = diagnosis.search.sample.readings
    return {
        "verdict": diagnosis.verdict,
        "tests": {
            "chi2": base.chi2 if known else None,
            "dof": readings - base.rank,
            "p_value": diagnosis.p_before if known else None,
            "chi2_after": diagnosis.model.fit.chi2 if known else None,
            "p_value_after": diagnosis.p_after if known else None,
        },
        "location": _location(diagnosis),
        "effects": [_effect(finding) for finding in diagnosis.findings],
        "fit": {
            "noise_rms": 1.0,
            "train_before": errors.train_before,
            "train_after": errors.train_after,
            "test_before": errors.test_before,
            "test_after": errors.test_after,
            "test_surprise": errors.test_surprise,
            "held_out": errors.how,
        },
        "smooth_correction": _correction(diagnosis),
        "caveats": list(diagnosis.caveats),
        "next_experiment": next_experiment,
        "considered": diagnosis.search.log.entries,
    }


def _correction(diagnosis: Diagnosis) -> dict[str, Any] | None:
    """What an interpolation of an unexplained mismatch would gain; it is no physics, and no part of the model."""
    correction = diagnosis.correction
    if correction is None:
        return None
    return {
        "test_before": correction.test_before,
        "test_after": correction.test_after,
        "helps": correction.helps,
        "file": "correction.csv",
    }


def correction_frame(diagnosis: Diagnosis) -> pd.DataFrame:
    """The smooth correction of every row, to be added to the prediction, in the units of the readings."""
    recordings = diagnosis.recordings
    assert diagnosis.correction is not None
    values = diagnosis.correction.correction * diagnosis.noise.deviations
    names = [recordings.components(diagnosis.robot.coordinates)[axis] for axis in recordings.axes]
    columns: dict[str, object] = {"sequence": recordings.sequence}
    columns |= {f"correction_{name}": values[:, i] for i, name in enumerate(names)}
    return pd.DataFrame(columns)


def _effect(finding: Finding) -> dict[str, Any]:
    record: dict[str, Any] = {
        "physics": finding.physics,
        "component": finding.component,
        "variant": finding.variant,
        "parameters": {name: [_finite(v) for v in values] for name, values in finding.parameters.items()},
        "probability": finding.probability,
        "indistinguishable_from": list(finding.indistinguishable),
        "sentence": finding.sentence,
    }
    if finding.gain is not None:
        gain = finding.gain
        record["held_out"] = {"without": gain.without, "with": gain.with_it, "p_value": gain.p_value}
    if finding.rows:
        record["rows"] = list(finding.rows)
    return record


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) and abs(value) < 1e299 else None


def _location(diagnosis: Diagnosis) -> dict[str, Any] | None:
    if diagnosis.verdict == "consistent":
        return None
    location = diagnosis.location
    components = list(dict.fromkeys(finding.component for finding in diagnosis.findings))
    if not components or diagnosis.verdict == "unexplained":
        components = components or [location.components[0].name]
    excess = max(diagnosis.base.chi2 - (diagnosis.search.sample.readings - diagnosis.base.rank), 1e-300)
    if diagnosis.findings:
        share = (diagnosis.base.chi2 - diagnosis.model.fit.chi2) / excess
    else:
        share = (location.components[0].explained - location.components[0].dimension) / excess
    return {
        "component": components[0] if len(components) == 1 else components,
        "axes": list(location.axes),
        "region": location.region,
        "share": float(np.clip(share, 0.0, 1.0)),
        "probes": [
            {"name": p.name, "explained": p.explained, "dimension": p.dimension, "p_value": p.p_value}
            for p in (*location.components, *location.patterns)
            if p.p_value < LEVEL
        ],
    }
