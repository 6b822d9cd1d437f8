"""The measurement chain at known parameters as plans see it: deflections, and their derivatives.

A plan measures the deflection between the unloaded and the loaded robot at one command. Every measurement is taken to
start from rest: states of effects with memory are zero, no time has passed and no temperature has changed since the
series began. Where the chain is not linear, its derivatives are taken at the assumed load and the known compliances
(play, for instance, is a constant where the force stays on one side of the gap).
"""

from dataclasses import fields, replace
from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.row import Row, row_symbols
from expdesign.mechanics.loads.load import Load
from expdesign.mechanics.robots.robot import Jacobians, Robot
from expdesign.mechanics.symbolic import BatchFunction


class KnownChain:
    """A chain with known parameters (`elastostatics.measurements.Physics`).

    Args:
        chain: of a robot that reads deflections.
        values: its parameters, shape (p,).
    """

    def __init__(self, chain: Chain, values: FloatArray) -> None:
        self.chain, self.values = chain, values

    def under(self, load: Load, *, instrument: bool) -> "ChainUnderLoad":
        chain = Chain(self.chain.robot, self.chain.effects, instrument=instrument)
        return ChainUnderLoad(chain, self.values, load)


class ChainUnderLoad:
    """A chain with known parameters under one kind of load (`elastostatics.measurements.LoadedPhysics`).

    Args:
        chain: ends with the instrument's reading, or with the motion of the platform.
        values: its parameters, shape (p,).
        load: payload or wrench; the reference state is the robot without it.
    """

    def __init__(self, chain: Chain, values: FloatArray, load: Load) -> None:
        self.chain, self.values, self.load = chain, values, load

    def maps(
        self, configurations: FloatArray, loads: FloatArray, jacobians: Jacobians
    ) -> tuple[FloatArray, FloatArray]:
        batch, n = configurations.shape[:-1], self.chain.robot.coordinates.n
        observation, compliance = self._maps(configurations, loads, _flat(jacobians.forward), _flat(jacobians.pose))
        return observation.reshape(*batch, n, self.chain.compliances), compliance

    def deflections(
        self, configurations: FloatArray, loads: FloatArray, jacobians: Jacobians, added: FloatArray
    ) -> FloatArray:
        maps = _flat(jacobians.forward), _flat(jacobians.pose)
        (deflections,) = self._deflections(configurations, loads, *maps, added)
        return deflections

    def expression(self, configuration: ca.SX, loads: ca.SX, compliances: ca.SX) -> ca.SX:
        forward, pose_map, _ = self.chain.robot.jacobian_expressions(configuration)
        row = self._row(configuration, loads, forward, pose_map, ca.SX.zeros(self.chain.robot.coordinates.n))
        units = compliances * ca.SX(self.chain.robot.stiffness)
        return self._reading(row, ca.vertcat(units, ca.SX(self.values[self.chain.compliances :])))

    def _reading(self, row: Row, theta: ca.SX) -> ca.SX:
        return self.chain.expression(row, ca.SX.zeros(self.chain.states), theta)[0]

    def _row(self, configuration: ca.SX, loads: ca.SX, forward: ca.SX, pose_map: ca.SX, added: ca.SX) -> Row:
        return row_at_rest(self.chain.robot, self.load, configuration, loads, forward, pose_map, added)

    def _symbolic(self) -> tuple[list[ca.SX], ca.SX, ca.SX, ca.SX]:
        """Inputs of a measurement, the compliances and the added wrench as symbols, and the reading."""
        robot = self.chain.robot
        n, count = robot.coordinates.n, len(robot.stiffness)
        configuration = ca.SX.sym("q", len(robot.configuration))
        loads = ca.SX.sym("load", len(self.load.columns))
        forward, pose_map = ca.SX.sym("J", n * count), ca.SX.sym("Jx", n * count)
        added, compliances = ca.SX.sym("added", n), ca.SX.sym("c", count)
        # NumPy flattens rows first, CasADi columns first.
        row = self._row(configuration, loads, ca.reshape(forward, count, n).T, ca.reshape(pose_map, count, n).T, added)
        reading = self._reading(row, ca.vertcat(compliances, ca.SX(self.values[count:])))
        return [configuration, loads, forward, pose_map], compliances, added, reading

    @cached_property
    def linear_in_load(self) -> bool:
        # What only looks as if it depended on the load counts as if it did, which costs no more than time.
        inputs, compliances, added, reading = self._symbolic()
        loads = inputs[1]
        known = [ca.SX(self.values[: self.chain.compliances]), ca.SX.zeros(added.shape)]
        maps = [ca.jacobian(reading, compliances), ca.jacobian(reading, added)]
        observation, compliance = ca.substitute(maps, [compliances, added], known)
        slopes = ca.jacobian(ca.vec(observation), loads)
        affine = not any(ca.depends_on(slopes[:, i], loads[i]) for i in range(loads.shape[0]))
        return affine and not ca.depends_on(compliance, loads)

    @cached_property
    def _deflections(self) -> BatchFunction:
        inputs, compliances, added, reading = self._symbolic()
        known = ca.substitute(reading, compliances, ca.SX(self.values[: self.chain.compliances]))
        return BatchFunction("chain_under_load", [*inputs, added], [known])

    @cached_property
    def _maps(self) -> BatchFunction:
        inputs, compliances, added, reading = self._symbolic()
        by_compliance = ca.jacobian(reading, compliances) @ ca.diag(ca.SX(self.chain.robot.stiffness))
        outputs = [ca.densify(by_compliance), ca.densify(ca.jacobian(reading, added))]
        known = [ca.SX(self.values[: self.chain.compliances]), ca.SX.zeros(added.shape)]
        return BatchFunction("chain_maps", inputs, ca.substitute(outputs, [compliances, added], known))


def row_at_rest(
    robot: Robot, load: Load, configuration: ca.SX, loads: ca.SX, forward: ca.SX, pose_map: ca.SX, added: ca.SX
) -> Row:
    """The row of a measurement from rest; the wrench that acts is the assumed one and what is added to it."""
    *_, rotation = robot.jacobian_expressions(configuration)
    dimension = len(robot.gravity)
    gravity = loads[-dimension:] if load.has_mass else ca.SX(robot.gravity)
    state = robot.commanded_state(configuration, gravity)
    wrench = load.wrench(loads, rotation) + added
    lever = ca.SX.zeros(dimension)
    if load.has_mass and robot.coordinates.centre_of_mass:
        lever = rotation @ loads[1 : 1 + dimension]
    # What is not named here is zero: own weight that only positions show, warming, and time.
    row = row_symbols(robot)
    zeros = {item.name: ca.SX.zeros(getattr(row, item.name).shape) for item in fields(row)}
    return replace(
        Row(**zeros),
        pose=configuration,
        wrench=wrench,
        absolute=wrench,
        own=state.own,
        gravity=gravity,
        position=state.position,
        lever=lever,
        payload=ca.SX(float(load.has_mass)),
        rotation=rotation,
        rates=state.rates,
        forward=forward,
        pose_map=pose_map,
        lengths=state.lengths,
        first=ca.SX(1.0),
    )


def _flat(matrices: FloatArray) -> FloatArray:
    return matrices.reshape(*matrices.shape[:-2], int(np.prod(matrices.shape[-2:])))
