"""Plans as tables: what is written is read again to the last bit, and tilts of the base as gravity."""

from pathlib import Path

import numpy as np
import pytest

from expdesign.app.api.inputs import table_of
from expdesign.errors import InputError
from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.mechanics.loads.load import tilted_gravity, tilts_of
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.plan import Plan, as_set, plan_frame, read_plan
from expdesign.planning.result import planned
from expdesign.planning.sampling import starting_designs
from tests.cases import ROBOTS, loads, setup
from tests.design.problems import HEXAPOD, problem


def noise(*, shared: bool) -> DeflectionNoise:
    return DeflectionNoise.from_deviations(np.arange(2), np.full(2, 1e-6), shared)


@pytest.mark.parametrize("kind", ["payload", "wrench"])
@pytest.mark.parametrize("name", ["bipod", "irregular"])
def test_a_plan_is_read_as_it_was_written(name: str, kind: str) -> None:
    loaded, generator = setup(name, kind).loaded, np.random.default_rng(0)
    plan = Plan(ROBOTS[name].poses(generator, 5), loads(name, kind, generator, 5), np.array([1, 1, 2, 3, 3]))
    plan.configurations[1] = plan.configurations[0]
    plan.configurations[4] = plan.configurations[3]
    own = len(loaded.load.own)
    plan.loads[[1, 4], own:] = plan.loads[[0, 3], own:]  # the gravity of a series is one
    text = csv_text(plan_frame(plan, loaded, with_gravity=True))
    found = read_plan(parse_table(text, "plan.csv"), loaded, noise(shared=True))
    for one, other in zip(
        (found.configurations, found.loads, found.series), (plan.configurations, plan.loads, plan.series), strict=True
    ):
        np.testing.assert_array_equal(one, other)
    columns = text.splitlines()[0].split(",")
    assert columns == ["sequence", "series", *loaded.robot.configuration, *loaded.load.columns]


def test_gravity_of_the_robot_holds_where_the_plan_names_none() -> None:
    loaded = setup("irregular", "payload").loaded
    generator = np.random.default_rng(1)
    parameters = loads("irregular", "payload", generator, 2)
    parameters[:, 4:] = loaded.robot.gravity
    plan = Plan(ROBOTS["irregular"].poses(generator, 2), parameters, np.array([1, 2]))
    text = csv_text(plan_frame(plan, loaded, with_gravity=False))
    assert "gx_m_s2" not in text
    found = read_plan(parse_table(text, "plan.csv"), loaded, noise(shared=False))
    np.testing.assert_array_equal(found.loads, parameters)


def test_columns_that_may_be_left_out() -> None:
    """Series follow from the poses, centres of mass are 0; measured columns are of no interest."""
    loaded = setup("bipod", "payload").loaded
    table = parse_table("x_m,y_m,mass_kg,dx_m\n0.1,0.5,10,\n0.1,0.5,20,\n0.2,0.5,5,\n", "plan.csv")
    found = read_plan(table, loaded, noise(shared=True))
    np.testing.assert_array_equal(found.series, [1, 1, 2])
    np.testing.assert_array_equal(found.loads[:, 0], [10.0, 20.0, 5.0])
    np.testing.assert_array_equal(found.loads[:, 1:], np.tile(loaded.robot.gravity, (3, 1)))
    wrench = read_plan(
        parse_table("x_m,y_m,fy_N\n0.1,0.5,-7\n", "plan.csv"), setup("bipod", "wrench").loaded, noise(shared=False)
    )
    np.testing.assert_array_equal(wrench.loads, [[0.0, -7.0]])


def test_numbers_in_tables_are_the_shortest_that_read_back() -> None:
    loaded = setup("bipod", "payload").loaded
    plan = Plan(np.array([[0.1, -0.0]]), np.array([[1e-7, 0.0, -9.80665]]), np.array([1]))
    assert csv_text(plan_frame(plan, loaded, with_gravity=False)).splitlines()[1] == "1,1,0.1,0.0,1e-07"


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
