"""Known rigid motions with known noise: unbiased deflections, and a covariance that is that of the errors."""

from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from expdesign.estimation.preparation.point_lists import MeasuredPoint, PointSet
from expdesign.estimation.preparation.registered_deflections import (
    InstrumentFrame,
    RegisteredDeflection,
    difference_variance,
    registered_deflection,
    suspicion,
)
from expdesign.estimation.preparation.states import RecordedState
from tests.cases import symmetric_hexapod

ROBOT = symmetric_hexapod(0.24, 0.17, 0.30, 0.03, 5.24e6)
POSE = np.array([0.01, -0.02, 0.015, 0.1, -0.08, 0.15])
DEFLECTION = np.array([12e-6, -7e-6, -35e-6, 40e-6, -25e-6, 60e-6])
MARKERS = {
    "a": np.array([0.2, 0.0, 0.05]),
    "b": np.array([-0.1, 0.17, 0.0]),
    "c": np.array([-0.1, -0.17, 0.1]),
    "d": np.array([0.05, 0.05, 0.2]),
}
INSTRUMENT = (Rotation.from_euler("xyz", [0.3, -0.5, 2.0]).as_matrix(), np.array([2.0, -3.0, 1.0]))
STD = np.array([5e-6, 8e-6, 15e-6])
"""m, along the axes of the instrument."""


def frame() -> InstrumentFrame:
    jacobians = ROBOT.jacobians(POSE)
    return InstrumentFrame(jacobians.rotation, ROBOT.position(POSE), jacobians.pose @ np.linalg.inv(jacobians.forward))


def seen(pose: FloatArray, names: str = "abcd") -> FloatArray:
    """Positions of the markers in the instrument's frame."""
    places = np.array([MARKERS[name] for name in names])
    base = places @ ROBOT.jacobians(pose).rotation.T + ROBOT.position(pose)
    return (base - INSTRUMENT[1]) @ INSTRUMENT[0]


def points(name: str, positions: FloatArray, names: str = "abcd", std: FloatArray | None = STD) -> PointSet:
    rows = zip(names, positions, strict=True)
    return PointSet(name, "points.txt", {key: MeasuredPoint(row, std, "points.txt") for key, row in rows})


def found(
    generator: np.random.Generator | None, std: FloatArray | None = STD, **options: object
) -> RegisteredDeflection:
    noise = np.zeros((2, 4, 3)) if generator is None else generator.normal(scale=STD, size=(2, 4, 3))
    state = RecordedState(
        0,
        points("loaded-1", seen(POSE + DEFLECTION) + noise[1], std=std),
        points("unloaded-1", seen(POSE) + noise[0], std=std),
    )
    known: dict[str, object] = {"markers": MARKERS, "instrument": None, "deviation": None} | options
    return registered_deflection(state, frame(), **known)  # type: ignore[arg-type]


@pytest.mark.parametrize("known", [{}, {"markers": {}, "instrument": INSTRUMENT}], ids=["markers", "instrument"])
def test_a_motion_without_noise_is_recovered_to_second_order(known: dict[str, Any]) -> None:
    """(60 µrad)² · 0.2 m is less than a nanometre, and half the square of the angle less than 2 nrad."""
    errors = np.abs(found(None, **known).deflection - DEFLECTION)
    assert np.all(errors < 4e-9)
    assert np.all(np.abs(found(None, **known).residuals) < 1e-14)


def test_deflections_are_unbiased_and_their_covariance_is_right() -> None:
    """600 measurements: means within 4 standard errors, variances within 4·√(2/600), and e'C⁻¹e as χ² of 6."""
    generator, trials = np.random.default_rng(8), 600
    errors, covariance, doubts = [], found(None).covariance(0.0), 0
    for _ in range(trials):
        one = found(generator)
        errors.append(one.deflection - DEFLECTION)
        doubts += suspicion(one, None) is not None
        np.testing.assert_allclose(one.covariance(0.0), covariance, rtol=2e-3, atol=1e-3 * np.abs(covariance).max())
    assert doubts <= 1
    drawn = np.array(errors)
    deviations = np.sqrt(np.diag(covariance))
    assert np.all(np.abs(drawn.mean(axis=0)) < 4.0 * deviations / np.sqrt(trials) + 4e-9)
    ratio = drawn.var(axis=0) / np.diag(covariance)
    assert np.all(np.abs(ratio - 1.0) < 4.0 * np.sqrt(2.0 / trials))
    squares = np.einsum("ni,ij,nj->n", drawn, np.linalg.inv(covariance), drawn)
    assert abs(squares.mean() - 6.0) < 4.0 * np.sqrt(12.0 / trials)
    correlation = covariance / np.outer(deviations, deviations)
    assert np.abs(np.corrcoef(drawn.T) - correlation).max() < 4.5 / np.sqrt(trials)


def test_the_deviation_is_estimated_where_it_is_not_stated() -> None:
    """200 registrations of 4 points leave 1,200 degrees of freedom: σ² within 4·√(2/1200), the mean over the axes."""
    generator = np.random.default_rng(9)
    several = [found(generator, std=None) for _ in range(200)]
    variance = difference_variance(several)
    assert variance is not None
    assert several[0].variances is None
    assert abs(variance / (2.0 * (STD**2).mean()) - 1.0) < 0.35  # anisotropic noise: not all directions leave as much
    even = several[0].covariance(2.0 * 1e-10)
    np.testing.assert_allclose(even, found(None, deviation=1e-5).covariance(0.0), rtol=1e-2, atol=1e-14)


@pytest.mark.parametrize("index", range(4))
def test_a_point_that_moved_is_named(index: int) -> None:
    moved = seen(POSE + DEFLECTION)
    moved[index] += 200e-6
    state = RecordedState(0, points("loaded-1", moved), points("unloaded-1", seen(POSE)))
    one = registered_deflection(state, frame(), markers=MARKERS, instrument=None, deviation=None)
    assert f"point {'abcd'[index]} moved differently" in str(suspicion(one, None))
    assert suspicion(found(np.random.default_rng(1)), None) is None


def test_what_is_refused() -> None:
    def registered(names: str, **options: object) -> None:
        state = RecordedState(
            0, points("loaded-1", seen(POSE, names), names), points("unloaded-1", seen(POSE, names), names)
        )
        known: dict[str, object] = {"markers": MARKERS, "instrument": None, "deviation": None} | options
        registered_deflection(state, frame(), **known)  # type: ignore[arg-type]

    with pytest.raises(InputError, match="only 2 points have the same name"):
        registered("ab")
    with pytest.raises(InputError, match="nothing says how the instrument's frame lies"):
        registered("abcd", markers={})
    with pytest.raises(InputError, match="do not lie as the robot's `markers` say"):
        registered("abcd", markers={name: 0.5 * place for name, place in MARKERS.items()})
    line = {name: np.array([0.1 * index, 0.0, 0.0]) for index, name in enumerate("abc")}
    state = RecordedState(
        0, points("l", np.array(list(line.values())), "abc"), points("u", np.array(list(line.values())), "abc")
    )
    with pytest.raises(InputError, match="lie on one line"):
        registered_deflection(state, frame(), markers=MARKERS, instrument=None, deviation=None)
