"""Where the base model and the recordings differ, before any physics is named.

Each probe is a set of directions in which one part of the machine could move the readings, whatever the cause: any
function of the force in a leg for that leg, any load-proportional motion for platform and base, and so on. The part of
χ² that a probe explains after the compliances are projected out is χ²-distributed when nothing is wrong there; with
many probes the p-values are corrected by Holm's method, so that the whole table holds its level.

These are score tests: what directions explain of residuals once a model has been projected out, without constraints.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from expdesign.arrays import FloatArray, as_matrix
from expdesign.chain.component import BASE, GEOMETRY, INSTRUMENT, PLATFORM
from expdesign.diagnosis.base_models import base_model
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit
from expdesign.mechanics.robots.robot import Robot

_NEGLIGIBLE = 1e-4
"""Directions of which the model already explains all but this share of the length carry no information."""
_ALIKE = 3e-4
"""Singular value, in units of the largest, below which scaled directions are the same."""


def orthonormal_basis(sensitivities: FloatArray, alike: float = 1e-9) -> FloatArray:
    """Basis (M, r) of the space spanned by whitened sensitivities (M, p); `alike`: singular value that is none."""
    norms = np.linalg.norm(sensitivities, axis=0)
    scaled = sensitivities[:, norms > 0.0] / norms[norms > 0.0]
    left, values, _ = np.linalg.svd(scaled, full_matrices=False)
    basis: FloatArray = left[:, values > alike * values[:1]]
    return basis


def explained(residuals: FloatArray, basis: FloatArray, directions: FloatArray) -> tuple[float, int]:
    """Reduction of χ² by the best combination of directions, and how many of them are independent.

    Args:
        residuals: whitened, shape (M,).
        basis: orthonormal, of the model that was fitted to them, shape (M, r).
        directions: whitened, shape (M, d).
    """
    free = directions - basis @ (basis.T @ directions)
    there = np.linalg.norm(free, axis=0) > _NEGLIGIBLE * np.linalg.norm(directions, axis=0)
    if not there.any():
        return 0.0, 0
    own = orthonormal_basis(free[:, there], _ALIKE)
    return float(((own.T @ residuals) ** 2).sum()), own.shape[1]


_FORCE_BINS = 5
_ACROSS = {"joint_compliance"}
_LOAD = {"payload_com_offset", "load_direction_tilt"}


@dataclass(frozen=True)
class Probe:
    """One place where the mismatch could be.

    Attributes:
        name: component, or what the residuals are compared with.
        explained: part of χ² that it explains beyond the base model.
        dimension: independent directions.
        p_value: corrected for the number of probes of the table.
    """

    name: str
    explained: float
    dimension: int
    p_value: float


@dataclass(frozen=True)
class Location:
    """Where the mismatch is.

    Attributes:
        components: by `Probe`, the best explanations first.
        patterns: dependences of the residuals on pose, load, time, order and further columns, likewise.
        axes: measured components whose residuals exceed the noise.
        region: in words.
    """

    components: tuple[Probe, ...]
    patterns: tuple[Probe, ...]
    axes: tuple[str, ...]
    region: str


def locate(base: Fit, sample: Data, robot: Robot, library: list[Candidate], noise_variance: float) -> Location:
    """Locate the mismatch of the base fit; `noise_variance` is that of the whitened residuals (1 where it is known)."""
    basis = orthonormal_basis(as_matrix(base.sensitivities))
    residuals = base.residuals.ravel() / np.sqrt(noise_variance)

    def tested(directions: dict[str, FloatArray]) -> tuple[Probe, ...]:
        return _holm([(name, *explained(residuals, basis, block)) for name, block in directions.items()])

    patterns = tested({name: _pattern(values, sample) for name, values in drivers(sample, robot).items()})
    significant = [probe.name for probe in patterns if probe.p_value < OPTIONS.level]
    region = (
        "varies most with " + ", ".join(significant[:3]) if significant else "spread over all poses, loads and times"
    )
    components = tested(_component_directions(sample, robot, library))
    return Location(components, patterns, _axes(base, sample, robot, noise_variance), region)


def _component_directions(sample: Data, robot: Robot, library: list[Candidate]) -> dict[str, FloatArray]:
    """Whitened directions (M, d) of every component."""
    n, n_p = robot.coordinates.n, len(robot.stiffness)
    recordings = sample.recordings
    jacobians = robot.jacobians(recordings.configurations)
    force = np.einsum("nij,ni->nj", jacobians.forward, recordings.wrenches)
    blocks: dict[str, FloatArray] = {}
    kind = base_model(robot, sample.reading)
    for leg in range(n_p if kind.elastic else 0):
        edges = np.quantile(force[:, leg], np.linspace(0.0, 1.0, _FORCE_BINS + 1)[1:-1])
        inside = np.eye(_FORCE_BINS)[np.searchsorted(edges, force[:, leg])]
        moved = jacobians.pose[:, :, leg, None] * inside[:, None, :]
        blocks[robot.actuators[leg]] = sample.whiten(moved[:, recordings.axes]).reshape(-1, _FORCE_BINS)
    by_component: dict[str, list[FloatArray]] = {}
    for candidate in library:
        effect = candidate.effect
        if str(effect.variant) == "diagonal" or len(candidate.directions) > 1:
            continue
        anywhere = effect.component in (PLATFORM, BASE, INSTRUMENT, GEOMETRY) or effect.physics in _LOAD
        # A joint's own directions are any function of its torque; an arm's may also yield across its axis.
        within = kind.own_directions(effect.component.part) or effect.physics in _ACROSS
        if anywhere or within:
            by_component.setdefault(str(effect.component), []).append(candidate.directions[0].matrix())
    for component, directions in by_component.items():
        known = [blocks[component]] if component in blocks else []
        blocks[component] = np.concatenate([*known, *directions], axis=1)
    time = sample.rows.position.astype(float) if recordings.time is None else recordings.time - recordings.time[0]
    drift = time / max(float(np.ptp(time)), 1e-300)
    constant = np.repeat(np.eye(n)[None], len(recordings), axis=0)
    drifting = np.concatenate([constant, constant * drift[:, None, None]], axis=2)
    blocks["environment"] = sample.whiten(drifting[:, recordings.axes]).reshape(-1, 2 * n)
    return blocks


def drivers(sample: Data, robot: Robot) -> dict[str, FloatArray]:
    """Quantities with which residuals may vary, one value per row."""
    recordings = sample.recordings
    found = {name: recordings.configurations[:, i] for i, name in enumerate(robot.configuration)}
    found |= {name: recordings.wrenches[:, i] for i, name in enumerate(robot.coordinates.wrench)}
    size = np.linalg.norm(recordings.wrenches[:, : robot.coordinates.translations], axis=1)
    found["size of the load"] = size
    change = np.where(sample.rows.position > 0, np.diff(size, prepend=size[:1]), 0.0)
    forces = np.einsum("nij,ni->nj", robot.jacobians(recordings.configurations).forward, recordings.wrenches)
    found |= {f"force in {name}": forces[:, i] for i, name in enumerate(robot.actuators)}
    found["loading against unloading"] = np.sign(change)
    found["place in the series"] = sample.rows.position.astype(float)
    found["order of recording"] = recordings.sequence.astype(float)
    if recordings.time is not None:
        found["time_s"] = recordings.time
    if recordings.temperature is not None:
        found["temperature_degC"] = recordings.temperature
    found |= recordings.further
    return {name: values for name, values in found.items() if np.ptp(values) > 0.0}


def _pattern(driver: FloatArray, sample: Data) -> FloatArray:
    """Directions (M, d) in which a straight line or parabola in a driver (N,) moves all axes."""
    scaled = (driver - driver.mean()) / max(float(driver.std()), 1e-300)
    powers = np.stack([scaled, scaled**2 - 1.0], axis=1) if len(np.unique(driver)) > 3 else scaled[:, None]
    counted: FloatArray = np.kron(powers * sample.counts[:, None], np.eye(len(sample.recordings.axes)))
    return counted


def _holm(results: list[tuple[str, float, int]]) -> tuple[Probe, ...]:
    """Probes with Holm's corrected p-values, by how far what they explain exceeds chance."""
    raw = np.array([float(chdtrc(max(size, 1), value)) for _, value, size in results])
    order = np.argsort(raw, kind="stable")
    corrected = np.empty(len(raw))
    corrected[order] = np.minimum(np.maximum.accumulate(raw[order] * (len(raw) - np.arange(len(raw)))), 1.0)
    probes = [Probe(name, value, size, float(p)) for (name, value, size), p in zip(results, corrected, strict=True)]
    return tuple(sorted(probes, key=lambda probe: (probe.p_value, -(probe.explained - probe.dimension))))


def _axes(base: Fit, sample: Data, robot: Robot, noise_variance: float) -> tuple[str, ...]:
    """Axes whose residuals exceed the noise, or the one with the largest."""
    rows = int(sample.counts.sum())
    sums = (base.residuals**2).sum(axis=0) / noise_variance
    share = base.rank / len(sample.recordings.axes)
    p_values = chdtrc(max(rows - share, 1.0), sums) * len(sums)
    names = [sample.recordings.components(robot.coordinates)[axis] for axis in sample.recordings.axes]
    chosen = [name for name, p in zip(names, p_values, strict=True) if p < OPTIONS.level]
    return tuple(chosen) if chosen else (names[int(np.argmax(sums))],)
