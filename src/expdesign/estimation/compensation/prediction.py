"""Predicted deflections with their standard deviations (theory.md 4.1: ε_X = −A·ε_c, with the effects of the model)."""

from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.estimable import SEQUENCE
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import MarkerPosition
from expdesign.chain.recordings.points import hanging
from expdesign.chain.recordings.recordings import DEFLECTIONS, LoadedPoints, Measurand
from expdesign.chain.row import row_data
from expdesign.estimation.compensation.target_loads import AttainedUncertainty, TargetLoads
from expdesign.io.table import Table
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Prediction:
    """Readings (m, rad), deflections in most cases, and their standard deviations, shape (N, n) each.

    Deviations are infinite where the recordings did not determine the model; `measurand` says what the readings are.
    With orientations of targets, `orientations` (N, 3, 3) are these in the instrument's axes, and the last three
    deviations those of a turn about them.
    """

    deflections: FloatArray
    deviations: FloatArray
    measurand: Measurand = DEFLECTIONS
    orientations: FloatArray | None = None


def chain_of(model: Model, *, platform: bool, from_command: bool = False) -> Chain:
    """The model's chain up to the instrument's reading, or only up to the motion of the platform (see `Chain`)."""
    chain = model.chain
    return Chain(chain.robot, chain.effects, instrument=not platform, from_command=from_command, reading=chain.reading)


def predict(
    model: Model, points: LoadedPoints, *, platform: bool = False, loads: TargetLoads | None = None
) -> Prediction:
    """Deflections at points, in the order of the points.

    Args:
        model: the identified robot.
        points: commands and loads.
        platform: the motion of the platform instead of the instrument's reading.
        loads: what the points carry where they are targets: errors of the recorded loads act there as `compensate` has
            them. Readings of other points leave these out, as the residuals of the recordings do.
    """
    model = model if loads is None else model.at_targets
    reading = model.chain.reading
    seen = None if platform else reading.at_points(points)
    if seen is not None:
        if isinstance(reading, MarkerPosition) and reading.oriented:
            seen = replace(seen, aim=reading.orientations(model.chain.robot, seen, model.values[_own(model)]))
        found = _predicted(chain_of(model, platform=False), model, seen, loads)
        turned = None
        if seen.aim is not None and found.deflections.shape[1] > 3:
            from scipy.spatial.transform import Rotation  # noqa: PLC0415 (slow to import, and few need it)

            turned = Rotation.from_rotvec(found.deflections[:, 3:6]).as_matrix() @ seen.aim
        return replace(found, measurand=seen.measurand, orientations=turned)
    return _predicted(chain_of(model, platform=True), model, without_markers(points), loads)


def _own(model: Model) -> slice:
    """Where the parameters of the reading lie."""
    return slice(model.chain.compliances, model.chain.base)


def without_markers(points: LoadedPoints) -> LoadedPoints:
    """The same points, at which no marker is looked at."""
    return replace(points, marker=None, markers=(), sites=(), stations=(), aim=None, point=None, fixed=(), along=None)


def _predicted(chain: Chain, model: Model, points: LoadedPoints, loads: TargetLoads | None) -> Prediction:
    """The prediction of a chain that has the parameters of the model."""
    if loads is not None:
        known = AttainedUncertainty.at(chain, model, points, loads)
        return Prediction(loads.motions(chain, model, points), known.deviations)
    deflections, sensitivities = chain.predict_with_sensitivities(row_data(points, chain.robot), model.values)
    return Prediction(deflections, model.estimable.deviations(sensitivities))


def after_campaign(model: Model, points: LoadedPoints) -> LoadedPoints:
    """Points that are visited after the recordings of a model, whatever their own numbers.

    A drift in the order of the rows has then reached where it was at the end of the campaign. Points stay as they are
    where the model does not depend on that order, or does not say when its campaign ended.
    """
    campaign = None if model.calibrated is None else model.calibrated.ranges.get(SEQUENCE)
    if campaign is None or not model.chain.counts_rows:
        return points
    return replace(points, sequence=np.full(len(points), int(campaign[1]) + 1))


def require_history(model: Model, table: Table) -> None:
    """Raise an `InputError` where the model depends on history that the table does not tell.

    What an effect depends on is read off its expression: states and elapsed time need series in their order, warming
    needs temperatures.
    """
    chain = model.chain
    row = chain.row_symbols()
    state, theta = ca.SX.sym("state", chain.states), ca.SX.sym("theta", len(chain.parameters))
    reading, following = chain.expression(row, state, theta)
    everything = ca.vertcat(reading, following)
    slow = ca.vertcat(row.lagged, row.lagged_first)
    timed = ca.depends_on(everything, ca.vertcat(row.elapsed, row.clock, row.interval, slow))
    warmed = ca.depends_on(everything, ca.vertcat(row.warming, row.warmth, slow))
    names = ", ".join(sorted({effect.physics for effect in chain.effects}))
    needed: list[str] = []
    if chain.states or timed or warmed or ca.depends_on(everything, ca.vertcat(row.first, row.number, row.approach)):
        needed += ["sequence", "series"]
    if timed:
        needed.append("time_s")
    legs = [f"leg{i + 1}_degC" for i in range(len(chain.robot.stiffness))]
    if warmed and not table.has(*legs):
        needed.append("temperature_degC")
    for column in needed:
        if not table.has(column):
            remedy = f"The model has effects that depend on history ({names}); add the column."
            raise table.fault("the column is missing", column=column, remedy=remedy)


def require_regular_points(robot: Robot, points: LoadedPoints) -> None:
    """Raise a `SingularConfigurationError` that names the first point at which the robot is nearly singular."""
    robot.jacobians(points.configurations).require_regular(points.where)


def in_file_order(points: LoadedPoints, *arrays: FloatArray) -> tuple[FloatArray, ...]:
    """Arrays whose rows are those of the points, reordered as the rows stand in the file."""
    order = np.argsort(points.lines, kind="stable")
    return tuple(array[order] for array in arrays)


def moved(points: LoadedPoints, configurations: FloatArray, robot: Robot) -> LoadedPoints:
    """The same loads at other commands (N, n_q): the moment of a payload follows from how it hangs there."""
    there = replace(points, configurations=configurations)
    if points.payload is None:
        return there
    before, after = (hanging(robot, q, points.payload, points.gravity) for q in (points.configurations, configurations))
    turned = after - before
    return replace(there, wrenches=points.wrenches + turned, absolute=points.absolute + turned)
