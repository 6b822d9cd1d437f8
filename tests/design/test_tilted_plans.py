"""Plans under a tilted base: tilts are read as gravity, and a shared reference is of one pose under one tilt."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.app.api.inputs import table_of
from expdesign.errors import InputError
from expdesign.mechanics.loads.load import tilted_gravity, tilts_of
from expdesign.planning.plan import as_set, read_plan
from expdesign.planning.result import planned
from expdesign.planning.sampling import starting_designs
from tests.design.problems import HEXAPOD, problem

SHARED = {"experiment.deflection_noise.shared_reference": True, "experiment.measurements": 5}
HEAD = "sequence,x_m,y_m,z_m,rx_rad,ry_rad,rz_rad,mass_kg,com_x_m,com_y_m,com_z_m"
ROW = "0.01,0,0,0.05,0,0,10,0.05,0,0.12"


def written(folder: Path, columns: str, *rows: str) -> Path:
    file = folder / "plan.csv"
    lines = [f"{number},{ROW},{row}" for number, row in enumerate(rows, start=1)]
    file.write_text("\n".join([f"{HEAD},{columns}", *lines]) + "\n", encoding="utf-8")
    return file


@pytest.mark.parametrize("gravity", [[0.0, 0.0, -9.80665], [0.0, 0.0, 9.7], [0.0, -9.80665]])
def test_tilts_are_found_from_the_gravity_that_they_give(gravity: list[float]) -> None:
    tilts = np.random.default_rng(1).uniform(-1.4, 1.4, (20, len(gravity) - 1))
    (turned,) = tilted_gravity(np.array(gravity))(tilts)
    found = tilts_of(turned, np.array(gravity))
    assert found is not None
    np.testing.assert_allclose(found, tilts, rtol=0.0, atol=1e-12)
    assert tilts_of(1.01 * turned, np.array(gravity)) is None


def test_a_plan_with_tilts_is_that_with_their_gravity(tmp_path: Path) -> None:
    case = problem(HEXAPOD)
    (gravity,) = tilted_gravity(case.loaded.robot.gravity)(np.array([[0.3, -0.2]]))
    by_tilt = read_plan(
        table_of(written(tmp_path, "tilt_x_rad,tilt_y_rad", "0.3,-0.2"), "plan"), case.loaded, case.noise
    )
    text = ",".join(repr(float(value)) for value in gravity[0])
    by_gravity = read_plan(
        table_of(written(tmp_path, "gx_m_s2,gy_m_s2,gz_m_s2", text), "plan"), case.loaded, case.noise
    )
    np.testing.assert_array_equal(by_tilt.loads, by_gravity.loads)
    assert abs(by_tilt.loads[0, -1]) < 9.8
    with pytest.raises(InputError, match="gravity is stated as well, by gx_m_s2"):
        read_plan(table_of(written(tmp_path, "tilt_x_rad,gx_m_s2", "0.3,1"), "plan"), case.loaded, case.noise)


def test_what_shares_a_reference_has_one_pose_and_one_tilt(tmp_path: Path) -> None:
    """The unloaded robot hangs otherwise under another tilt, by its own weight, which no difference takes away."""
    case = problem(HEXAPOD, SHARED)
    designs = starting_designs(case, 40, np.random.default_rng(2))
    shared = 0
    for design in designs:
        plan = as_set(planned(case, design), case.loaded)
        for number in np.unique(plan.series):
            rows = plan.configurations[plan.series == number]
            assert (rows == rows[0]).all()
            shared += len(rows) > 1
    assert shared > 20
    mixed = written(tmp_path, "series,tilt_x_rad", "1,0.1", "1,0.2")
    with pytest.raises(InputError, match="different poses or tilts"):
        read_plan(table_of(mixed, "plan"), case.loaded, case.noise)
    other = read_plan(table_of(written(tmp_path, "tilt_x_rad", "0.1", "0.2"), "plan"), case.loaded, case.noise)
    assert other.series.tolist() == [1, 2]
