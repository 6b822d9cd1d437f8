"""How much of an effect outside the library known physics would explain, so that every question can be answered.

A misfit that vanishes in the noise beside one or two known effects, or with a few rows, cannot be told from them or
from wrong recordings by anybody. What known effects change is taken to first order, by the linear mechanics of
`linear_model` and the true compliances.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from research.laboratory import Robot

from .experiments import Experiment
from .hidden import Sized
from .linear_model import Array, BaseFit, Maps, maps_of, pose_columns, wrenches

_BESIDE = 2  # known effects that may stand together
_WRONG = 0.03  # share of rows that may be wrong recordings, as where these are what is hidden


def remaining_misfit(experiment: Experiment, fit: BaseFit, noise_free: Callable[[Sized], Array], sized: Sized) -> float:
    """Least sum of squared whitened residuals beside the two known effects, or without the rows, that explain most."""
    left = fit.residual(noise_free(sized))
    rows_aside = _without_rows(left, experiment, fit)
    changes = Linear.of(experiment).known_effects()
    blocks = [np.column_stack([fit.residual(each) for each in block]) for block in changes]
    for _ in range(_BESIDE):
        remainders = [_beside(left, block) for block in blocks]
        best = int(np.argmin([each @ each for each in remainders]))
        chosen = blocks.pop(best)
        left = remainders[best]
        blocks = [_beside(block, chosen) for block in blocks]
    return min(float(left @ left), rows_aside)


def _without_rows(left: Array, experiment: Experiment, fit: BaseFit) -> float:
    """Sum of squared whitened residuals when as many rows are set aside as wrong recordings may be."""
    fitted = np.flatnonzero(experiment.fitted)
    for _ in range(max(2, round(_WRONG * len(experiment.rows)))):
        worst = fitted[int(np.argmax((left.reshape(len(fitted), -1) ** 2).sum(axis=1)))]
        each = []
        for axis in experiment.measured:
            alone = np.zeros((len(experiment.rows), len(experiment.std)))
            alone[worst, axis] = experiment.std[axis]
            each.append(fit.residual(alone))
        left = _beside(left, np.column_stack(each))
    return float(left @ left)


def _beside(left: Array, block: Array) -> Array:
    """What is left of columns when they are freed of a block."""
    block = block / np.maximum(np.linalg.norm(block, axis=0), 1e-300)
    basis, values, _ = np.linalg.svd(block, full_matrices=False)
    basis = basis[:, values > 1e-6 * values[0]]
    return np.asarray(left - basis @ (basis.T @ left))


@dataclass(frozen=True)
class Linear:
    """The linear mechanics of all rows; arrays begin with the row."""

    robot: Robot
    experiment: Experiment
    maps: list[Maps]
    forward: Array
    pose: Array
    wrench: Array
    force: Array
    compliance: Array
    rates: Array  # pose rates of a twist
    position: Array  # of the platform's origin in O (m)
    rotation: Array

    @classmethod
    def of(cls, experiment: Experiment) -> Linear:
        robot, rows = experiment.machine.robot, experiment.rows
        maps, wrench = maps_of(robot, rows), wrenches(robot, rows)
        forward, pose = np.array([each.forward for each in maps]), np.array([each.pose for each in maps])
        here = [robot.pose(each) for each in rows[pose_columns(robot)].to_numpy(dtype=float)]
        return cls(
            robot,
            experiment,
            maps,
            forward,
            pose,
            wrench,
            np.einsum("rij,ri->rj", forward, wrench),
            1.0 / experiment.machine.true_stiffness,
            pose @ np.linalg.inv(forward),
            np.array([each.position for each in here]),
            np.array([each.rotation for each in here]),
        )

    def known_effects(self) -> Iterator[list[Array]]:
        """Changes of the deflections (rows x components), in groups that are one effect each."""
        yield from self._loads()
        yield from self._instrument()
        yield from self._leg_laws()
        yield from self._couplings()
        yield from self._yielding()
        yield from self._joint_positions()

    def _under(self, wrench: Array) -> Array:
        """Deflections under further wrenches."""
        return self._stretched(self.compliance * np.einsum("rij,ri->rj", self.forward, wrench))

    def _stretched(self, elongation: Array) -> Array:
        return np.einsum("rij,rj->ri", self.pose, elongation)

    def _loads(self) -> Iterator[list[Array]]:
        size = self.wrench.shape[1]
        force = self.wrench[:, :3]
        if size == 2:
            yield [self._under(np.column_stack([-self.wrench[:, 1], self.wrench[:, 0]]))]
        else:
            axes = np.eye(3)
            turned = [np.hstack([np.cross(axis, force), np.cross(axis, self.wrench[:, 3:])]) for axis in axes]
            yield [self._under(each) for each in turned[:2]]
            shifts = [np.einsum("rij,j->ri", self.rotation, axis) for axis in axes]
            nothing = np.zeros_like(force)
            yield [self._under(np.hstack([nothing, np.cross(shift, force)])) for shift in shifts]
        loads = np.round(np.linalg.norm(force, axis=1), 6)
        sizes = np.unique(loads[loads > 0])
        if len(sizes) <= 6:
            for each in sizes:
                yield [self._under(self.wrench * (loads == each)[:, None])]
            yield [self._under(self.wrench / np.maximum(loads, sizes[0])[:, None])]

    def _instrument(self) -> Iterator[list[Array]]:
        deflection = self._under(self.wrench)
        axes = min(deflection.shape[1], 3)
        yield [deflection * (np.arange(deflection.shape[1]) == axis) for axis in range(axes)]
        if axes == 2:
            yield [np.column_stack([deflection[:, 1], -deflection[:, 0]])]
            return
        turn = np.linalg.solve(self.rates, deflection[:, :, None])[:, 3:, 0]
        turned = [np.hstack([np.cross(deflection[:, :3], axis), np.cross(turn, axis)]) for axis in np.eye(3)]
        yield [np.einsum("rij,rj->ri", self.rates, each) for each in turned]

    def _leg_laws(self) -> Iterator[list[Array]]:
        """Play, tension unlike compression, hardening of single legs."""
        for leg in range(self.robot.legs):
            for law in (np.sign, np.abs, lambda force: force**3):
                elongation = np.zeros_like(self.force)
                elongation[:, leg] = law(self.force[:, leg])
                yield [self._stretched(elongation)]

    def _couplings(self) -> Iterator[list[Array]]:
        """The force in one leg stretches another, and the other way round."""
        for i in range(self.robot.legs):
            for j in range(i + 1, self.robot.legs):
                elongation = np.zeros_like(self.force)
                elongation[:, i], elongation[:, j] = self.force[:, j], self.force[:, i]
                yield [self._stretched(elongation)]

    def _yielding(self) -> Iterator[list[Array]]:
        """Every symmetric compliance of the platform's mount and of the base: twist = C wrench, in their own frames."""
        size = self.wrench.shape[1]
        turn, carry = np.tile(np.eye(size), (len(self.wrench), 1, 1)), np.tile(np.eye(size), (len(self.wrench), 1, 1))
        if size == 6:
            turn[:, :3, :3] = turn[:, 3:, 3:] = self.rotation
            x, y, z = self.position.T
            carry[:, 0, 4], carry[:, 0, 5], carry[:, 1, 5] = z, -y, x  # v + omega x p
            carry[:, 1, 3], carry[:, 2, 3], carry[:, 2, 4] = -z, y, -x
        for frame in (turn, carry):
            wrench = np.einsum("rij,ri->rj", frame, self.wrench)
            block = []
            for i in range(size):
                for j in range(i, size):
                    twist = np.zeros_like(wrench)
                    twist[:, i] += wrench[:, j]
                    twist[:, j] += wrench[:, i]
                    block.append(np.einsum("rij,rjk,rk->ri", self.rates, frame, twist))
            yield block

    def _joint_positions(self) -> Iterator[list[Array]]:
        """A joint elsewhere by a little: what that changes in A c."""
        robot, rows = self.robot, self.experiment.rows.drop_duplicates(pose_columns(self.robot))
        commands = self.experiment.rows[pose_columns(robot)].to_numpy(dtype=float)
        index = np.unique(commands, axis=0, return_inverse=True)[1].ravel()
        place = {int(index[row]): each for each, row in enumerate(rows.index)}
        where = np.array([place[int(each)] for each in index])

        def deflections(base: Array, platform: Array) -> Array:
            maps = maps_of(robot.with_joints(base, platform), rows)
            forward, pose = (np.array([getattr(each, name) for each in maps])[where] for name in ("forward", "pose"))
            return np.einsum("rij,j,rkj,rk->ri", pose, self.compliance, forward, self.wrench)

        before = deflections(robot.base_joints, robot.platform_joints)
        for leg in range(robot.legs):
            shifts = [1e-4 * np.outer(np.eye(robot.legs)[leg], axis) for axis in np.eye(3)[: 2 if robot.planar else 3]]
            yield [deflections(robot.base_joints + shift, robot.platform_joints) - before for shift in shifts]
            if not robot.planar:
                yield [deflections(robot.base_joints, robot.platform_joints + shift) - before for shift in shifts]
