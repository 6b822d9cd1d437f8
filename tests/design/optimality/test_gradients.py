"""Exact gradients against finite differences of the criteria's own code, over robots, loads, noises and criteria."""

from typing import Any

import numpy as np
import pytest

from expdesign.errors import InputError
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, known_criteria
from expdesign.planning.optimality import differentiated
from expdesign.planning.optimality.differentiated import Differentiated
from expdesign.planning.problem import DesignProblem
from tests.design.optimality.central_differences import criterion_gradients, errors_of_gradients
from tests.design.problems import BIPOD, HEXAPOD, designs, problem
from tests.oracle import Array

WRENCH = {
    "kind": "wrench",
    "fx_N": [-200.0, 200.0],
    "fy_N": [-200.0, 200.0],
    "fz_N": [-300.0, 0.0],
    "mx_Nm": [-20.0, 20.0],
    "my_Nm": [-20.0, 20.0],
    "mz_Nm": {"choices": [-20.0, 20.0]},
}
COVARIANCE = (np.diag([5e-7] * 3 + [2e-6] * 3) @ (np.eye(6) + 0.3) @ np.diag([5e-7] * 3 + [2e-6] * 3)).tolist()
OWN_ERRORS = [
    {"source": "com", "std": [0.001, 0.002, 0.001], "shared": False},
    {"source": "direction", "std": [0.0005, 0.0005], "shared": False},
]

CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "bipod": (BIPOD, {}),
    "bipod-payload": (BIPOD, {"experiment.load": {"kind": "payload", "mass_kg": [20.0, 100.0]}}),
    "hexapod": (HEXAPOD, {}),
    "largest-target": (HEXAPOD, {"aggregate": "max"}),
    "moving-axes": (HEXAPOD, {"robot.orientation": "moving-xyz"}),
    "geometric-stiffness": (HEXAPOD, {"experiment.geometric_stiffness": True}),
    "geometric-stiffness-no-errors": (
        HEXAPOD,
        {"experiment.geometric_stiffness": True, "experiment.load_error": []},
    ),
    "own-errors": (HEXAPOD, {"experiment.load_error": OWN_ERRORS}),
    "weighted": (HEXAPOD, {"experiment.estimator": "weighted"}),
    "weighted-own-errors": (HEXAPOD, {"experiment.estimator": "weighted", "experiment.load_error": OWN_ERRORS}),
    "wrench": (
        HEXAPOD,
        {
            "experiment.load": WRENCH,
            "experiment.load_error": [{"source": "direction", "std": [0.001, 0.001]}],
        },
    ),
    "correlated": (HEXAPOD, {"experiment.deflection_noise": {"covariance": COVARIANCE}}),
    "both-calibrations": (HEXAPOD, {"experiment.calibration": "both", "experiment.measurements": 9}),
    "geometric": (
        HEXAPOD,
        {
            "experiment.calibration": "geometric",
            "experiment.measurements": 8,
            "experiment.load": ...,
            "experiment.load_error": [],
            "targets": [{"pose": [0.02, 0.0, 0.0, 0.05, 0.0, 0.0], "tolerance": {"dx_m": 1e-6, "drz_rad": 1e-5}}],
        },
    ),
    "geometric-bipod": (
        BIPOD,
        {
            "experiment.calibration": "both",
            "experiment.measurements": 8,
            "experiment.geometric_stiffness": True,
        },
    ),
    "reference-pose": (HEXAPOD, {"experiment.reference_pose": {"pose": [0.0, 0.0, 0.01, 0.05, 0.0, 0.0]}}),
    "reference-pose-correlated": (
        HEXAPOD,
        {
            "experiment.reference_pose": {"pose": [0.01, 0.0, 0.01, 0.05, 0.0, 0.0], "interpolate": True},
            "experiment.deflection_noise": {"covariance": COVARIANCE},
        },
    ),
    "three-axes": (
        HEXAPOD,
        {"experiment.deflection_noise": {"std": {"dx_m": 5e-7, "dz_m": 5e-7, "drx_rad": 2e-6}}},
    ),
}


def a_problem(name: str) -> DesignProblem:
    base, changes = CASES[name]
    return problem(base, changes)


