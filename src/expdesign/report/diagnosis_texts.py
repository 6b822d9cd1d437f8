"""What a diagnosis says in words: the same on its page and in the terminal."""

import re
from collections.abc import Sequence

import numpy as np

from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.result import Diagnosis
from expdesign.probabilities import probability_text
from expdesign.report import words
from expdesign.report.check_texts import coverage_sentence, diagnosed_fit_sentences
from expdesign.report.diagnosis_record import located
from expdesign.report.remark_texts import sentences
from expdesign.report.stiffness import added_physics, diagnosed_stiffness, stiffness_lines

VERDICTS = {
    "consistent": "These recordings show no missing physics.",
    "explained": "The base model does not explain these recordings. With the physics named below it does.",
    "modelled": "Neither the base model nor named physics explains these recordings. Laws at the places named below, "
    "identified from the recordings, do.",
    "unexplained": "The model lacks physics that the library does not have. The mismatch is located below.",
}
MEASURE_NEXT = "Measure plan-next.csv: it separates the two remaining explanations."
_COLUMN = re.compile(r"\b([a-z]+\d*)_(?:m|rad)\b")
"""A column of a pose or a deflection, which prose names without its unit."""


def terminal_lines(result: Diagnosis, at_targets: Sequence[str] = ()) -> list[str]:
    """What `expdesign diagnose` prints, with what is said of targets in its place."""
    lines = [*ended_sentences(result), f"Verdict: {result.verdict}."]
    if result.verdict == "unexplained":
        lines += [mismatch(result), next_recording(result)]
    lines += [
        f"{one.sentence.rstrip('.')} (probability {probability_text(one.probability, 2)}){_instead(one)}."
        for one in result.findings
    ]
    if added_physics(result):
        lines += ["With this physics in the model:", *stiffness_lines(diagnosed_stiffness(result), result.robot)]
    lines += diagnosed_fit_sentences(result)
    lines += [coverage_sentence(result.errors.coverage)] if np.isfinite(result.errors.coverage) else []
    return [*lines, *at_targets, *([MEASURE_NEXT] if result.rival is not None else [])]


def ended_sentences(result: Diagnosis) -> list[str]:
    """That somebody ended the diagnosis before it was finished."""
    if not result.ended:
        return []
    return [
        f"Ended by hand during this step: {result.ended}. This is the best model so far; a finished diagnosis may "
        "differ."
    ]


def conclusions(result: Diagnosis, hidden: str | None) -> list[str]:
    """What the page says first: what may be hidden where nothing is missing, the verdict, and the findings."""
    texts = ended_sentences(result) + ([] if hidden is None else [hidden])
    texts.append(VERDICTS[result.verdict])
    texts += [_finding(one) for one in result.findings]
    if result.verdict != "consistent":
        texts.append(mismatch(result))
    texts += diagnosed_fit_sentences(result)
    errors = result.errors
    if result.findings:
        texts.append(
            f"Held-out recordings ({errors.how}) are predicted to {words.number(errors.test_after)} standard "
            f"deviations, without this physics to {words.number(errors.test_before)}; 1 is the noise."
        )
    if result.stability is not None and all(one.named_by is None for one in result.findings):
        stable = result.stability
        texts.append(
            f"{100.0 * stable.same:.0f} % of {stable.refits} refits, each without a tenth of the rows, name the same."
        )
    if np.isfinite(errors.coverage):
        texts.append(coverage_sentence(errors.coverage))
    texts += sentences(result.caveats)
    if not result.noise.known:
        texts.append("The recordings state no standard deviations: the verdict rests on held-out error.")
    return texts


def _finding(finding: Finding) -> str:
    text = f"{finding.sentence} Probability {probability_text(finding.probability, 2)}{_instead(finding)}."
    if finding.named_by is not None:
        text += f" {100.0 * finding.named_by:.0f} % of the refits, each without a tenth of the rows, name it."
    return text


def _instead(finding: Finding) -> str:
    others = ", ".join(name.replace("_", " ") for name in finding.indistinguishable)
    return f"; these recordings do not distinguish it from {others}" if others else ""


def mismatch(result: Diagnosis) -> str:
    """On which axes the mismatch shows, where it most likely comes from, and with what it varies."""
    axes = (
        words.listed([words.axis(name) for name in result.location.axes]) if result.location.axes else "no axis alone"
    )
    region = result.location.region
    region = in_prose(region if region.startswith("varies") else f"is {region}")
    return f"The mismatch appears in {axes} and points to {words.listed(located(result))}; it {region}."


def next_recording(result: Diagnosis) -> str:
    """What to do about a mismatch that nothing explains."""
    return f"Inspect {words.listed(located(result))}, and record more loads and poses there."


def in_prose(text: str) -> str:
    """A text with `ry` for `ry_rad`."""
    return _COLUMN.sub(r"\1", text)
