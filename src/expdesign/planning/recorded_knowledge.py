"""What recordings say about what is calibrated, in the form in which further measurements can be added to it."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.estimation.identify import Identification, fitted_rows, identify
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.information import Information
from expdesign.planning.problem import DesignProblem


def recorded_knowledge(problem: DesignProblem, recordings: Recordings, loads: FloatArray | None) -> Information:
    """Information and load errors of recordings.

    Standard deviations are those of the recordings; where they state none they are estimated, or, where the recordings
    are too few for that, those of the configuration.

    Args:
        problem: the robot and its sources of load error.
        recordings: what was measured; rows held out for testing do not count.
        loads: load parameters of every row (N, k) in the order of the recordings; None where there are no load errors.

    Raises:
        InputError: the noise is not known.
    """
    loaded, robot = problem.loaded, problem.loaded.robot
    fitted = fitted_rows(recordings)
    train = recordings.rows(fitted)
    deviations = train.deviations if train.deviations is not None else estimated_deviations(problem, recordings, train)
    whitening = Whitening(deviations, references=train.references)
    jacobians = robot.jacobians(train.configurations)
    measured = loaded.under(Wrench(robot.coordinates)).measure(train.configurations, train.wrenches)
    observation = measured.observation[:, train.axes] * loaded.scale
    rows = whitening.apply(observation)
    count = rows.shape[-1]
    # The whitening of the readings, transposed, so that every row's load error meets all that it is whitened with.
    gain = whitening.apply(rows * deviations[..., None]) / deviations[..., None]
    own = np.zeros((count, count))
    common = [np.zeros((count, 0))]
    if loads is not None:
        for source, error in zip(loaded.sources, loaded.wrenches(jacobians.rotation, loads[fitted])[1], strict=True):
            moved = (measured.compliance @ error)[:, train.axes]
            seen = gain.swapaxes(-1, -2) @ moved
            if source.shared:
                common.append(seen.sum(axis=0))
            else:
                flat = seen.swapaxes(0, 1).reshape(count, -1)
                own += flat @ flat.T
    root = rows.reshape(-1, count)
    if len(root) > count:
        root = np.asarray(np.linalg.qr(root, mode="r"))
    return Information(root, np.concatenate(common, axis=-1), own)


def require_readings_of(problem: DesignProblem, recordings: Recordings) -> None:
    """Raise where the recordings are not of what the configuration calibrates: poses for geometry, else deflections.

    Raises:
        InputError: which columns are missing.
    """
    geometry = not problem.loaded.regressor.referenced
    if geometry == recordings.poses:
        return
    wanted, columns = ("measured poses", "measured_x_m ...") if geometry else ("deflections", "dx_m ...")
    what = f"the configuration calibrates the {problem.loaded.regressor.noun}, and these are no {wanted}"
    remedy = f"Give {wanted} (columns {columns}), or change `experiment.calibration`."
    raise InputError(what, where=recordings.source, remedy=remedy)


def identified_so_far(problem: DesignProblem, recordings: Recordings) -> Identification:
    """What the recordings identify of what the configuration calibrates; raises as `identify` does."""
    regressor = problem.loaded.regressor
    known = regressor.redundant == 0
    return identify(problem.loaded.robot, recordings, calibration=regressor.calibration, frames_known=known)


def estimated_deviations(problem: DesignProblem, recordings: Recordings, train: Recordings) -> FloatArray:
    """Estimated standard deviations, or those of the configuration."""
    try:
        return identified_so_far(problem, recordings).noise.deviations
    except NotIdentifiableError:
        pass
    stated = dict(zip(problem.noise.axes.tolist(), np.sqrt(np.diag(problem.noise.covariance)), strict=True))
    missing = [axis for axis in train.axes.tolist() if axis not in stated]
    if missing:
        name = problem.loaded.robot.coordinates.deviation[missing[0]]
        what = "the standard deviation is neither stated nor in the configuration, and cannot be estimated"
        raise InputError(what, where=f"{recordings.source}, column {name}", remedy="Add the column.")
    return np.tile([stated[axis] for axis in train.axes.tolist()], (len(train), 1))
