"""Study 3: the two fronts agree within the grid's step, the compromises lie on them, lengths have their moments."""

import numpy as np
import pytest

from research.studies.bipod_pareto import BipodPareto, behind
from research.studies.error_norm import planar_norm_moments
from research.studies.tests.kept import kept

STUDY = BipodPareto.name()


def test_fronts_agree_within_the_grids_step() -> None:
    row = kept(STUDY, "agreement").iloc[0]
    assert 0.0 < row["nsga2_behind_um"] <= row["grid_step_um"]
    assert row["grid_behind_um"] <= row["grid_step_um"]
    front, levels = kept(STUDY, "front"), kept(STUDY, "front-nsga2")
    # A step of the grid is a few per cent of the front's own range: the agreement says something.
    assert row["grid_step_um"] < 0.05 * np.ptp(front["feir"])
    for duir, feir in levels.itertuples(index=False):
        # Where the front jumps, a design within a step in DUIR decides on which side of the jump it lies.
        better = front["feir"][front["duir"] <= duir + row["grid_step_um"]].min()
        worse = front["feir"][front["duir"] <= duir - row["grid_step_um"]].min()
        assert better - row["grid_step_um"] <= feir
        assert np.isnan(worse) or feir <= worse + row["grid_step_um"]


def test_front_is_not_dominated() -> None:
    front = kept(STUDY, "front")
    assert (np.diff(front["duir"]) > 0.0).all()
    assert (np.diff(front["feir"]) < 0.0).all()
    best = kept(STUDY, "montecarlo").set_index("best_by")
    assert best.loc["duir", "duir"] == front["duir"].min() <= best["duir"].min()
    assert best.loc["feir", "feir"] == front["feir"].min() <= best["feir"].min()
    total = np.hypot(front["duir"], front["feir"])
    row = best.loc["total"]
    assert np.hypot(row["duir"], row["feir"]) == pytest.approx(total.min(), rel=1e-5)
    nearest = np.hypot(front["duir_scaled"], front["feir_scaled"]).idxmin()
    assert best.loc["compromise", "duir"] == front.loc[nearest, "duir"]


def test_behind_is_the_shift_that_is_needed() -> None:
    front = np.array([[0.0, 1.0], [1.0, 0.0]])
    assert behind(front, front) == 0.0
    assert behind(front + 0.25, front) == 0.25
    assert behind(front, np.array([[0.5, 0.5]])) == 0.5


@pytest.mark.parametrize("small", [1e-6, 0.2, 1.0])
def test_moments_of_the_length(small: float) -> None:
    """A line (half-normal), an ellipse by quadrature, and a circle (Rayleigh)."""
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    mean, deviation = planar_norm_moments(turn @ np.diag([1.0, small**2]) @ turn.T)
    angles = np.linspace(0.0, 2.0 * np.pi, 20_001)[:-1]
    expected = np.sqrt(np.pi / 2.0) * np.hypot(np.cos(angles), small * np.sin(angles)).mean()
    assert mean == pytest.approx(expected, rel=1e-6)
    assert deviation == pytest.approx(np.sqrt(1.0 + small**2 - expected**2), rel=1e-6)
