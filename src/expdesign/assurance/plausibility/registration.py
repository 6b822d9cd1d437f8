"""How well absolute readings go with the robot as drawn: the misfit of recordings read in one way or another.

The instrument is registered and the markers are placed for the nominal robot. The misfit has two parts: the RMS of what
the registration leaves of positions in parts of their spread, below a per cent for any machine that was built and near
one where a frame is left-handed, since no rotation maps a mirrored cloud of points onto the other; and the RMS angle
that is left between measured orientations and the registered robot's.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.readings.registration import registration_residuals
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import NotIdentifiableError
from expdesign.mechanics.robots.robot import Robot

POOR = 0.05
"""Share of the spread of positions that a registration of a robot as drawn leaves only for a mistake."""
TURNED = 0.1
"""rad (RMS); orientations that differ by more from those of the robot as drawn are written otherwise."""
FEWEST = 8
"""Rows below which a registration fits anything."""
ROWS = 120
"""With which readings of the recordings are compared."""


@dataclass(frozen=True)
class Misfit:
    """What registration leaves.

    Attributes:
        left: RMS distance (m), at most the spread, as if the instrument saw one point.
        spread: RMS distance of the readings from their mean (m).
        angle: RMS angle (rad), 0 where no orientations were measured.
        turned: whether some were.
    """

    left: float
    spread: float
    angle: float
    turned: bool

    @property
    def share(self) -> float:
        """Of the spread of the positions."""
        return self.left / self.spread

    @property
    def size(self) -> float:
        """1 where the recordings need an explanation."""
        return max(self.share / POOR, self.angle / TURNED)

    @property
    def sentence(self) -> str:
        """It in figures."""
        angle = f" and {np.degrees(self.angle):.2g}°" if self.turned else ""
        return f"{1e3 * self.left:.3g} mm ({100 * self.share:.2g} % of the spread of the positions){angle}"


def spread_of(points: FloatArray) -> float:
    """RMS distance of points (N, d) from their mean."""
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def placed(recordings: Recordings) -> Recordings:
    """Rows of which all coordinates of a position were read, with their orientations, without distances and gauges."""
    kept = np.flatnonzero(recordings.axes < 6)
    deviations = None if recordings.deviations is None else recordings.deviations[:, kept]
    plain = replace(
        recordings, point=None, fixed=(), along=None, axes=recordings.axes[kept], deviations=deviations,
        deflections=recordings.deflections[:, kept],
    )  # fmt: skip
    return plain.rows(np.flatnonzero(np.isfinite(plain.deflections[:, :3]).all(axis=1)))


def some(recordings: Recordings) -> Recordings:
    """Fitted rows, spread evenly, with which readings of recordings are compared."""
    fitted = np.flatnonzero(~recordings.test)
    return recordings.rows(fitted[:: -(-len(fitted) // ROWS) or 1])


def registered(train: Recordings, robot: Robot) -> MarkerPosition | None:
    """The registered instrument and its markers; None where nothing can be registered."""
    if len(train) < FEWEST:
        return None
    try:
        reading = reading_of(robot, train)
    except NotIdentifiableError:
        return None
    assert isinstance(reading, MarkerPosition)
    return reading


def left_of(train: Recordings, robot: Robot) -> FloatArray | None:
    """What registration leaves of every position (m), shape (N, 3); None where nothing can be registered."""
    reading = registered(train, robot)
    return None if reading is None else registration_residuals(reading, robot, train)


def misfit_of(recordings: Recordings, robot: Robot) -> Misfit | None:
    """Of `some` of the rows that `placed` returns; None where nothing can be registered."""
    train = some(recordings)
    reading, spread = registered(train, robot), spread_of(train.deflections[:, :3]) if len(train) else 0.0
    if reading is None or spread == 0.0:
        return None
    left = registration_residuals(reading, robot, train)
    turned = np.isfinite(train.deflections).all(axis=1) & (train.deflections.shape[1] == 6)
    angle = 0.0
    if turned.sum() >= FEWEST:
        posed = train.rows(np.flatnonzero(turned))
        assert posed.aim is not None
        expected = reading.orientations(robot, posed, reading.start)
        sizes = Rotation.from_matrix(expected @ posed.aim.swapaxes(1, 2)).magnitude()
        angle = float(np.sqrt((sizes**2).mean()))
    return Misfit(min(float(np.sqrt((left**2).sum(axis=1).mean())), spread), spread, angle, bool(turned.any()))
