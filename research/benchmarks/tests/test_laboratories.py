"""The benchmarks of simulated laboratories and of real sets count what they say they count."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from research.benchmarks import laboratories, real_sets
from research.benchmarks.laboratories import Laboratory, drawn, page, share
from research.benchmarks.real_sets import SERIES, Outcome, in_series, read_outcomes, write_outcomes


def test_every_other_laboratory_hides_physics_that_changes_its_readings() -> None:
    plan = pd.DataFrame([[1, 1, 0.02, 0.0, 0.0, 0.1, 0.0, 0.0, 26.5, 0.05, 0.02, 0.12]],
                        columns=["sequence", "series", "x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad",
                                 "mass_kg", "com_x_m", "com_y_m", "com_z_m"])  # fmt: skip
    for seed in range(8):
        truth, hidden = drawn(seed)
        assert drawn(seed) == (truth, hidden)
        assert bool(hidden) == bool(seed % 2)
        bare, own = (xd.simulate(truth, plan, conceal=each, noise=False).frame for each in ((), hidden or ()))
        moved = np.abs(own["dz_m"] - bare["dz_m"]).max() + np.abs(own["dx_m"] - bare["dx_m"]).max()
        assert (moved > 1e-9) == bool(hidden)


def test_passes_that_fail_are_counted() -> None:
    good = Laboratory(0, "", "consistent", "pass", 0.5, "pass", 0.6, "pass")
    bad = replace(good, seed=1, hidden="play", identified="not decided", diagnosed_error=1.2, verified="fail")
    text = page([good, bad, replace(good, seed=2, refused="why")], "command", 1.0)
    assert "refused by a command: 1." in text
    assert f"| one hidden | `diagnose` | 1 | 0 | 0 | {share(1, 1)} | {share(1, 1)} |" in text
    assert f"| none hidden | `diagnose` | 1 | 0 | 0 | {share(0, 1)} | {share(0, 1)} |" in text
    assert "- 1: play" in text
    assert "- 0:" not in text
    assert share(4, 64).startswith("6.2 ± 3.0 %")


@pytest.mark.slow
@pytest.mark.parametrize("loads", [False, True])
def test_a_laboratory_goes_from_a_plan_to_a_certificate(loads: bool) -> None:
    plan = xd.run(laboratories.configuration(loads=loads)).plan
    for seed in (0, 1):
        found = laboratories.laboratory(seed, plan, loads=loads)
        assert not found.refused
        assert found.verified in ("pass", "fail", "not proven")
        assert found.diagnosed_error < 5.0


def test_series_are_numbered_anew_and_outcomes_kept(tmp_path: Path) -> None:
    frame = pd.DataFrame({"sequence": [1, 2, 3], "series": [1, 1, 2]})
    assert [in_series(frame, each)["series"].tolist() for each in SERIES] == [[1, 1, 2], [1, 2, 3], [1, 1, 1]]
    kept = [Outcome("one", SERIES[0], 9, 3, 1.5, "", "modelled", 1.0, 0.95, 0.0, 1.2, "identify", 1.001)]
    write_outcomes(tmp_path / "kept.csv", kept)
    assert read_outcomes(tmp_path / "kept.csv") == kept
    text = real_sets.page([*kept, replace(kept[0], inside=0.5), replace(kept[0], written=1.03)])
    assert "Gone to the end: 3 of 3; 90 to 98 % of held-out readings inside: 2 of 3; " in text
    assert "as the report says, to 2%: 2 of 3." in text
    assert real_sets.main([str(tmp_path / "nowhere"), "--out", str(tmp_path / "x")]) == 2


def test_rows_that_share_half_of_their_variance_are_made_independent() -> None:
    generator = np.random.default_rng(1)
    groups = pd.Series(np.repeat(np.arange(20_000), 4))
    own, common = generator.standard_normal(80_000), np.repeat(generator.standard_normal(20_000), 4)
    found = real_sets.decorrelated(pd.DataFrame({"dx_m": (own + common) / np.sqrt(2.0)}), groups)["dx_m"]
    rows = found.to_numpy().reshape(-1, 4)
    np.testing.assert_allclose(rows.T @ rows / len(rows), np.eye(4), atol=0.03)


def test_orientations_are_compared_as_rotations() -> None:
    """At a turn of nearly 90° about y the angles about x and z may be off by 0.5 rad, and the rotation hardly is."""
    turns = ["measured_rx_rad", "measured_ry_rad", "measured_rz_rad"]
    there, here = (pd.DataFrame([row], columns=turns) for row in ([0.5, 1.57, 0.5], [0.0, 1.57, 0.0]))
    assert np.abs(real_sets.differences(there, here).to_numpy()).max() < 1e-3
