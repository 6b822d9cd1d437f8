"""The same diagnosis of the fitted rows alone, as a laboratory would have it that marks no rows for testing."""

from dataclasses import dataclass

import numpy as np

from expdesign.chain.row import row_data
from expdesign.diagnosis.diagnose import Diagnosis, diagnose
from expdesign.diagnosis.sample import Sample, rms
from expdesign.identification.fit import Data
from expdesign.identification.whitening import Whitening
from expdesign.recordings.recordings import Recordings
from expdesign.robots.robot import Robot


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
    assert recordings.deviations is not None
    whitening = Whitening(recordings.deviations, recordings.series)
    data = Data(recordings, row_data(recordings, robot), whitening, reading=found.chain.reading)
    residuals = Sample.of(data, np.ones(len(recordings), dtype=bool)).residuals(found.chain, found.values)
    one, other = _names(marked), _names(result)
    return Unmarked(result.verdict, rms(residuals, recordings.test), len(one & other), len(one ^ other))


def _names(result: Diagnosis) -> set[tuple[str, str, str]]:
    return {(f.physics, str(f.component), f.variant.split(" over ")[0]) for f in result.findings}
