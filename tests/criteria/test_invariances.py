"""What must not change, or must change in a known way, over random robots and random designs (theory.md 4, 5, 13)."""

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.robots.bipod import Bipod
from expdesign.mechanics.robots.hexapod import Hexapod
from expdesign.mechanics.robots.parallel import ParallelRobot
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.deflection_noise import DeflectionNoise
from tests.cases import load_of, source_of, symmetric_hexapod
from tests.oracle import Array


@dataclass(frozen=True)
class Experiment:
    """A random robot with m measurements under free wrenches or payloads, and two targets."""

    robot: ParallelRobot
    loaded: LoadedRobot
    poses: Array
    loads: Array
    noise: DeflectionNoise
    targets: Targets
    shared: tuple[bool, ...]
    generator: np.random.Generator

    def assess(self, poses: Array | None = None, loads: Array | None = None) -> Assessment:
        """The one design, or another one; every measurement has its own reference."""
        poses, loads = self.poses if poses is None else poses, self.loads if loads is None else loads
        return Assessment(
            self.loaded.measure(poses[None], loads[None]), self.noise, self.shared, self.targets, estimator="weighted"
        )


def random_robot(generator: np.random.Generator, hexapod: bool) -> tuple[ParallelRobot, Array]:
    """A bipod or hexapod with scattered joints and unequal legs, and a reach (n,) around its zero pose."""
    if hexapod:
        regular = symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 1.0)
        made: ParallelRobot = Hexapod(
            base_joints=regular.base_joints + generator.uniform(-0.03, 0.03, (6, 3)),
            platform_joints=regular.platform_joints + generator.uniform(-0.03, 0.03, (6, 3)),
            home=regular.home,
            stiffness=10.0 ** generator.uniform(6.0, 8.0, 6),
            orientation="fixed-xyz" if generator.random() < 0.5 else "moving-xyz",
        )
        return made, np.array([0.02, 0.02, 0.02, 0.15, 0.15, 0.25])
    base = np.array([[-0.5, 0.0], [0.5, 0.0]]) + generator.uniform(-0.1, 0.1, (2, 2))
    return Bipod(base_joints=base, home=np.array([0.0, 0.6]), stiffness=10.0 ** generator.uniform(6.0, 8.0, 2)), (
        np.array([0.2, 0.2])
    )


def make(seed: int, hexapod: bool, kind: str, measurements: int, errors: tuple[tuple[str, bool], ...]) -> Experiment:
    """The experiment of a seed."""
    generator = np.random.default_rng(seed)
    robot, reach = random_robot(generator, hexapod)
    n = robot.coordinates.n
    poses = reach * generator.uniform(-1.0, 1.0, (measurements, n))
    size = np.where(np.arange(n) < robot.coordinates.translations, 300.0, 30.0)
    if kind == "wrench":
        loads = size * generator.uniform(-1.0, 1.0, (measurements, n))
    else:
        mass = generator.uniform(5.0, 30.0, (measurements, 1))
        centre = generator.uniform(-0.1, 0.1, (measurements, len(robot.coordinates.centre_of_mass)))
        tilted = robot.gravity + generator.uniform(-3.0, 3.0, (measurements, len(robot.gravity)))
        loads = np.concatenate([mass, centre, tilted], axis=1)
    load = load_of(kind, robot.coordinates)
    made = (source_of(source, load, shared) for source, shared in errors)
    sources = tuple(source for source in made if source is not None)
    root = np.eye(n) + 0.5 * generator.uniform(-1.0, 1.0, (n, n))
    deviation = np.where(np.arange(n) < robot.coordinates.translations, 1e-6, 1e-5)
    noise = DeflectionNoise(np.arange(n), root @ root.T * np.outer(deviation, deviation))
    places = reach * generator.uniform(-1.0, 1.0, (2, n))
    wrenches = size * generator.uniform(-1.0, 1.0, (2, n))
    observation = observation_matrix(robot.jacobians(places), wrenches)
    importance = np.broadcast_to(1.0 / deviation**2, (2, n))
    targets = Targets(places, observation, importance, np.array([1.0, 2.0]), robot.coordinates.translations)
    shared = tuple(source.shared for source in sources)
    loaded = LoadedRobot(robot, load, sources)
    made_experiment = Experiment(robot, loaded, poses, loads, noise, targets, shared, generator)
    # Properties are stated to eight digits or so, which rounding leaves of designs that are not nearly deficient.
    assume(float(made_experiment.assess().condition[0]) < 1e5)
    return made_experiment


