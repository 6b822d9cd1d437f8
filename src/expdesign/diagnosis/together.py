"""The diagnosis of a machine with many small errors: all effects at once, reported by groups.

To name causes one at a time is right where few things are wrong. Where ten are a little wrong it stops early, and what
it has named by then imitates the rest. Which of the two the recordings call for is decided by left-out blocks: if one
or two groups of effects predict them nearly as well as all together do, causes are sought one at a time.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from expdesign.arrays import BoolArray
from expdesign.chain.component import ALL_JOINTS, GEOMETRY
from expdesign.chain.ports.words import columns, identifier
from expdesign.diagnosis.at_once import AtOnce
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.law_findings import LawFinding
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.many import Group, Many, many_effects, many_laws, start_with_everything
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.sample import Sample
from expdesign.estimation.fit import Fit
from expdesign.mechanics.robots.robot import Robot

ONE_AT_A_TIME, TOGETHER, LAWS = "one effect at a time", "all effects at once", "laws at ports"
"""Ways of working, as `method` says them."""


@dataclass(frozen=True)
class Method:
    """The way of working that the data call for, and why."""

    name: str
    reason: str


def together(
    robot: Robot, sample: Sample, base: Fit, library: list[Candidate], report: Callable[[str], None]
) -> tuple[Many | None, Method]:
    """All effects at once, where the recordings call for it, and which way of working they do call for."""
    if not (base_model(robot, sample.reading).several_at_once and len(robot.stiffness)):
        return None, Method(ONE_AT_A_TIME, "deflections are measured, to which only what yields contributes")
    count = int(sample.counts.sum())
    excess = float(np.sqrt(base.chi2 / max(sample.readings - base.rank, 1)))
    if excess < OPTIONS.all_excess:
        why = f"the base model leaves {excess:.3g} standard deviations, too little to tell many effects apart"
        return None, Method(ONE_AT_A_TIME, why)
    if count < OPTIONS.all_rows:
        why = f"{count} rows are too few for all effects at once ({OPTIONS.all_rows} are needed)"
        return None, Method(ONE_AT_A_TIME, why)
    laws = many_laws(robot, sample, base)
    found = start_with_everything(robot, sample, base, (*many_effects(library), *laws), report)
    errors = f"left-out blocks: {found.before:.3g} standard deviations without effects, {found.after:.3g} with all"
    if found.few:
        return None, Method(ONE_AT_A_TIME, f"one or two groups of effects do nearly what all do together ({errors})")
    if found.after > OPTIONS.all_gains * found.before:
        return None, Method(ONE_AT_A_TIME, f"all effects at once predict no better ({errors})")
    why = f"no two groups of effects predict nearly as well as {len(found.groups)} groups together ({errors})"
    return found, Method(TOGETHER, why)


def errors_together(many: AtOnce, base: Fit, sample: Sample, test: BoolArray, *, known_noise: bool) -> HeldOut:
    """On rows marked `test`, or else on left-out blocks."""
    if test.any():
        return held_out(
            base, many.fit, sample, test, many.aside, known_noise=known_noise, scatter=many.after, later=False
        )
    train = [float(np.sqrt((f.residuals**2).sum() / sample.readings)) for f in (base, many.fit)]
    surprise = many.after / max(many.noise, 1.0)
    return HeldOut(train[0], train[1], many.before, many.after, surprise, "blocks left out, the groups as they are")


def verdict_together(errors: HeldOut) -> str:
    """`modelled` where rows that were not fitted are predicted to the noise."""
    return "modelled" if max(errors.test_surprise, errors.test_after) <= OPTIONS.predicts else "unexplained"


def group_findings(many: Many) -> tuple[Finding, ...]:
    """One finding per group, the largest first."""
    robot = many.fit.chain.robot
    laws = any(group.curve is not None for group in many.groups)
    pairs = zip(many.groups, many.stability.shares, strict=True)
    return tuple(_finding(group, share, robot, beside_laws=laws) for group, share in pairs)


def _finding(group: Group, share: float, robot: Robot, *, beside_laws: bool) -> Finding:
    where = _where(group.components)
    text = (
        f"{group.name[0].upper()}{group.name[1:]}: together {group.size:.2g} standard deviations of the readings RMS, "
    )
    text += f"{group.determined:.0f} parameter{'s' * (round(group.determined) != 1)} determined"
    if group.told_apart:
        text += f"; told apart (95 %): {', '.join(group.told_apart)}"
    else:
        text += "; its members are not told apart"
    if group.curve is None:
        probability = group.probability(beside_laws=beside_laws)
        return Finding(group.physics, where, group.name, {}, probability, (), text + ".", share=share)
    seen = group.curve.quantities
    return LawFinding(
        group.physics, where, group.name, {}, group.probability(beside_laws=False), (), text + ".",
        depends_on=tuple(dict.fromkeys(identifier(q, robot) for q in seen)), columns=columns(seen, robot),
        curve=group.curve, share=share,
    )  # fmt: skip


def _where(components: tuple[str, ...]) -> str:
    """One component for a group: all joints, or the geometry, which links belong to."""
    if len(components) == 1:
        return components[0]
    return str(ALL_JOINTS if all(name.startswith("joint") for name in components) else GEOMETRY)
