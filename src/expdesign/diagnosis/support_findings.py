"""Laws of what a body stands on, as findings."""

from expdesign.chain.component import BASE
from expdesign.chain.ports.words import FORMS, columns, depends_on, identifier, usually
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.law_findings import LawFinding
from expdesign.diagnosis.support_laws import Support, SupportGroup
from expdesign.mechanics.robots.robot import Robot


def support_findings(support: Support, robot: Robot) -> tuple[Finding, ...]:
    """One finding per group, the largest first."""
    return tuple(_finding(group, robot) for group in support.groups)


def _finding(group: SupportGroup, robot: Robot) -> LawFinding:
    form = group.laws[0].form
    seen = [q for channel in form.channels for q in (*channel.inputs, channel.amplitude) if q is not None]
    seen = [q for q in dict.fromkeys(seen) if q.kind not in ("rest", "overlap")]
    names = depends_on(tuple(seen), robot)
    text = (
        f"What the body stands on {FORMS[group.form]} {', '.join(names)}: {group.size:.2g} standard deviations of the "
        f"readings RMS, {group.determined:.0f} weights determined; {usually(group.form)}."
    )
    identifiers = tuple(dict.fromkeys(identifier(q, robot) for q in seen))
    shown = () if group.curve is None else columns(group.curve.quantities, robot)
    return LawFinding(
        "law", str(BASE), group.form, {}, group.probability(beside_laws=False), (), text,
        depends_on=identifiers, columns=shown, curve=group.curve,
    )  # fmt: skip