seeds = st.integers(0, 2**32 - 1)
robots = st.booleans()
counts = st.integers(2, 6)


def close(found: Array, expected: Array, rtol: float = 1e-7) -> None:
    """Equal, with entries that are negligible in their row allowed to be rounding."""
    size = np.abs(expected).max(axis=-1, keepdims=True)
    excess = np.abs(found - expected) / np.where(size > 0.0, size, 1.0)
    assert excess.max() <= rtol, f"{found} is not {expected}"


@given(seeds, robots, counts, st.floats(0.01, 100.0))
def test_scaled_loads(seed: int, hexapod: bool, measurements: int, scale: float) -> None:
    """U(sF) = U/s², Z(sF) = Z/s, μ(sF) = s·μ."""
    here = make(seed, hexapod, "wrench", measurements, (("wrench", False), ("direction", True)))
    one, other = here.assess(), here.assess(loads=scale * here.loads)
    close(other.noise_variance * scale**2, one.noise_variance)
    close(other.force_sensitivity() * scale, one.force_sensitivity())
    close(other.singular_values / scale, one.singular_values)


@given(seeds, robots, counts, st.floats(0.1, 10.0))
def test_more_mass_does_not_cure_errors_of_the_centre_of_mass(
    seed: int, hexapod: bool, measurements: int, scale: float
) -> None:
    """theory.md 5.3: with errors of the centre of mass or the direction FEIR knows no mass, and DUIR falls with 1/m."""
    here = make(seed, hexapod, "payload", measurements, (("com", True), ("com", False), ("direction", True)))
    heavier = here.loads.copy()
    heavier[:, 0] *= scale
    one, other = here.assess(), here.assess(loads=heavier)
    close(other.force_variance, one.force_variance)
    close(other.noise_variance * scale**2, one.noise_variance)


@given(seeds, robots, counts, st.integers(2, 4))
def test_replication(seed: int, hexapod: bool, measurements: int, times: int) -> None:
    """U/r and random load errors /r; systematic ones stay."""
    random = (("wrench", False), ("direction", False))
    systematic = (("wrench", True), ("direction", True))
    for errors, factor in ((random, times), (systematic, 1)):
        here = make(seed, hexapod, "payload", measurements, errors)
        one = here.assess()
        other = here.assess(np.tile(here.poses, (times, 1)), np.tile(here.loads, (times, 1)))
        close(other.noise_variance * times, one.noise_variance)
        close(other.force_variance * factor, one.force_variance)
        o1 = known_criteria()["o1"]
        close(o1.values(other), o1.values(one))


@given(seeds, robots, counts)
def test_scaled_parameters(seed: int, hexapod: bool, measurements: int) -> None:
    """H-invariance: with A·H for A the estimate is H⁻¹·ĉ, and U and Z are as they were; O1 is scaled for all alike."""
    here = make(seed, hexapod, "wrench", measurements, (("wrench", False),))
    one = here.assess()
    h = 10.0 ** here.generator.uniform(-1.0, 1.0, one.parameters)
    measured = replace(one.measurements, observation=one.measurements.observation * h)
    targets = replace(here.targets, observation=here.targets.observation * h)
    other = Assessment(measured, here.noise, here.shared, targets, estimator="weighted")
    close(other.gain * h[:, None], one.gain)
    close(other.noise_variance, one.noise_variance)
    close(other.force_sensitivity(), one.force_sensitivity())
    o1 = known_criteria()["o1"]
    close(o1.values(other), o1.values(one) * np.prod(h) ** (1.0 / len(h)))


@given(seeds, robots, counts)
def test_root_of_the_noise(seed: int, hexapod: bool, measurements: int) -> None:
    """Only GᵀG = V⁻¹ matters: the eigenvector root gives the same estimate, U, Z and O1 to O5 as the Cholesky root."""
    here = make(seed, hexapod, "payload", measurements, (("wrench", True),))
    rotated = DeflectionNoise(here.noise.axes, here.noise.covariance)
    turn, _ = np.linalg.qr(here.generator.normal(size=rotated.whitener.shape))
    rotated.whitener = turn @ rotated.whitener
    one = here.assess()
    other = Assessment(one.measurements, rotated, here.shared, here.targets, estimator="weighted")
    close(other.gain, one.gain)
    close(other.noise_variance, one.noise_variance)
    close(other.force_sensitivity(), one.force_sensitivity())
    close(other.singular_values, one.singular_values)


