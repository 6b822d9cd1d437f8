"""Where the mismatch is: the level of the table where there is none, and the right place where there is one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pandas as pd
import pytest

from expdesign.diagnosis.library import Candidate, candidates, library
from expdesign.diagnosis.locate import drivers, locate
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import linear_fit
from tests.cases import robot
from tests.diagnosis.samples import base_fit, effect, sample_of, simulated

COUNT = 200


@cache
def library_of(name: str) -> list[Candidate]:
    """All samples of a robot have the same rows, and only these matter here."""
    here, sample = robot(name), sample_of(name, simulated(name))
    return candidates(library(here, sample.recordings), sample, here, np.ones(len(here.stiffness)))


@pytest.mark.parametrize("name", ["bipod-unequal", "irregular"])
def test_where_nothing_is_wrong_the_tables_hold_their_level(name: str) -> None:
    """Each table names a place in no more than 1 % of experiments, within 4 standard errors of √(0.01·0.99/N)."""
    entries = library_of(name)
    wrong = np.zeros(2)
    first = sample_of(name, simulated(name))
    base = base_fit(name, first)
    for seed in range(COUNT):
        sample = replace(first, recordings=simulated(name, seed=seed))
        start = sample.residuals(base.chain, base.values)
        found = locate(
            linear_fit(base.chain, base.values, start, base.sensitivities), sample, robot(name), entries, 1.0
        )
        wrong += [any(p.p_value < OPTIONS.level for p in table) for table in (found.components, found.patterns)]
    assert (wrong <= COUNT * OPTIONS.level + 4.0 * np.sqrt(COUNT * OPTIONS.level * (1.0 - OPTIONS.level))).all()


@pytest.mark.parametrize(
    ("physics", "component", "variant", "parameters"),
    [
        ("leg_backlash", "leg 3", "middle", [8e-6]),
        ("leg_nonlinear_stiffness", "leg 5", "quadratic", [8e-6]),
        ("platform_compliance", "platform", "diagonal", [0, 0, 0, 2e-6, 0, 0]),
        ("instrument_scale", "instrument", "", [0.3, 0.0, 0.0]),
    ],
)
def test_the_part_that_is_wrong_comes_first(
    physics: str, component: str, variant: str, parameters: list[float]
) -> None:
    one = effect("irregular", physics, component, variant)
    sample = sample_of("irregular", simulated("irregular", one, parameters=parameters))
    found = locate(base_fit("irregular", sample), sample, robot("irregular"), library_of("irregular"), 1.0)
    assert found.components[0].name == component
    assert found.components[0].p_value < OPTIONS.level


def test_axes_are_those_whose_residuals_exceed_the_noise() -> None:
    """A drift of the instrument along y alone."""
    drift = effect("irregular", "thermal_drift", "environment")
    sample = sample_of("irregular", simulated("irregular", drift, parameters=[0, 3e-6, 0, 0, 0, 0]))
    found = locate(base_fit("irregular", sample), sample, robot("irregular"), library_of("irregular"), 1.0)
    assert "dy_m" in found.axes
    assert not {"drx_rad", "dry_rad", "drz_rad"} & set(found.axes)


def test_what_is_explained_scales_with_the_variance_of_the_noise() -> None:
    sample = sample_of("irregular", simulated("irregular"))
    base, entries = base_fit("irregular", sample), library_of("irregular")
    once, twice = (locate(base, sample, robot("irregular"), entries, v) for v in (1.0, 2.0))
    explained = {probe.name: probe.explained for probe in twice.components}
    for probe in once.components:
        assert probe.explained == pytest.approx(2.0 * explained[probe.name], rel=1e-9)


def test_columns_of_numbers_without_a_meaning_are_tried_as_causes() -> None:
    sample = sample_of("bipod-unequal", simulated("bipod-unequal"))
    rows = len(sample.recordings)
    extra = pd.DataFrame({"humidity": np.linspace(0.3, 0.6, rows).astype(str), "operator": "Ada", "room": 21.0})
    sample = replace(sample, recordings=replace(sample.recordings, extra=extra))
    tried = drivers(sample, robot("bipod-unequal"))
    assert "humidity" in tried
    assert {"operator", "room"}.isdisjoint(tried)
