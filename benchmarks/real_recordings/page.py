"""The page of one file, in words, tables and curves (HTML); no recordings in it."""

from pathlib import Path

from benchmarks.real_recordings.figures import drawn
from benchmarks.real_recordings.sets import NOTICES, Case
from benchmarks.real_recordings.transfer import Transfer
from markdown_it import MarkdownIt

from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.law_findings import LawFinding
from expdesign.diagnosis.result import Diagnosis
from expdesign.estimation.identify import Identification
from expdesign.report.identification_tables import rms
from expdesign.report.remark_texts import sentences

_MOST_PARAMETERS = 12


def page(case: Case, identified: Identification, result: Diagnosis, others: list[Transfer], readme: Path) -> str:
    """The page as HTML."""
    errors = result.errors
    rows = [
        f"# {case.folder}: `{case.file}`" + (f" with `{case.robot}`" if case.robot != "robot.yaml" else ""),
        "",
        f"Made by `python -m benchmarks.real_recordings {case.name}` (recordings as `{case.folder}/{case.file}.csv`).",
        "",
        NOTICES.get(case.folder) or notice(readme),
        "",
        "## Result",
        "",
        f"- Verdict: **{result.verdict}**.",
        f"- Way of working: {result.method.name}; {result.method.reason}.",
        f"- Held-out rows ({errors.how}): {errors.test_before:.3g} standard deviations RMS with the base model, "
        f"**{errors.test_after:.3g}** with the physics below; fitted rows {errors.train_before:.3g} and "
        f"{errors.train_after:.3g}. 1 is the noise as the recordings state it.",
        f"- {_against(case, errors.test_after)}",
        f"- Located: {', '.join(p.name for p in result.location.components if p.p_value < 0.01) or 'nowhere'}; the "
        f"mismatch of the base model {result.location.region}.",
        f"- `identify`: {_identified(identified)}",
        *(f"- {text}" for text in sentences(result.caveats)),
        f"- Remainder: {_remainder(result)}",
        "",
        "## Physics that was added",
        "",
        *_effects(result),
    ]
    if others:
        rows += [
            "",
            "## The same model under other conditions",
            "",
            _OF_POSITIONS if result.recordings.marker is not None else _OF_DEFLECTIONS,
            "",
            "| file | base model | this model |",
            "| --- | --- | --- |",
            *(f"| `{other.file}` | {other.before:.3g} | {other.after:.3g} |" for other in others),
        ]
    body = MarkdownIt("commonmark", {"html": True}).enable("table").render("\n".join(rows))
    return f"{_HEAD.format(title=case.name)}{body}</body></html>\n"


_HEAD = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.5 sans-serif; max-width: 62em; margin: 2em auto; padding: 0 1em; color: #222; }}
table {{ border-collapse: collapse; }} td, th {{ border: 1px solid #ccc; padding: 0.2em 0.7em; text-align: left; }}
code {{ background: #f2f2f2; }} figure {{ margin: 0.5em 0 1.5em; }} figcaption {{ color: #555; }}
</style></head><body>
"""

_OF_DEFLECTIONS = "RMS of all rows of the other files in standard deviations, nothing fitted to them:"
_OF_POSITIONS = (
    "RMS of the test rows of the other files in standard deviations; of the other files' training rows only the pose "
    "of the instrument was fitted, which was set up anew for each:"
)


def _against(case: Case, after: float) -> str:
    """The result beside what was aimed at and what is known to be possible."""
    if case.target is None:
        return "No target was set for this file."
    reached = "reached" if after <= case.target else "**not reached**"
    best = "" if case.known is None else f"; best known before: {case.known:.3g}"
    return f"Target for held-out rows: at most {case.target:.3g}, {reached}{best}."


def notice(readme: Path) -> str:
    """The lines on source and licence of a set's own README."""
    text = readme.read_text(encoding="utf-8")
    section = text.split("## Source and licence")[1].split("\n## ")[0].strip()
    kept = [line for line in section.splitlines() if line.startswith("-")]
    return "\n".join([*kept, "- This page holds no recordings."])


def _identified(identified: Identification) -> str:
    if not identified.robot.actuators:
        after = rms(identified.test_residuals)
        return (
            "a body has no actuators whose stiffness could be identified; that it does not deflect at all is refuted "
            f"(χ² {identified.fit.chi2:.4g} for {identified.fit.dof}; held-out rows {after or float('nan'):.3g})."
        )
    parts = []
    for index, name in enumerate(identified.robot.actuators):
        low, high = identified.stiffness.low[index], identified.stiffness.high[index]
        parts.append(f"{name} {identified.stiffness.estimate[index]:.3g} ({low:.3g} to {high:.3g})")
    return f"{'; '.join(parts)} ({'N/m or N·m/rad'}, 95 %); {' '.join(sentences(identified.suspicions))}".strip()


def _remainder(result: Diagnosis) -> str:
    errors = result.errors
    if errors.test_after <= 1.1:
        return "none that held-out rows show above the stated noise."
    share = (errors.test_after**2 - 1.0) / max(errors.test_before**2 - 1.0, 1e-9)
    text = f"{100 * max(share, 0.0):.2g} % of the excess of the held-out mean square over the stated noise"
    return text + "."


def _effects(result: Diagnosis) -> list[str]:
    if not result.findings:
        return ["None."]
    rows = []
    for finding in result.findings:
        name = f"`{finding.physics}` at {finding.component}" + (f", {finding.variant}" if finding.variant else "")
        rows += [f"### {name}", "", finding.sentence, ""]
        rows.append(f"- Probability {finding.probability:.2f}{_beside(finding)}.")
        if finding.gain is not None:
            gain = finding.gain
            rows.append(
                f"- By itself: held-out rows {gain.without:.3g} without it, {gain.with_it:.3g} with it "
                f"(p = {gain.p_value:.2g}, over blocks of rows)."
            )
        known = [(n, v) for n, v in finding.parameters.items() if not _undetermined(result, finding, n, v)]
        for parameter, (value, low, high) in known[:_MOST_PARAMETERS]:
            rows.append(f"- `{parameter}` = {value:.3g} ({low:.3g} to {high:.3g})")
        left = len(finding.parameters) - min(len(known), _MOST_PARAMETERS)
        if left:
            rows.append(f"- {left} further parameters, {len(finding.parameters) - len(known)} of them not determined.")
        rows.append("")
        if isinstance(finding, LawFinding) and finding.curve is not None:
            rows += [drawn(finding.curve, finding.columns), ""]
    return rows[:-1]


def _undetermined(result: Diagnosis, finding: Finding, name: str, value: tuple[float, float, float]) -> bool:
    """Whether an interval is all that is possible."""
    if abs(value[2]) > 1e299:
        return True
    effect = next(
        (e for e in result.model.effects if (e.physics, str(e.component), str(e.variant)) == _key(finding)), None
    )
    bounds = {} if effect is None else {p.name: (p.low, p.high) for p in effect.parameters}
    return name in bounds and value[1:] == bounds[name] and value[1] != value[2]


def _key(finding: Finding) -> tuple[str, str, str]:
    return finding.physics, finding.component, finding.variant


def _beside(finding: Finding) -> str:
    if not finding.indistinguishable:
        return ""
    return f"; these recordings cannot tell it from {', '.join(finding.indistinguishable)}"