@pytest.mark.parametrize("name", CASES)
def test_every_criterion_of_every_case_has_its_gradient(name: str) -> None:
    here = a_problem(name)
    # Central differences reach 1e-9 of the largest derivative here; a wrong term is wrong by its own size.
    assert max(errors_of_gradients(here, designs(here, 1)).values()) < 4e-8
    with_errors, assessed = here.loaded.sources != (), here.assessed(designs(here, 1))
    for criterion, (value, gradient) in criterion_gradients(here, designs(here, 1), list(known_criteria())).items():
        np.testing.assert_allclose(value, known_criteria()[criterion].values(assessed), rtol=1e-8)
        assert (criterion == "feir" and not with_errors) or np.abs(gradient).max() > 0.0


def test_the_check_finds_a_wrong_gradient(monkeypatch: pytest.MonkeyPatch) -> None:
    here = a_problem("hexapod")
    right = differentiated.to_variables
    monkeypatch.setattr(differentiated, "to_variables", lambda problem, values: 1.001 * right(problem, values))
    assert errors_of_gradients(here, designs(here, 2), ["duir"])["duir"] > 1e-4


def test_a_design_that_identifies_too_little_has_no_value_and_no_gradient() -> None:
    here = problem(HEXAPOD, {"experiment.load": {"kind": "payload", "mass_kg": [0.0, 5.0]}})
    decisions = designs(here, 2)
    mass = [i for i, variable in enumerate(here.space.variables) if variable.columns[0] == here.space.n_pose]
    decisions[0][:, mass] = 0.0
    values, gradient = criterion_gradients(here, decisions, ["duir"])["duir"]
    assert np.isnan(values[0])
    assert np.isfinite(values[1])
    assert (gradient[0] == 0.0).all()


class _Unknown(Criterion):
    """A criterion that a user adds: DUIR, the largest singular value, and the largest off-diagonal part of U."""

    name = "unknown"
    title = "unknown"

    def values(self, assessment: Assessment) -> Array:
        duir = assessment.aggregated(assessment.weighted(assessment.noise_variance))
        root = assessment.noise_root
        coupled = root[:, :, :3] @ root[:, :, 3:].swapaxes(-1, -2)
        share = np.sqrt((coupled**2).sum(axis=(-2, -1))).mean(axis=-1)
        return duir + 1e10 * share + np.log(assessment.singular_values[:, 0])


def test_a_criterion_of_ones_own_is_differentiated_through_its_code() -> None:
    here = a_problem("hexapod")
    free = ~here.space.discrete
    span = (here.space.upper - here.space.lower) * free
    decisions = designs(here, 3)
    piece = Differentiated.of_designs(here, decisions).pieces(_Unknown())[0]
    gradient = piece.gradient()
    np.testing.assert_allclose(piece.value, _Unknown().values(here.assess(*here.space.decode(decisions))), rtol=1e-12)
    direction = np.random.default_rng(1).standard_normal(decisions.shape) * span
    step = 1e-6
    high, low = (_Unknown().values(here.assess(*here.space.decode(decisions + s * step * direction))) for s in (1, -1))
    np.testing.assert_allclose((high - low) / (2.0 * step), (gradient * direction).sum(axis=(1, 2)), rtol=1e-6)


class _Looped(Criterion):
    name = "looped"
    title = "looped"

    def values(self, assessment: Assessment) -> Array:
        values = np.zeros(assessment.batch)
        for index in range(assessment.batch):
            values[index] = assessment.noise_variance[index].sum()
        return values


def test_a_criterion_that_cannot_be_differentiated_is_named_with_a_remedy() -> None:
    here = a_problem("bipod")
    decisions = designs(here, 2)
    assert np.isfinite(_Looped().values(here.assess(*here.space.decode(decisions)))).all()
    with pytest.raises(InputError) as raised:
        Differentiated.of_designs(here, decisions).pieces(_Looped())
    assert "looped" in str(raised.value)
    assert "objectives" in str(raised.value)


def test_a_tied_maximum_has_the_gradient_of_each_of_its_pieces() -> None:
    here = a_problem("largest-target")
    decisions = designs(here, 4)
    found = Differentiated.of_designs(here, decisions).pieces(known_criteria()["duir"])
    assessment = here.assess(*here.space.decode(decisions))
    squares = np.sort(assessment.weighted(assessment.noise_variance), axis=1)[:, ::-1]
    assert len(found) == squares.shape[1]
    for place, piece in enumerate(found):
        np.testing.assert_allclose(piece.value, np.sqrt(squares[:, place]), rtol=1e-12)
