"""`diagnosis.json` (file-formats.md, diagnosis.json)."""

from typing import Any

import numpy as np

from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.law_findings import LawFinding, curve_file
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.result import Diagnosis
from expdesign.report.remark_texts import sentences

_LISTED = 0.001
"""Probability from which a component is listed."""


def diagnosis_record(diagnosis: Diagnosis, next_experiment: str | None) -> dict[str, Any]:
    """The document of a diagnosis."""
    errors = diagnosis.errors
    stable = diagnosis.stability
    return {
        "verdict": diagnosis.verdict,
        **({"ended": diagnosis.ended} if diagnosis.ended else {}),
        "method": {"name": diagnosis.method.name, "reason": diagnosis.method.reason},
        "tests": {
            "chi2": diagnosis.before.chi2,
            "dof": diagnosis.before.dof,
            "p_value": diagnosis.before.p_value,
            "chi2_after": diagnosis.after.chi2,
            "dof_after": diagnosis.after.dof,
            "p_value_after": diagnosis.after.p_value,
        },
        "statement": diagnosis.before.record,
        "statement_after": diagnosis.after.record,
        "location": _location(diagnosis),
        "effects": [_effect(diagnosis, finding) for finding in diagnosis.findings],
        "fit": {
            "noise_rms": 1.0,
            "train_before": errors.train_before,
            "train_after": errors.train_after,
            "test_before": errors.test_before,
            "test_after": errors.test_after,
            "test_surprise": errors.test_surprise,
            "held_out": errors.how,
            "coverage_95": _finite(errors.coverage),
        },
        "stability": None if stable is None else {"refits": stable.refits, "same": stable.same},
        "caveats": sentences(diagnosis.caveats),
        "next_experiment": next_experiment,
        "considered": diagnosis.names.log.entries,
    }


def _effect(diagnosis: Diagnosis, finding: Finding) -> dict[str, Any]:
    record: dict[str, Any] = {
        "physics": finding.physics,
        "component": finding.component,
        "variant": finding.variant,
        "parameters": {name: [_finite(v) for v in values] for name, values in finding.parameters.items()},
        "probability": finding.probability,
        "indistinguishable_from": list(finding.indistinguishable),
        "sentence": finding.sentence,
    }
    if isinstance(finding, LawFinding):
        record["depends_on"] = list(finding.depends_on)
        record["curve"] = curve_file(diagnosis.findings, finding)
        if finding.curve is not None:
            record["quantity"] = finding.curve.meaning
    if finding.gain is not None:
        gain = finding.gain
        record["held_out"] = {"without": gain.without, "with": gain.with_it, "p_value": gain.p_value}
    if finding.form:
        record["form"] = finding.form
    if finding.share is not None:
        record["share"] = finding.share
    if finding.named_by is not None:
        record["named_by_refits"] = finding.named_by
    if finding.rows:
        record["rows"] = list(finding.rows)
    return record


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) and abs(value) < 1e299 else None


def _candidates(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Components with log evidence and probability, of every law by what it explains, most probable first."""
    if diagnosis.laws is None:
        return []
    return [
        {
            "component": str(place.component),
            "law": number,
            "log_evidence": place.log_evidence,
            "probability": place.probability,
        }
        for number, part in enumerate(diagnosis.laws.parts, start=1)
        for place in part.places
        if place.probability >= _LISTED
    ]


def located(diagnosis: Diagnosis) -> list[str]:
    """Components that the mismatch points to, the most likely first."""
    candidates = _candidates(diagnosis)
    components = list(dict.fromkeys(finding.component for finding in diagnosis.findings))
    drawn = any(isinstance(finding, LawFinding) for finding in diagnosis.findings)
    if diagnosis.verdict == "unexplained" and not drawn:
        # Named physics that does not explain imitates something; where that is, laws of any form tell better.
        components = [c["component"] for c in candidates[:1]] or components
    if drawn and diagnosis.laws is not None:
        # A law is drawn where it predicts best; where it is, the evidence says.
        parts = [part for part in diagnosis.laws.parts if part.places]
        components = list(dict.fromkeys(str(part.places[0].component) for part in parts)) or components
    return components or [diagnosis.location.components[0].name]


def _location(diagnosis: Diagnosis) -> dict[str, Any] | None:
    if diagnosis.verdict == "consistent":
        return None
    location, components = diagnosis.location, located(diagnosis)
    excess = max(diagnosis.base.chi2 - (diagnosis.names.sample.readings - diagnosis.base.rank), 1e-300)
    if diagnosis.findings:
        share = (diagnosis.base.chi2 - diagnosis.model.fit.chi2) / excess
    else:
        share = (location.components[0].explained - location.components[0].dimension) / excess
    return {
        "component": components[0] if len(components) == 1 else components,
        "candidates": _candidates(diagnosis),
        "axes": list(location.axes),
        "region": location.region,
        "share": float(np.clip(share, 0.0, 1.0)),
        "probes": [
            {"name": p.name, "explained": p.explained, "dimension": p.dimension, "p_value": p.p_value}
            for p in (*location.components, *location.patterns)
            if p.p_value < OPTIONS.level
        ],
    }
