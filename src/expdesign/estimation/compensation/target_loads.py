"""What acts at a target: whose errors of the load are there, and how well the target's own payload is known.

An error of the load that recordings showed belongs to the weights that were hung on, not to the machine. At a target it
acts only where the target carries the same weights (`same_as: experiment`); a tilt of gravity acts at every target,
which stands on the same base. What a target carries otherwise is a payload of its own, whose mass and centre of mass
are known to a stated standard deviation. No recording shows that error, nor what every loading has for itself, which
weights that are hung on again have anew: with D = ∂ΔX/∂F and the wrench L·δ that it adds, its part of the attained
pose's covariance is D·L·Σ_δ·Lᵀ·Dᵀ (theory.md 5.1, 5.2), beside S·P·Sᵀ of the model. Targets of equal payloads of their
own, equally well known, carry one and the same.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.models.acting import own_names
from expdesign.chain.models.model_file import Model
from expdesign.chain.readings.position import TipPose
from expdesign.chain.recordings.recordings import LoadedPoints, in_order, order_in_time
from expdesign.chain.row import row_data
from expdesign.coordinates import Coordinates
from expdesign.io.table import Table
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import CentreOfMassError, DirectionError, LoadErrorSource, MassError
from expdesign.mechanics.loads.load import Payload
from expdesign.mechanics.robots.robot import Robot

SAME_AS = "same_as"
"""Column that says whose weights a target carries."""
EXPERIMENT = "experiment"
"""Its word for the weights of the recordings."""


def own_error_columns(coordinates: Coordinates) -> tuple[str, ...]:
    """Columns of the standard deviations of a target's own payload: mass (kg) and centre of mass (m)."""
    return tuple(f"error_{name}" for name in ("mass_kg", *coordinates.centre_of_mass))


