"""Plans as tables: what is written is read again to the last bit."""

import numpy as np
import pytest

from expdesign.io.output import csv_text
from expdesign.io.table import parse_table
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.plan import Plan, plan_frame, read_plan
from tests.cases import ROBOTS, loads, setup


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
