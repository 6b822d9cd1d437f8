"""Figures that the reconstruction knows, in the kept results of the studies on hexapods."""

import numpy as np
import pytest

from research.studies.tests.kept import kept


def test_centre_of_mass_of_120_kg() -> None:
    """C10: 4.4 µm without compensation, (0.54, 0.54) µrad left of rx and ry, whatever the poses of the plan."""
    deflection = kept("centre-of-mass", "uncompensated")["deflection"]
    assert np.linalg.norm(deflection[:3]) == pytest.approx(4.4, abs=0.05)
    residual = kept("centre-of-mass", "residual").set_index(["distribution", "axis"])["std_predicted"]
    assert residual["normal", "rx (µrad)"] == pytest.approx(0.54, abs=0.01)
    assert residual["normal", "ry (µrad)"] == pytest.approx(0.54, abs=0.01)


def test_rotation_that_leaks_into_a_mirror() -> None:
    """C15: −0.15 and +0.10 at rx = 0.10, ry = 0.15 rad."""
    first = kept("five-axis-mirror", "target").iloc[0]
    assert first["leak_x"] == pytest.approx(-0.15, abs=0.002)
    assert first["leak_y"] == pytest.approx(0.10, abs=0.002)


def test_z34_along_x() -> None:
    """C10: 0 at x = 0, even in x, 4.4e-9 1/N at ±30 mm for equal legs."""
    table = kept("hexapod-load-errors", "criterion")
    equal = table[table["legs"] == "equal"].set_index("place_mm")["z34_per_N"]
    assert abs(equal[30.0]) == pytest.approx(4.4e-9, abs=0.05e-9)
    assert equal[-30.0] == pytest.approx(equal[30.0], rel=1e-5)
    assert abs(equal[0.0]) < 1e-15
    unequal = table[table["legs"] == "unequal"].set_index("place_mm")["z34_per_N"]
    assert abs(unequal[0.0]) > 1e-9


def test_correlations_are_worth_knowing() -> None:
    """C15: the RMS with the correlations is smaller on translations and on rotations."""
    rms = kept("pose-measurement", "gain").set_index(["scaling", "block"])["rms_predicted"]
    for block in ("translation (µm)", "rotation (µrad)"):
        assert rms["G_C", block] < rms["G_U", block]


def test_reference_poses_remove_drift_at_the_price_of_three_poses() -> None:
    """C12: the RMS of z falls to what noise makes of it; the price is that of V + 2TVTᵀ, about √3."""
    rms = kept("thermal-reference", "rms").set_index(["drift", "method", "axis"])
    before, after = rms.loc["steps", "none", "z (µm)"], rms.loc["steps", "reference before", "z (µm)"]
    assert after["rms"] < 0.5 * before["rms"]
    assert after["rms_predicted"] == pytest.approx(after["noise"], rel=1e-3)
    price = kept("thermal-reference", "price")["price"]
    assert price.between(1.6, 1.9).all()


def test_geometric_calibration_has_42_parameters() -> None:
    """C11: rank 42 with 24 poses; frames add parameters and no rank."""
    variants = kept("geometric-calibration", "variants").set_index(["calibration", "frames", "wanted"])
    known = variants.loc["geometric", "known", "reading of the instrument"]
    unknown = variants.loc["geometric", "unknown", "reading of the instrument"]
    assert (known["rank"], known["parameters"], unknown["rank"], unknown["parameters"]) == (42, 42, 42, 54)
    assert unknown["duir"] == pytest.approx(known["duir"], rel=1e-5)
    assert np.isnan(variants.loc["geometric", "unknown", "pose in the robot's own frame"]["duir"])


def test_intervals_cover_and_compensation_works() -> None:
    """95 % of intervals contain the true stiffness; what is left is far below the deflection of about 11 µm."""
    attained = kept("hexapod-compensation", "attained")
    assert (attained["efficiency"] > 0.95).all()
    deflection = attained.loc[attained["block"] == "translation (µm)", "without"]
    assert deflection.between(9.0, 15.0).all()


def test_lumped_stiffness_explains_deflections() -> None:
    """The identified stiffnesses predict what was not fitted to about the noise of one reading."""
    along = kept("lumped-stiffness", "along")
    z = along[along["axis"] == "z (µm)"]
    assert np.sqrt(((z["measured"] - z["predicted"]) ** 2).mean()) < 2.0 * 0.5
