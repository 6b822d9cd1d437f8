"""The maps of single measurements, differentiable: quantities → Jacobians, wrench, load errors → whitened maps.

The forward direction repeats `LoadedRobot.measure` (a test holds the two together); the reverse direction is its exact
adjoint. Only the geometry, with its trigonometry, is symbolic, and CasADi differentiates it; the inverses and products
of small matrices, and their adjoints (for an inverse Y = X⁻¹: X̄ = −Yᵀ·Ȳ·Yᵀ), are taken for whole batches at once, which
is several times faster than one symbolic graph through them and uses pivoted factorisations.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.design.problem import DesignProblem
from expdesign.design.space import tilted_gravity
from expdesign.elastostatics.geometric_stiffness import _geometric_stiffness_function
from expdesign.elastostatics.regressors.regressor import PoseMaps
from expdesign.robots.parallel import ParallelRobot
from expdesign.robots.robot import invert
from expdesign.symbolic import BatchFunction


@dataclass(frozen=True)
class Tape:
    """What the reverse direction needs of a forward evaluation of N measurements (named as in theory.md 1).

    Attributes:
        quantities: shape (N, z).
        raw: the symbolic matrices, by name.
        forward: J, shape (N, n, n_p).
        pose: J̌, shape (N, n, n_p).
        forces: τ, shape (N, n_p).
        compliance: D before the geometric stiffness, shape (N, n, n), or None where no load error needs it.
        softening: (I + D·K_G)⁻¹ and K_G, or None.
        full: A and D after the geometric stiffness.
        whitener: G, shape (k, k) or (N, k, k).
        observation: whitened observation matrix G·A of the measured axes, shape (N, k, n_p).
        errors: whitened deflection per standard deviation of each load error, G·D·L, shape (N, k, d).
    """

    quantities: FloatArray
    raw: dict[str, FloatArray]
    forward: FloatArray
    pose: FloatArray
    forces: FloatArray
    compliance: FloatArray | None
    softening: tuple[FloatArray, FloatArray] | None
    full: tuple[FloatArray, FloatArray | None]
    whitener: FloatArray
    observation: FloatArray
    errors: FloatArray


def _transposed(matrices: FloatArray) -> FloatArray:
    return matrices.swapaxes(-1, -2)


class MeasurementMaps:
    """The maps of single measurements of a design problem, and their adjoints.

    Attributes:
        shared: per column of `Tape.errors`, whether its δ is the same for all measurements, shape (d,).
        width: number of quantities z of a measurement (configuration, load, tilt).
    """

    def __init__(self, problem: DesignProblem) -> None:
        self.problem = problem
        self.robot = problem.loaded.robot
        sources = problem.loaded.sources
        flags = [np.full(len(source.deviation), source.shared) for source in sources]
        self.shared: BoolArray = np.concatenate(flags) if flags else np.zeros(0, dtype=bool)
        tilt = 0 if problem.space.gravity is None else len(self.robot.coordinates.tilt)
        self.width = problem.space.n_pose + problem.space.n_load + tilt
        self._parallel = isinstance(self.robot, ParallelRobot)
        self._conservative = problem.loaded.geometric_stiffness and self._parallel

    @cached_property
    def _expressions(self) -> tuple[ca.SX, dict[str, ca.SX], tuple[str, ...]]:
        """The symbolic quantities, the matrices that they make, and which of these are the regressor's own."""
        problem, space = self.problem, self.problem.space
        z = ca.SX.sym("z", self.width)
        configuration, load = z[: space.n_pose], z[space.n_pose : space.n_pose + space.n_load]
        if space.gravity is not None:
            gravity = tilted_gravity(ca.SX(space.gravity), z[space.n_pose + space.n_load :])
            load = ca.vertcat(load, gravity)
        named: dict[str, ca.SX] = {}
        if isinstance(self.robot, ParallelRobot):
            lengths = self.robot.actuator_lengths(configuration, ca.SX(self.robot.geometry))
            named["rates"] = ca.jacobian(lengths, configuration)
            named["twist"] = self.robot.pose_rate_map(configuration)
            rotation = self.robot.rotation(configuration)
        else:
            named["forward"], named["pose"], rotation = self.robot.jacobian_expressions(configuration)
        further = problem.loaded.regressor.expressions(self.robot, configuration)
        named |= further
        named["wrench"] = problem.loaded.load.wrench(load, rotation)
        columns = [
            source.sensitivity(problem.loaded.load, load, rotation) @ ca.diag(ca.SX(source.deviation))
            for source in problem.loaded.sources
        ]
        if columns:
            named["errors"] = ca.horzcat(*columns)
        return z, {name: ca.densify(value) for name, value in named.items()}, tuple(further)

    @cached_property
    def _layout(self) -> dict[str, tuple[slice, tuple[int, int]]]:
        """Where each matrix lies in the vector of all, rows first."""
        layout, start = {}, 0
        for name, value in self._expressions[1].items():
            stop = start + value.numel()
            layout[name] = (slice(start, stop), value.shape)
            start = stop
        return layout

    @cached_property
    def _functions(self) -> tuple[BatchFunction, BatchFunction]:
        """All matrices as one vector, and the vector-Jacobian product of that vector."""
        z, named, _ = self._expressions
        vector = ca.vertcat(*(ca.vec(value.T) for value in named.values()))
        seed = ca.SX.sym("seed", vector.shape[0])
        product = ca.jtimes(vector, z, seed, True)
        return BatchFunction("measurement_maps", [z], [vector]), BatchFunction(
            "measurement_maps_adjoint", [z, seed], [product]
        )

    @cached_property
    def _stiffness_functions(self) -> tuple[BatchFunction, BatchFunction]:
        """K_G(X, τ) and its vector-Jacobian products."""
        assert isinstance(self.robot, ParallelRobot)
        pose, force = ca.SX.sym("X", self.robot.coordinates.n), ca.SX.sym("tau", len(self.robot.stiffness))
        matrix = _geometric_stiffness_function(self.robot).function(pose, force)
        seed = ca.SX.sym("seed", matrix.numel())
        products = [ca.jtimes(ca.vec(matrix.T), symbol, seed, True) for symbol in (pose, force)]
        value = BatchFunction("stiffness", [pose, force], [matrix])
        return value, BatchFunction("stiffness_adjoint", [pose, force, seed], products)

    def run(self, quantities: FloatArray) -> Tape:
        """Evaluate N measurements, quantities (N, z); entries are NaN where the mechanism is exactly singular."""
        (vector,) = self._functions[0](quantities)
        raw = {name: vector[:, part].reshape(-1, *shape) for name, (part, shape) in self._layout.items()}
        if "rates" in raw:
            forward = invert(raw["rates"] @ raw["twist"])
            pose: FloatArray = raw["twist"] @ forward
        else:
            forward, pose = raw["forward"], raw["pose"]
        forces = (_transposed(forward) @ raw["wrench"])[..., 0]
        observation = self.problem.loaded.regressor.matrix(self._maps(raw, pose, forces))
        compliance: FloatArray | None = None
        if "errors" in raw or self._conservative:
            compliance = (pose * self.robot.compliance) @ _transposed(forward)
        softening = None
        effective = compliance
        if self._conservative and compliance is not None:
            (stiffness,) = self._stiffness_functions[0](quantities[:, : self.problem.space.n_pose], forces)
            inverse = invert(np.eye(compliance.shape[-1]) + compliance @ stiffness)
            softening = (inverse, stiffness)
            observation, effective = inverse @ observation, inverse @ compliance
        noise = self.problem.noise
        whitener = noise.whitener_at(pose)
        whitened = whitener @ observation[:, noise.axes]
        if "errors" in raw and effective is not None:
            errors = whitener @ (effective @ raw["errors"])[:, noise.axes]
        else:
            errors = np.zeros((len(quantities), len(noise.axes), 0))
        return Tape(
            quantities,
            raw,
            forward,
            pose,
            forces,
            compliance,
            softening,
            (observation, effective),
            whitener,
            whitened,
            errors,
        )

    def _maps(self, raw: dict[str, FloatArray], pose: FloatArray, forces: FloatArray) -> PoseMaps:
        return PoseMaps(pose, forces, {name: raw[name] for name in self._expressions[2]})

    def pull(self, tape: Tape, observation: FloatArray, errors: FloatArray) -> FloatArray:
        """Gradient with respect to the quantities (N, z) of a function with the given partial derivatives.

        Args:
            tape: of the forward evaluation.
            observation: partial derivatives with respect to `tape.observation`, shape (N, k, n_p).
            errors: partial derivatives with respect to `tape.errors`, shape (N, k, d).
        """
        noise, (full, effective) = self.problem.noise, tape.full
        unwhitened = np.zeros_like(full)
        transposed = _transposed(tape.whitener)
        unwhitened[:, noise.axes] = transposed @ observation
        by_whitener = observation @ _transposed(full[:, noise.axes])
        seeds: dict[str, FloatArray] = {}
        by_compliance: FloatArray | None = None
        if "errors" in tape.raw and effective is not None:
            deflection = np.zeros((*full.shape[:2], errors.shape[-1]))
            deflection[:, noise.axes] = transposed @ errors
            by_whitener = by_whitener + errors @ _transposed((effective @ tape.raw["errors"])[:, noise.axes])
            by_compliance = deflection @ _transposed(tape.raw["errors"])
            seeds["errors"] = _transposed(effective) @ deflection
        force_seed = np.zeros_like(tape.forces)
        pose_gradient: FloatArray | float = 0.0
        if tape.softening is not None and tape.compliance is not None:
            inverse, stiffness = tape.softening
            unwhitened = _transposed(inverse) @ unwhitened
            by_compliance = np.zeros_like(tape.compliance) if by_compliance is None else by_compliance
            by_compliance = _transposed(inverse) @ by_compliance
            assert effective is not None
            by_softening = -unwhitened @ _transposed(full) - by_compliance @ _transposed(effective)
            by_compliance = by_compliance + by_softening @ _transposed(stiffness)
            by_stiffness = (_transposed(tape.compliance) @ by_softening).reshape(len(full), -1)
            poses = tape.quantities[:, : self.problem.space.n_pose]
            pose_gradient, force_seed = self._stiffness_functions[1](poses, tape.forces, by_stiffness)
        found = self.problem.loaded.regressor.pull(self._maps(tape.raw, tape.pose, tape.forces), unwhitened)
        seeds |= found.further
        by_pose = np.zeros_like(tape.pose) if found.pose is None else found.pose
        by_noise = noise.pull(tape.pose, tape.whitener, by_whitener)
        by_pose = by_pose if by_noise is None else by_pose + by_noise
        force_seed = force_seed if found.forces is None else force_seed + found.forces
        by_forward = tape.raw["wrench"] @ force_seed[:, None, :]
        if by_compliance is not None:
            by_pose = by_pose + (by_compliance @ tape.forward) * self.robot.compliance
            by_forward = by_forward + (_transposed(by_compliance) @ tape.pose) * self.robot.compliance
        seeds["wrench"] = tape.forward @ force_seed[..., None]
        if "rates" in tape.raw:
            seeds["twist"] = by_pose @ _transposed(tape.forward)
            by_forward = by_forward + _transposed(tape.raw["twist"]) @ by_pose
            by_inverse = -_transposed(tape.forward) @ by_forward @ _transposed(tape.forward)
            seeds["rates"] = by_inverse @ _transposed(tape.raw["twist"])
            seeds["twist"] = seeds["twist"] + _transposed(tape.raw["rates"]) @ by_inverse
        else:
            seeds["forward"], seeds["pose"] = by_forward, by_pose
        vector = np.concatenate([seeds[name].reshape(len(full), -1) for name in self._layout], axis=1)
        (gradient,) = self._functions[1](tape.quantities, vector)
        gradient[:, : self.problem.space.n_pose] += pose_gradient
        return gradient
