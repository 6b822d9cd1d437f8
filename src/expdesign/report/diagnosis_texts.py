"""What a diagnosis says: as `diagnosis.json` (file-formats.md, diagnosis.json), and in words on page and terminal.

Here stand the sentences of the verdict, the mismatch and the probability of a finding. Those of caveats and doubts are
in `remark_texts.py`, of the fits in `fit_texts.py`, of an effect in its class (`says`; `chain/effects`), of laws and
outliers in `diagnosis/law_findings.py` and `diagnosis/findings.py`.
"""

import re
from typing import Any

import numpy as np

from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.law_findings import curve_file
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.result import Diagnosis
from expdesign.probabilities import SMALLEST, probability_text
from expdesign.report import words
from expdesign.report.fit_texts import coverage_sentence
from expdesign.report.physics_words import physics_words
from expdesign.report.remark_texts import sentences

_ERRORS = ("train_before", "train_after", "test_before", "test_after", "test_surprise")
_RECORDED = 0.001
"""Probability from which `diagnosis.json` lists a place of a law."""


def diagnosis_record(diagnosis: Diagnosis, next_experiment: str | None) -> dict[str, Any]:
    """The document of a diagnosis."""
    errors = diagnosis.errors
    stable = diagnosis.stability
    return {
        "verdict": diagnosis.verdict,
        **({"ended": diagnosis.ended} if diagnosis.ended else {}),
        "method": {"name": diagnosis.method.name, "reason": diagnosis.method.reason},
        "tests": {
            f"{name}{when}": getattr(statement, name)
            for when, statement in (("", diagnosis.before), ("_after", diagnosis.after))
            for name in ("chi2", "dof", "p_value")
        },
        "statement": diagnosis.before.record,
        "statement_after": diagnosis.after.record,
        "location": _location(diagnosis),
        "effects": [_effect(diagnosis, finding) for finding in diagnosis.findings],
        "fit": {
            "noise_rms": 1.0,
            **{name: getattr(errors, name) for name in _ERRORS},
            "held_out": errors.how,
            "coverage_95": _finite(errors.coverage),
            "written_difference": _finite(diagnosis.written_difference),
        },
        "stability": None if stable is None else {"refits": stable.refits, "same": stable.same},
        "load_errors": None if diagnosis.loads is None else diagnosis.loads.record,
        "caveats": sentences((*diagnosis.doubts, *diagnosis.caveats)),
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
    if finding.depends_on:
        record["depends_on"] = list(finding.depends_on)
        record["curve"] = curve_file(diagnosis.findings, finding)
        if finding.curve is not None:
            record["quantity"] = finding.curve.meaning
    if finding.gain is not None:
        gain = finding.gain
        record["held_out"] = {"without": gain.rms_before, "with": gain.rms_after, "p_value": gain.p_value}
    further = {
        "form": finding.form,
        "share": finding.share,
        "named_by_refits": finding.named_by,
        "elsewhere": list(finding.elsewhere),
        "rows": list(finding.rows),
    }
    return record | {key: value for key, value in further.items() if value not in (None, "", [])}


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) and abs(value) < 1e299 else None


def candidates(diagnosis: Diagnosis) -> list[dict[str, Any]]:
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
        if place.probability >= _RECORDED
    ]


def located(diagnosis: Diagnosis) -> list[str]:
    """Components that the mismatch points to, the most likely first."""
    places = candidates(diagnosis)
    components = list(dict.fromkeys(finding.component for finding in diagnosis.findings))
    drawn = any(finding.depends_on for finding in diagnosis.findings)
    if diagnosis.verdict == "unexplained" and not drawn:
        # Named physics that does not explain imitates something; where that is, laws of any form tell better.
        components = [c["component"] for c in places[:1]] or components
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
        "candidates": candidates(diagnosis),
        "axes": list(location.axes),
        "region": location.region,
        "share": float(np.clip(share, 0.0, 1.0)),
        "probes": [
            {"name": p.name, "explained": p.explained, "dimension": p.dimension, "p_value": p.p_value}
            for p in (*location.components, *location.patterns)
            if p.p_value < OPTIONS.level
        ],
    }


VERDICTS = {
    "consistent": "These recordings show no missing physics.",
    "explained": "The base model does not explain these recordings. With the physics named below it does.",
    "modelled": "Neither the base model nor named physics explains these recordings. Laws at the places named below, "
    "identified from the recordings, do.",
    "unexplained": "The model lacks physics that the library does not have. The mismatch is located below.",
}
"""What is said of each verdict (`diagnosis/verdict.py`), behind `Verdict: …` on the page and the terminal."""
IN_DOUBT = "No known physics explains these recordings as they are. Check the recordings first."
_COLUMN = re.compile(r"\b([a-z]+\d*)_(?:m|rad|N|Nm)\b")
"""A column of a pose, a load or a deflection, which prose names without its unit."""


def held_out_sentences(result: Diagnosis) -> list[str]:
    """How well rows that were not fitted are predicted, and how often refits to fewer rows name the same."""
    texts, errors, stable = [], result.errors, result.stability
    if result.findings:
        texts.append(
            f"Held-out recordings ({errors.how}) are predicted to {words.number(errors.test_after)} standard "
            f"deviations, without this physics to {words.number(errors.test_before)}; 1 is the noise."
        )
    if stable is not None and all(one.named_by is None for one in result.findings):
        texts.append(
            f"The same is named in {100.0 * stable.same:.0f} % of {stable.refits} refits, each without a tenth of the "
            "rows."
        )
    if np.isfinite(errors.coverage):
        texts.append(coverage_sentence(errors.coverage, loads=result.loads is not None))
    return texts


def finding_sentence(finding: Finding) -> str:
    """What was found, how probable it is, and what it may be instead."""
    probable = _how_probable(finding)
    text = f"{finding.sentence} {probable[0].upper()}{probable[1:]}{_instead(finding)}."
    if finding.named_by is not None:
        text += f" It is named in {100.0 * finding.named_by:.0f} % of the refits, each without a tenth of the rows."
    return text


def _how_probable(finding: Finding) -> str:
    """The probability of an effect that is kept; what is kept and next to impossible stands in for something else."""
    if finding.probability < SMALLEST:
        return "kept because the rows are described better with it, although another place or cause is likelier"
    return f"probability {probability_text(finding.probability, 2)}"


def _instead(finding: Finding) -> str:
    others = [physics_words(name, finding.component) for name in finding.indistinguishable]
    text = f"; these recordings do not distinguish it from {', '.join(others)}" if others else ""
    if finding.elsewhere:
        text += f"; they do not tell whether it is there or at {', '.join(finding.elsewhere)}"
    return text


def mismatch(result: Diagnosis) -> str:
    """On which axes the mismatch shows, where it most likely comes from, and with what it varies."""
    axes = (
        words.listed([words.axis(name) for name in result.location.axes]) if result.location.axes else "no axis alone"
    )
    region = result.location.region
    region = in_prose(region if region.startswith("varies") else f"is {region}")
    return f"The mismatch appears in {axes} and points to {words.listed(located(result))}; it {region}."


def next_recording(result: Diagnosis) -> list[str]:
    """What to do about a mismatch that nothing explains; nothing where the recordings are in doubt before the robot."""
    if result.verdict != "unexplained" or result.doubts:
        return []
    return [f"Inspect {words.listed(located(result))}, and record more loads and poses there."]


def in_prose(text: str) -> str:
    """A text with `ry` for `ry_rad`."""
    return _COLUMN.sub(r"\1", text)
