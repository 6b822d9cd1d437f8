"""The same diagnosis of the fitted rows alone, as a laboratory would have it that marks no rows for testing."""

from dataclasses import dataclass

from benchmarks.real_recordings.transfer import everything

from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.result import Diagnosis
from expdesign.diagnosis.sample import rms
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Unmarked:
    """What the fitted rows alone say.

    Attributes:
        verdict: of the diagnosis.
        after: RMS of the residuals of the rows that it did not have, in standard deviations.
        common: how many effects (physics, component, form) both diagnoses have.
        different: how many only one of them has.
    """

    verdict: str
    after: float
    common: int
    different: int


def unmarked(robot: Robot, recordings: Recordings, marked: Diagnosis) -> Unmarked:
    """Diagnose the rows that are not marked `test` by themselves, and judge the model on those that are.

    Rows that were not there still count as history of their series when the model is judged.
    """
    result = diagnose(robot, recordings.rows(~recordings.test))
    found = result.model.fit
    residuals = everything(robot, recordings, found.chain.reading).residuals(found.chain, found.values)
    one, other = _names(marked), _names(result)
    return Unmarked(result.verdict, rms(residuals, recordings.test), len(one & other), len(one ^ other))


def form(finding: Finding) -> str:
    """Form of a finding without the range that its law is over."""
    return finding.variant.split(" over ")[0]


def _names(result: Diagnosis) -> set[tuple[str, str, str]]:
    return {(f.physics, str(f.component), form(f)) for f in result.findings}
