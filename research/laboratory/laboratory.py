"""The laboratory bench: a robot with its hidden physics, an instrument, and rows to be measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from .elements.element import Element
from .errors import LaboratoryError
from .kinematics import Matrix, Pose, Vector
from .legs import LegConditions
from .loads import Load
from .machine import Machine
from .noise import Noise
from .recordings import Rows, Series, deflection_columns, pose_columns, std_columns
from .robot import Robot


@dataclass(frozen=True)
class Attained:
    """Equilibria of all rows: pose coordinates (m, rad; rows x components), leg forces (N; rows x legs).

    `platform` is where the mount is under load, `unloaded` where it is in the reference state of the row's
    series;
    `shown` and `shown_unloaded` are the same as the instrument shows them.
    """

    platform: Matrix
    unloaded: Matrix
    shown: Matrix
    shown_unloaded: Matrix
    leg_forces: Matrix


class Laboratory:
    """A robot as it really is, and an instrument.

    `true_stiffness` (N/m) are the legs' real spring constants (default: those of the robot file), `elements`
    the physics beside them. Noise is Gaussian, by `noise_std` (m, rad; by column or in order) or
    `covariance`; without either there is none. The same seed gives the same recordings.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        true_stiffness: Sequence[float] | Vector | None = None,
        elements: Sequence[Element] = (),
        noise_std: Mapping[str, float] | Sequence[float] | Vector | None = None,
        covariance: Matrix | None = None,
        shared_reference: bool = False,
        seed: int = 0,
    ) -> None:
        stiffness = robot.actuator_stiffness if true_stiffness is None else np.asarray(true_stiffness, dtype=float)
        if stiffness.shape != (robot.legs,) or not np.all(np.isfinite(stiffness) & (stiffness > 0)):
            raise LaboratoryError(f"true_stiffness: needs {robot.legs} positive numbers (N/m)")
        self.robot = robot
        self.elements = tuple(elements)
        self.noise = Noise.of(noise_std, covariance, deflection_columns(robot), shared_reference)
        self._seed = seed
        self._machine = Machine(robot, stiffness, self.elements)

    def measure(self, rows: pd.DataFrame) -> pd.DataFrame:
        """Measure every row: fill in `dx_m` ..., and `sx_m` ... where there is noise."""
        states = self.states(rows)
        rng = np.random.default_rng(self._seed)
        deflections: Vector = states.shown - states.shown_unloaded
        if not self.robot.planar:
            deflections[:, 3:] = (deflections[:, 3:] + np.pi) % (2 * np.pi) - np.pi
        for element in self.elements:
            deflections = element.misread(deflections, rows)
        series = [[state.row for state in each.states] for each in Rows(rows, self.robot).series()]
        deflections = deflections + self.noise.draw(series, rng)
        std = self.noise.std
        for element in self.elements:
            deflections = element.spoil(deflections, std, rng)
        measured = rows.copy()
        measured[deflection_columns(self.robot)] = deflections
        for column, value in zip(std_columns(self.robot), std, strict=True):
            if value > 0:  # a standard deviation of 0 is not a valid recording
                measured[column] = value
        return measured

    def attained(self, rows: pd.DataFrame, lengths: bool = False, loaded: bool = True) -> pd.DataFrame:
        """Where the platform really is, absolute and without noise, for each row's command and load.

        The command is the pose in the rows' pose columns, through the controller's nominal inverse
        kinematics, or with
        `lengths` the actuator lengths `leg1_m` ... With `loaded=False`: where it is in the unloaded state.
        """
        states = self.states(rows, lengths)
        values = states.platform if loaded else states.unloaded
        return pd.DataFrame(values, columns=pose_columns(self.robot), index=rows.index)

    def states(self, rows: pd.DataFrame, lengths: bool = False) -> Attained:
        """Find the equilibrium of every row and of its series' reference."""
        size, legs = len(pose_columns(self.robot)), self.robot.legs
        found = Attained(*(np.zeros((len(rows), n)) for n in (size, size, size, size, legs)))
        for series in Rows(rows, self.robot).series(lengths):
            self._run(series, found)
        return found

    def _run(self, series: Series, found: Attained) -> None:
        machine = self._machine
        machine.command(series.pose, series.lengths)
        first = series.states[0]
        reference_conditions = self._conditions(first.conditions, reference=True)
        machine.start(reference_conditions)
        unloaded = machine.equilibrium(self._true(first.reference_load), reference_conditions)
        machine.start(reference_conditions)
        for state in series.states:
            loaded = machine.equilibrium(self._true(state.load), self._conditions(state.conditions))
            found.platform[state.row] = self.robot.coordinates(loaded)
            found.unloaded[state.row] = self.robot.coordinates(unloaded)
            found.shown[state.row] = self.robot.coordinates(self._shown(loaded))
            found.shown_unloaded[state.row] = self.robot.coordinates(self._shown(unloaded))
            found.leg_forces[state.row] = machine.leg_forces()

    def _true(self, load: Load) -> Load:
        if load.is_zero:
            return load
        for element in self.elements:
            load = element.true_load(load)
        return load

    def _shown(self, pose: Pose) -> Pose:
        for element in self.elements:
            pose = element.reading(pose)
        return pose

    def _conditions(self, conditions: Sequence[LegConditions], reference: bool = False) -> list[LegConditions]:
        machine = self._machine
        each = zip(conditions, machine.lengths, machine.directions, machine.home_directions, strict=True)
        return [
            replace(
                one,
                length=float(q),
                reference=reference,
                direction=direction,
                home_direction=home,
                travel=machine.travel,
            )
            for one, q, direction, home in each
        ]
