"""The diagnosis of a machine with many small errors, or of what a body stands on: by groups of effects and laws.

To name causes one at a time is right where few things are wrong. Where ten are a little wrong it stops early, and what
it has named by then imitates the rest. Which of the two the recordings call for is decided by left-out blocks: where
one or two groups predict them nearly as well as all together do, these have to predict better than named effects.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.findings import set_aside
from expdesign.diagnosis.frame import Frame
from expdesign.diagnosis.group_library import groups_of
from expdesign.diagnosis.groups import Groups, grouped
from expdesign.diagnosis.held_out import HeldOut, held_out
from expdesign.diagnosis.law_findings import group_findings
from expdesign.diagnosis.names import NamedModel
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.result import TOGETHER, Diagnosis, Method
from expdesign.diagnosis.stages import Stage


@dataclass(frozen=True)
class ByGroups:
    """What groups of effects come to.

    Attributes:
        frame: what is diagnosed.
        groups: that are there.
        errors: of them, on rows that were not fitted.
    """

    frame: Frame
    groups: Groups
    errors: HeldOut

    @property
    def alone(self) -> bool:
        """Whether single causes need not be looked for: more than two groups are needed, and predict to the noise."""
        return not self.groups.few and self._predicts

    @property
    def _predicts(self) -> bool:
        """Whether rows that were not fitted are predicted to the noise."""
        return max(self.errors.test_surprise, self.errors.test_after) <= OPTIONS.predicts

    def beats(self, named: LeftOut) -> bool:
        """Whether left-out blocks are predicted better than by named effects."""
        return self.groups.after < OPTIONS.better * named.rms_after

    def diagnosis(self, reason: str) -> Diagnosis:
        """The diagnosis by these groups, which has a reason."""
        groups, frame = self.groups, self.frame.without(self.groups.aside)
        model = NamedModel((), groups.fit, float("nan"))
        verdict = "modelled" if self._predicts else "unexplained"
        frame.names.log.add("verdict", f"groups of effects: {len(groups.found)}; verdict {verdict}")
        found = (*group_findings(groups, frame.robot, frame.known), *set_aside(frame.recordings, groups.aside))
        result = frame.diagnosis(model, verdict, self.errors, Method(TOGETHER, reason), model)
        return replace(result, findings=found, left_out=groups.widening, stability=groups.stability)


def by_groups(frame: Frame) -> tuple[ByGroups | None, str]:
    """Groups of effects and laws where the recordings call for them, and why they do or do not."""
    base, sample, robot = frame.base, frame.names.sample, frame.robot
    many = not frame.kind.elastic and len(robot.stiffness) > 0
    count = int(sample.counts.sum())
    excess = float(np.sqrt(base.chi2 / max(sample.readings - base.rank, 1)))
    if not (many or robot.on_support):
        return None, "deflections are measured, and only what yields under load contributes to them"
    if excess < OPTIONS.noticeable:
        return None, f"the base model leaves {excess:.3g} standard deviations, too little to tell groups apart"
    if count < (least := OPTIONS.groups * OPTIONS.fewest_rows):
        return None, f"{count} rows are too few for groups of effects ({least} are needed)"
    frame.names.report(Stage.GROUPS, "")
    found = grouped(robot, sample, base, groups_of(robot, sample, base, frame.names.library))
    if found is None:
        return None, "no group of effects is worth its evidence"
    judged = _errors(found, frame)
    errors = f"left-out blocks: {found.before:.3g} standard deviations without effects, {found.after:.3g} with groups"
    if OPTIONS.clearly * found.after > found.before or judged.test_after >= judged.test_before:
        return None, f"groups of effects predict no better ({errors})"
    several = (
        "1 group of effects predicts" if len(found.found) == 1 else f"{len(found.found)} groups of effects predict"
    )
    return ByGroups(frame, found, judged), f"{several} best ({errors})"


def _errors(groups: Groups, frame: Frame) -> HeldOut:
    """On rows marked `test`, or else on left-out blocks."""
    base, sample, test = frame.base, frame.names.sample, frame.judged
    if test.any():
        kept = sample.restricted(~groups.aside)
        return held_out(base, groups.fit, kept, test, known_noise=frame.noise.known, later=False)
    train = [float(np.sqrt((f.residuals**2).sum() / sample.readings)) for f in (base, groups.fit)]
    surprise = groups.after / max(groups.noise, 1.0)
    return HeldOut(train[0], train[1], groups.before, groups.after, surprise, "blocks left out, the groups as they are")