@given(seeds, robots, counts)
def test_units_of_the_readings(seed: int, hexapod: bool, measurements: int) -> None:
    """Readings in µm and mrad: the estimate and everything after it are the same."""
    here = make(seed, hexapod, "payload", measurements, (("wrench", True),))
    n = here.robot.coordinates.n
    units = np.where(np.arange(n) < here.robot.coordinates.translations, 1e6, 1e3)
    one = here.assess()
    measured = replace(
        one.measurements,
        observation=one.measurements.observation * units[:, None],
        compliance=one.measurements.compliance * units[:, None],
    )
    noise = DeflectionNoise(here.noise.axes, here.noise.covariance * np.outer(units, units))
    other = Assessment(measured, noise, here.shared, here.targets, estimator="weighted")
    for name, criterion in known_criteria().items():
        np.testing.assert_allclose(criterion.values(other), criterion.values(one), rtol=1e-7, err_msg=name)
    close(other.gain * units, one.gain)


@given(seeds, robots, counts)
def test_order_of_the_measurements(seed: int, hexapod: bool, measurements: int) -> None:
    here = make(seed, hexapod, "payload", measurements, (("wrench", True), ("direction", False), ("mass", False)))
    order = here.generator.permutation(measurements)
    one, other = here.assess(), here.assess(here.poses[order], here.loads[order])
    for name, criterion in known_criteria().items():
        np.testing.assert_allclose(criterion.values(other), criterion.values(one), rtol=1e-7, err_msg=name)
    close(other.gain, one.gain[:, order])


@given(seeds, robots, counts)
def test_information_adds(seed: int, hexapod: bool, measurements: int) -> None:
    """One more measurement never makes U larger in any direction; M is the sum of the measurements' information."""
    here = make(seed, hexapod, "wrench", measurements, ())
    fewer = here.poses[:-1], here.loads[:-1]
    one, other = here.assess(*fewer), here.assess()
    assume(float(one.condition[0]) < 1e5)
    scale = np.sqrt(one.noise_variance[0])
    for target in range(2):
        roots = [part.noise_root[0, target] / scale[target][:, None] for part in (one, other)]
        difference = roots[0] @ roots[0].T - roots[1] @ roots[1].T
        assert np.linalg.eigvalsh(difference).min() > -1e-7
    parts = [here.assess(here.poses[i : i + 1], here.loads[i : i + 1]).whitened[0] for i in range(measurements)]
    total = sum(part.T @ part for part in parts)
    np.testing.assert_allclose(other.whitened[0].T @ other.whitened[0], total, rtol=1e-9, atol=1e-12 * np.max(total))


@given(seeds, robots)
def test_closed_forms_of_a_single_measurement(seed: int, hexapod: bool) -> None:
    """U = Θ·V·Θᵀ with Θ = J̌_D·diag(τ_D/τ_M)·J̌_M⁻¹ and Z = −J̌_D·diag(c·τ_D/τ_M)·J_Mᵀ (theory.md 4.2, 5.1)."""
    here = make(seed, hexapod, "wrench", 2, ())
    found = here.assess(here.poses[:1], here.loads[:1])
    assume(float(found.condition[0]) < 1e4)
    measured, wanted = here.robot.jacobians(here.poses[0]), here.robot.jacobians(here.targets.configurations[0])
    force = measured.forward.T @ here.loads[0]
    ratio = np.linalg.solve(wanted.pose, here.targets.observation[0]).diagonal() / force
    theta = wanted.pose * ratio @ np.linalg.inv(measured.pose)
    np.testing.assert_allclose(found.noise_variance[0, 0], np.diag(theta @ here.noise.covariance @ theta.T), rtol=1e-7)
    close(found.force_sensitivity()[0, 0], -(wanted.pose * (here.robot.compliance * ratio) @ measured.forward.T))


@given(seeds, robots, counts, st.floats(1.0, 100.0))
def test_a_wrong_mass_is_a_wrong_scale(seed: int, hexapod: bool, measurements: int, mass: float) -> None:
    """One mass for all: ε_c = c·δm/m, so that the attained pose is wrong by ΔX_D·δm/m, whatever the design."""
    here = make(seed, hexapod, "payload", measurements, (("mass", True),))
    loads = here.loads.copy()
    loads[:, 0] = mass
    found = here.assess(loads=loads)
    assume(float(found.condition[0]) < 1e5)
    deflection = here.targets.observation @ here.robot.compliance
    close(np.sqrt(found.force_variance[0]), np.abs(deflection) * here.loaded.sources[0].deviation / mass)