@dataclass(frozen=True)
class TargetLoads:
    """The loads of N targets.

    Attributes:
        carries: whether a target carries the weights of the recordings, shape (N,).
        deviations: of the mass (kg) and the centre of mass (m) of its own payload, 0 where these are exact, (N, 1 + d).
    """

    carries: BoolArray
    deviations: FloatArray

    @classmethod
    def exact(cls, count: int, coordinates: Coordinates) -> "TargetLoads":
        """Payloads of their own that are known exactly."""
        columns = len(own_error_columns(coordinates))
        return cls(np.zeros(count, dtype=bool), np.zeros((count, columns)))

    @classmethod
    def of_table(cls, table: Table, coordinates: Coordinates) -> "TargetLoads":
        """What the columns `error_mass_kg`, `error_com_x_m` … and `same_as` say, rows in the order of their sequence.

        Raises:
            InputError: a standard deviation is not positive or larger than the mass, there is no payload that it could
                be of, or `same_as` names something else than the experiment.
        """
        found, names = cls.exact(len(table), coordinates), own_error_columns(coordinates)
        table, carries, deviations = in_order(table), found.carries, found.deviations
        if table.has(SAME_AS):
            stated = table.text(SAME_AS).astype(str)
            what, remedy = (
                "a target carries the weights of the `experiment`, or its own",
                "Write `experiment` or nothing.",
            )
            table.refuse(~np.isin(stated, ["", EXPERIMENT]), (SAME_AS,), what, remedy)
            carries = stated == EXPERIMENT
        if any(table.has(name) for name in names):
            stated = table.numbers_where_filled(names)
            given, deviations = np.isfinite(stated), np.where(np.isfinite(stated), stated, 0.0)
            what = "a standard deviation of {:g} says nothing"
            remedy = "State how well the payload is known, or leave the cell empty where it is exact."
            table.refuse(given & (stated <= 0.0), names, what, remedy, stated)
            mass = table.numbers_where_filled(("mass_kg",))
            what = "the standard deviation {:g} is of a payload, and there is none or a smaller one"
            wrong = np.hstack([given[:, :1] & ~(stated[:, :1] <= mass), given[:, 1:] & ~(mass > 0.0)])
            table.refuse(wrong, names, what, "State `mass_kg` of the target; in kg and m.", stated)
            what = "the target carries the weights of the experiment, whose errors the recordings state"
            remedy = "Leave out the errors, or `same_as`."
            table.refuse(given & carries[:, None], names, what, remedy, stated)
        return cls(carries, deviations)

    def motions(self, chain: Chain, model: Model, points: LoadedPoints) -> FloatArray:
        """What the chain predicts at the targets (N, r), with errors of the weights where these are carried."""
        rows = row_data(points, chain.robot)
        return self._carried(lambda values: chain.predict(rows, values), chain, model.values)

    def sensitivities(self, chain: Chain, model: Model, points: LoadedPoints) -> FloatArray:
        """Derivatives of `motions` with respect to the model's parameters, shape (N, r, p)."""
        rows = row_data(points, chain.robot)
        found = self._carried(lambda values: chain.predict_with_sensitivities(rows, values)[1], chain, model.values)
        return np.where(~self.carries[:, None, None] & of_weights(chain), 0.0, found)

    def _carried(self, at: Callable[[FloatArray], FloatArray], chain: Chain, values: FloatArray) -> FloatArray:
        """What is at parameters (p,) of the chain, without errors of the weights where a target does not carry them."""
        weights = of_weights(chain)
        if self.carries.all() or not weights.any():
            return at(values)
        own = at(np.where(weights, [parameter.neutral for parameter in chain.parameters], values))
        carried = self.carries.reshape(-1, *(1,) * (own.ndim - 1))
        return np.where(carried, at(values), own) if self.carries.any() else own

    def apart(self, own: FloatArray | None, coordinates: Coordinates) -> FloatArray:
        """Standard deviations of what every target has for itself, in the order of `own_names`, shape (N, o).

        Args:
            own: of what every loading of the experiment has for itself, shape (o,); None for nothing.
            coordinates: of the robot.
        """
        stated, names = self.deviations, own_names(coordinates)
        found = np.zeros((len(stated), len(names)))
        found[:, : stated.shape[1]] = stated
        if own is not None:
            found[self.carries] = own
            found[:, stated.shape[1] :] = own[stated.shape[1] :]
        return found

    def own_errors(self, chain: Chain, model: Model, points: LoadedPoints) -> FloatArray:
        """What one standard deviation of each component of each payload does to the attained poses, shape (N, r, D).

        Rows of one payload share its columns; those that carry the weights of the experiment have their own.
        """
        robot, own = chain.robot, None if model.acting is None else model.acting.own
        deviations = self.apart(own, robot.coordinates)
        if points.payload is None or not deviations.any():
            return np.zeros((len(points), robot.coordinates.n, 0))
        rotation = robot.jacobians(points.configurations).rotation
        parameters = np.concatenate([points.payload, points.gravity], axis=1)
        loaded = LoadedRobot(robot, Payload(robot.coordinates), unit_sources(robot.coordinates))
        added = np.concatenate(loaded.load_errors(rotation, parameters), axis=-1) * deviations[:, None]
        every = np.arange(len(points))
        keys = np.column_stack([points.payload, self.deviations, np.where(self.carries, every, -1)])
        _, payload = np.unique(keys, axis=0, return_inverse=True)
        columns = []
        for index in np.flatnonzero(deviations.any(axis=0)).tolist():
            ends = [
                replace(points, wrenches=points.wrenches + step, absolute=points.absolute + step)
                for step in (0.5 * added[..., index], -0.5 * added[..., index])
            ]
            moved = self.motions(chain, model, ends[0]) - self.motions(chain, model, ends[1])
            which = payload if index < self.deviations.shape[1] else every
            columns.append(moved[..., None] * (which[:, None] == np.unique(which))[:, None, :])
        return np.concatenate(columns, axis=2)


def unit_sources(coordinates: Coordinates) -> tuple[LoadErrorSource, ...]:
    """Sources of load error of one unit each, in the order of `own_names`."""
    centre, tilt = np.ones(len(coordinates.centre_of_mass)), np.ones(len(coordinates.tilt))
    return (MassError(np.ones(1)), *((CentreOfMassError(centre),) if len(centre) else ()), DirectionError(tilt))


