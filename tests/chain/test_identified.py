"""The chain beside an identified geometry: linear about it, and the exact chain there."""

import numpy as np
import pytest

from expdesign.chain.chain import Chain
from expdesign.chain.component import ALL_JOINTS, GEOMETRY
from expdesign.chain.effects.joints.bearings import JointCompliance
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.effects.joints.readings import JointHarmonics
from expdesign.chain.identified import ChainBeside, Identified
from expdesign.chain.row import RowData, row_data
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arms import READING, configurations, recordings_of


@pytest.fixture(scope="module")
def rows(arm: SerialRobot) -> RowData:
    return row_data(recordings_of(arm, configurations(12, 3), np.zeros((12, 3))), arm)


@pytest.fixture(scope="module")
def beside(arm: SerialRobot) -> ChainBeside:
    chain = Chain(arm, (CalibratedGeometryError(arm, GEOMETRY),), reading=READING)
    errors = 2e-3 * np.random.default_rng(1).standard_normal(len(chain.parameters) - chain.base)
    values = chain.start() + np.concatenate([np.zeros(chain.base), errors])
    sizes = np.concatenate([[p.spread for p in chain.parameters[: chain.base]], np.full(len(errors), 1e-3)])
    known = Identified(chain, values, sizes)
    return known.beside(
        [JointCompliance.candidates(arm, recordings_of(arm, configurations(2, 1), np.zeros((2, 3))))[0]]
    )


def test_it_is_the_exact_chain_where_it_was_identified(beside: ChainBeside, rows: RowData) -> None:
    values = beside.start() + np.concatenate(
        [np.zeros(beside.base), 1e-6 * np.ones(len(beside.parameters) - beside.base)]
    )
    found, slopes = beside.predict_with_sensitivities(rows, values)
    expected, exact = beside.exact.predict_with_sensitivities(rows, values)
    np.testing.assert_allclose(found, expected, atol=1e-12)
    # Geometry and frames are followed as they are without further physics.
    others = np.r_[0 : beside.compliances, beside.base : len(beside.parameters)]
    np.testing.assert_allclose(slopes[..., others], exact[..., others], atol=1e-9)
    assert [p.name for p in beside.parameters] == [p.name for p in beside.exact.parameters]


def test_its_error_falls_with_the_square_of_the_step(beside: ChainBeside, rows: RowData) -> None:
    step = np.zeros(len(beside.parameters))
    step[beside.base - len(beside.identified.parameters) : beside.base] = 1.0
    worst = []
    for size in (2e-4, 1e-4):
        values = beside.start() + size * step
        worst.append(np.abs(beside.predict(rows, values) - beside.exact.predict(rows, values)).max())
    assert 3.5 < worst[0] / worst[1] < 4.5


def test_what_is_held_has_no_parameters(beside: ChainBeside, rows: RowData) -> None:
    values = beside.start()
    assert len(beside.held.parameters) == len(beside.parameters) - len(beside.identified.parameters[beside.held.base :])
    np.testing.assert_allclose(
        beside.held.predict(rows, beside.without_identified(values)), beside.predict(rows, values), atol=1e-15
    )


def test_whatever_was_identified_is_held(arm: SerialRobot, rows: RowData) -> None:
    """Errors of the joints' encoders act on joints and not on the geometry, and are held as it is."""
    chain = Chain(arm, (CalibratedGeometryError(arm, GEOMETRY), JointHarmonics(arm, ALL_JOINTS)), reading=READING)
    values = chain.start() + 1e-3 * np.random.default_rng(1).standard_normal(len(chain.parameters))
    known = Identified(chain, values, np.ones(len(values)))
    np.testing.assert_allclose(known.beside().predict(rows, values), chain.predict(rows, values), atol=1e-12)
