"""Exact gradients against finite differences of the criteria's own code, over robots, loads, noises and criteria."""

from typing import Any

import numpy as np
import pytest
from tests.design.problems import BIPOD, HEXAPOD, problem
from tests.oracle import Array

from expdesign.criteria.assessment import Assessment
from expdesign.criteria.criterion import Criterion, known_criteria
from expdesign.design.optimality.gradient_check import gradient_check, gradient_table
from expdesign.design.optimality.gradients import criterion_gradients
from expdesign.design.optimality.measurement_maps import MeasurementMaps
from expdesign.design.optimality.partials import pieces
from expdesign.design.optimality.sensitivity import DesignModel
from expdesign.design.problem import DesignProblem
from expdesign.design.start import starting_designs

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


def designs(here: DesignProblem, count: int, seed: int = 0) -> Array:
    space = here.space
    return starting_designs(here, count, np.random.default_rng(seed)).reshape(count, space.measurements, space.genes)


@pytest.mark.parametrize("name", CASES)
def test_every_criterion_of_every_case_has_its_gradient(name: str) -> None:
    here = a_problem(name)
    table = gradient_check(here, designs(here, 1)[0])
    assert set(table["criterion"]) == set(known_criteria())
    # Central differences reach 1e-9 of the largest derivative here; a wrong term is wrong by its own size.
    assert table["relative_error"].max() < 2e-8
    largest = table.groupby("criterion")["gradient"].apply(lambda column: column.abs().max())
    with_errors = here.loaded.sources != ()
    assert (largest.drop([] if with_errors else ["feir"]) > 0.0).all()


def test_the_check_finds_a_wrong_gradient(monkeypatch: pytest.MonkeyPatch) -> None:
    here = a_problem("hexapod")
    right = DesignModel.to_genes
    monkeypatch.setattr(DesignModel, "to_genes", lambda model, values: 1.001 * right(model, values))
    table = gradient_check(here, designs(here, 1)[0], ["duir"])
    assert table["relative_error"].max() > 1e-4
    assert gradient_table(here, designs(here, 2), ["duir"])["verdict"].tolist() == ["fail"]


def test_the_table_shows_truncation_and_rounding() -> None:
    here = a_problem("hexapod")
    table = gradient_table(here, designs(here, 2), ["duir", "feir"])
    assert table["verdict"].tolist() == ["pass", "pass"]
    errors = table[["1e-04", "1e-05"]]
    # The error of a central difference falls with the square of the step, until rounding takes over.
    assert (errors.iloc[:, 0] > 30.0 * errors.iloc[:, 1]).all()
    assert (table["1e-09"] > 3.0 * table["at best steps"]).all()
    assert table["worst variable"].str.contains(" of measurement ").all()


def test_what_has_no_value_is_not_evaluated() -> None:
    here = problem(HEXAPOD, {"experiment.load": {"kind": "payload", "mass_kg": [0.0, 5.0]}})
    genes = designs(here, 1)
    mass = [i for i, variable in enumerate(here.space.variables) if variable.columns[0] == here.space.n_pose]
    genes[..., mass] = 0.0
    assert gradient_table(here, genes, ["duir"])["verdict"].tolist() == ["not evaluated"]


@pytest.mark.parametrize("name", ["bipod", "hexapod"])
def test_shared_references_are_differentiated_as_they_are(name: str) -> None:
    base, changes = CASES[name]
    here = problem(
        base, {**changes, "experiment.deflection_noise.shared_reference": True, "experiment.measurements": 3}
    )
    genes = designs(here, 1)[0]
    poses = [i for i, variable in enumerate(here.space.variables) if variable.columns[0] < here.space.n_pose]
    genes[1, poses] = genes[0, poses]
    assert gradient_check(here, genes)["relative_error"].max() < 2e-8
    alone = problem(base, {**changes, "experiment.measurements": 3})
    shared, separate = (criterion_gradients(p, genes[None], ["duir"])["duir"][0][0] for p in (here, alone))
    assert abs(shared / separate - 1.0) > 1e-3


@pytest.mark.parametrize("name", ["bipod", "hexapod", "geometric-stiffness", "wrench", "both-calibrations"])
def test_the_maps_are_the_model_of_the_criteria(name: str) -> None:
    here = a_problem(name)
    genes = designs(here, 4)
    measured = here.loaded.measure(*here.space.decode(genes))
    maps = MeasurementMaps(here)
    quantities = here.space.quantities(genes)
    tape = maps.run(quantities.reshape(-1, quantities.shape[-1]))
    whitener, axes = here.noise.whitener, here.noise.axes
    expected = whitener @ measured.observation[:, :, axes]
    np.testing.assert_allclose(tape.observation.reshape(expected.shape), expected, rtol=1e-11)
    errors = np.concatenate([measured.compliance @ error for error in measured.load_errors], axis=-1)
    whitened = whitener @ errors[:, :, axes]
    np.testing.assert_allclose(tape.errors.reshape(whitened.shape), whitened, rtol=1e-9, atol=1e-12)


def test_values_are_those_of_the_criteria() -> None:
    here = a_problem("largest-target")
    genes = designs(here, 6)
    assessment = here.assess(*here.space.decode(genes))
    for name, (values, _) in criterion_gradients(here, genes, list(known_criteria())).items():
        np.testing.assert_allclose(values, known_criteria()[name].values(assessment), rtol=1e-10)


def test_discrete_genes_have_no_gradient() -> None:
    here = a_problem("hexapod")
    gradient = criterion_gradients(here, designs(here, 5), ["total"])["total"][1]
    assert here.space.discrete.any()
    assert (gradient[..., here.space.discrete] == 0.0).all()
    assert (gradient[..., ~here.space.discrete] != 0.0).any(axis=(0, 1)).all()


def test_a_design_that_identifies_too_little_has_no_value_and_no_gradient() -> None:
    here = problem(HEXAPOD, {"experiment.load": {"kind": "payload", "mass_kg": [0.0, 5.0]}})
    genes = designs(here, 2)
    mass = [i for i, variable in enumerate(here.space.variables) if variable.columns[0] == here.space.n_pose]
    genes[0][:, mass] = 0.0
    values, gradient = criterion_gradients(here, genes, ["duir"])["duir"]
    assert np.isnan(values[0])
    assert np.isfinite(values[1])
    assert (gradient[0] == 0.0).all()


class _Unknown(Criterion):
    """A criterion that a user adds: the mean of DUIR and the cube root of the largest singular value's inverse."""

    name = "unknown"
    title = "unknown"

    def values(self, assessment: Assessment) -> Array:
        duir = assessment.aggregated(assessment.weighted(assessment.noise_variance))
        return duir + assessment.singular_values[:, 0] ** (-1.0 / 3.0)


def test_a_criterion_of_ones_own_is_differentiated_through_its_code() -> None:
    here = a_problem("hexapod")
    genes = designs(here, 3)
    state = DesignModel(here).run(genes)
    piece = pieces(_Unknown(), state)[0]
    gradient = piece.gradient(state)
    duir, slope = criterion_gradients(here, genes, ["duir"])["duir"]
    largest = state.singular_values[:, 0]
    np.testing.assert_allclose(piece.value, duir + largest ** (-1.0 / 3.0), rtol=1e-12)
    partials = np.zeros_like(state.singular_values)
    partials[:, 0] = -(largest ** (-4.0 / 3.0)) / 3.0
    np.testing.assert_allclose(gradient, slope + state.gradient(by_singular=partials), rtol=1e-9, atol=1e-12)
