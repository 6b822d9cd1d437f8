"""What ports see: memories follow the rows of their series, and time is that of the recordings."""

from dataclasses import replace

import casadi as ca
import numpy as np

from expdesign.chain.ports.families import since_start
from expdesign.chain.ports.port import Channel
from expdesign.chain.ports.quantities import Quantity, evaluate
from expdesign.chain.ports.sight import Sight
from expdesign.chain.row import row_data, row_symbols
from tests.cases import robot
from tests.ports.machines import BIPOD, recordings_of


def test_stop_operators_of_several_efforts_follow_the_rows_of_their_series() -> None:
    """s ← clip(s + Δτ, ±r) from rest at every series' start, row by row in plain Python."""
    here, recordings = robot(BIPOD), recordings_of(None)
    rows, symbols = row_data(recordings, here), row_symbols(here)
    forces = evaluate([Quantity("effort", 0), Quantity("effort", 1)], rows, symbols, here)
    limits = 0.3 * np.abs(forces).max(axis=0)
    stops = [Quantity("stop", index, (float(limits[index]),)) for index in (0, 1)]
    found = evaluate([*stops, Quantity("effort", 0)], rows, symbols, here)
    for index in (0, 1):
        for series in np.unique(rows.series):
            state = before = 0.0
            for row in np.flatnonzero(rows.series == series)[np.argsort(rows.position[rows.series == series])]:
                state = float(np.clip(state + forces[row, index] - before, -limits[index], limits[index]))
                before = forces[row, index]
                assert np.isclose(found[row, index], state, rtol=0.0, atol=1e-9 * limits[index])
    np.testing.assert_array_equal(found[:, 2], forces[:, 0])


def test_points_are_at_the_times_that_they_state() -> None:
    """A point an hour after the recordings' first row is not one at their start."""
    here, recordings = robot(BIPOD), recordings_of(None)
    later = replace(recordings, time=3600.0 + 60.0 * np.arange(len(recordings), dtype=float))
    clock = evaluate([Quantity("clock")], row_data(later, here), row_symbols(here), here)[:, 0]
    np.testing.assert_array_equal(clock, later.time)


def test_a_displacement_that_follows_the_clock_is_nothing_at_the_first_row_of_a_series() -> None:
    """Deflections are changes since then: both channels of the law see the same time there, with opposite signs."""
    here = robot(BIPOD)
    recordings = replace(recordings_of(None), time=60.0 * np.arange(len(recordings_of(None)), dtype=float))
    rows, symbols = row_data(recordings, here), row_symbols(here)
    sight = Sight(here, symbols, rows, np.ones(len(rows), dtype=bool), [0, 1], timed=True)
    one, other = since_start(sight, [Channel(0, 0, (Quantity("clock"),), gain=0.5)])
    assert (one.gain, other.gain, one.block) == (0.5, -0.5, other.block)
    now, then = (sight.values(channel.inputs[0]) for channel in (one, other))
    first = rows.position == 0
    np.testing.assert_allclose(now[first], then[first], rtol=0.0, atol=1e-9)
    assert (now[~first] > then[~first]).all()
    since = since_start(sight, [Channel(0, 0, (Quantity("elapsed"),))])
    assert len(since) == 1


def test_what_follows_the_temperature_counts_from_the_first_row_of_its_series() -> None:
    """Temperatures as recorded are what a stiffness depends on; a displacement shows from where its series began."""
    here = robot("bipod")
    points = recordings_of(None)
    celsius = 20.0 + np.random.default_rng(0).standard_normal(len(points))
    data = row_data(replace(points, temperature=celsius, leg_temperature=None), here)
    names = [Quantity("temperature", 1), Quantity("warmth", 1), Quantity("warming", 1)]
    seen = evaluate(names, data, row_symbols(here), here)
    np.testing.assert_allclose(seen[:, 0], celsius)
    np.testing.assert_allclose(seen[:, 1] + seen[:, 2], celsius)
    first = data.position == 0
    np.testing.assert_allclose(seen[first, 1], celsius[first])
    assert all(len(np.unique(seen[data.series == number, 1])) == 1 for number in np.unique(data.series))


def test_columns_of_rows_are_found_by_their_names() -> None:
    """Also beside fixed points, gauges and orientations, which come after what every row has."""
    row = row_symbols(robot("H1"), 2, 3, oriented=True)
    flat = row.flat()
    for name in ("pose", "forward", "number", "reference", "point", "aim"):
        assert str(flat[row.columns(name)]) == str(ca.vec(getattr(row, name)))