def loads_of_targets(table: Table, robot: Robot) -> TargetLoads | None:
    """What the rows of a table of targets, commands or check measurements carry; None of any other table."""
    if not table.has(SAME_AS) and not table.has(f"target_{robot.configuration[0]}"):
        return None
    return TargetLoads.of_table(table, robot.coordinates)


def checked_targets(table: Table, robot: Robot) -> TargetLoads | None:
    """The same of check measurements alone, in the order of the file."""
    if not table.has(f"target_{robot.configuration[0]}"):
        return None
    found = TargetLoads.of_table(table, robot.coordinates)
    back = np.argsort(order_in_time(table), kind="stable")
    return TargetLoads(found.carries[back], found.deviations[back])


def of_weights(chain: Chain) -> BoolArray:
    """Which parameters of a chain are errors of the weights that were applied, shape (p,)."""
    found = np.zeros(len(chain.parameters), dtype=bool)
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        found[part] = effect.of_weights
    return found


@dataclass(frozen=True)
class AttainedUncertainty:
    """How well N attained poses are known.

    Attributes:
        sensitivities: S of the model's parameters, shape (N, r, p).
        known: √(S·P·Sᵀ), infinite where the model's recordings do not determine it, shape (N, r).
        own: what standard deviations of the targets' own payloads do, shape (N, r, D).
        drawn: what does that no reading shows of an arm's tip, shape (N, r, d).
    """

    sensitivities: FloatArray
    known: FloatArray
    own: FloatArray
    drawn: FloatArray

    @classmethod
    def at(
        cls, chain: Chain, model: Model, points: LoadedPoints, loads: TargetLoads, axes: FloatArray | None = None
    ) -> "AttainedUncertainty":
        """At the poses of the targets themselves, which the commands miss by micrometres; along `axes` (N, r, r)."""
        sensitivities, own = loads.sensitivities(chain, model, points), loads.own_errors(chain, model, points)
        drawn = np.zeros((*own.shape[:2], 0))
        if model.drawn is not None and points.aim is not None and isinstance(chain.reading, TipPose):
            drawn = model.drawn.moved(sensitivities, points.aim)
        if axes is not None:
            sensitivities, own, drawn = axes @ sensitivities, axes @ own, axes @ drawn
        return cls(sensitivities, model.estimable.deviations(sensitivities), own, drawn)

    @property
    def deviations(self) -> FloatArray:
        """√(S·P·Sᵀ + own·ownᵀ + drawn·drawnᵀ), shape (N, r)."""
        found: FloatArray = np.sqrt(self.known**2 + (self.own**2).sum(axis=-1) + (self.drawn**2).sum(axis=-1))
        return found


def said_of_loads(model: Model, loads: TargetLoads) -> list[str]:
    """Which errors of the load are applied at the targets, which not, and whether their own are in U."""
    chain, own = model.chain, None if model.acting is None else model.acting.own
    weights = list(dict.fromkeys(effect.declared.left_out for effect in chain.effects if effect.of_weights))
    tilted = any(effect.physics == "load_direction_tilt" for effect in chain.effects)
    carrying, count = int(loads.carries.sum()), len(loads.carries)
    texts = []
    if weights:
        where = "at no target" if carrying == 0 else f"at {carrying} of {count} targets" if carrying < count else ""
        text = f"applied {where or 'at every target'}, of the weights that were recorded: {', '.join(weights)}"
        texts.append(text if carrying else f"{text} (a target that carries these weights has `same_as: experiment`)")
    if tilted:
        texts.append("applied at every target: the identified direction of gravity")
    stated = int((loads.deviations > 0.0).any(axis=1).sum())
    if stated:
        texts.append(f"U contains the stated errors of the payload at {stated} of {count} targets")
    if own is not None and own[: loads.deviations.shape[1]].any() and carrying:
        which = "errors that differ from loading to loading, or from weight to weight"
        texts.append(f"U contains {which}, as declared, at {carrying} of {count} targets")
    if own is not None and own[loads.deviations.shape[1] :].any():
        texts.append("U contains the direction of gravity, which differs from loading to loading, at every target")
    return texts
