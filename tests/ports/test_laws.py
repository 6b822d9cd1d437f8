"""Physics that no list holds: located, drawn, predicted with, and absent where there is none."""

from dataclasses import replace
from functools import cache

import casadi as ca
import numpy as np
import pytest
import yaml

from expdesign.chain.chain import Chain
from expdesign.chain.component import ALL_LEGS, BASE
from expdesign.chain.ports.features import basis_of
from expdesign.chain.ports.law import _WITHIN, Law, LawForm, _within, form_data, form_of
from expdesign.chain.ports.port import Channel
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.row import Row, row_data
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.evidence.dictionary import Dictionary
from expdesign.diagnosis.evidence.refinement import refined
from expdesign.diagnosis.evidence.state import linearised
from expdesign.diagnosis.law_findings import law_findings, sentence
from expdesign.diagnosis.library import library
from expdesign.diagnosis.result import Diagnosis
from expdesign.errors import InputError
from expdesign.report.diagnosis_texts import diagnosis_record
from tests.cases import robot
from tests.diagnosis.samples import base_fit, sample_of
from tests.ports.machines import BIPOD, LEG_1, lengths_of_leg_1, recordings_of, softened


@cache
def found(seed: int = 0) -> Diagnosis:
    return diagnose(robot(BIPOD), recordings_of(softened(), seed=seed))


def test_a_leg_that_is_softer_at_one_length_is_located_and_modelled() -> None:
    result = found()
    assert result.verdict == "modelled"
    (finding, *_) = result.findings
    assert (finding.physics, finding.component, finding.variant) == ("law", "leg 1", "compliance")
    assert finding.depends_on == ("length",)
    assert finding.columns == ("length_m",)
    assert finding.probability > 0.5
    assert "softer" in finding.sentence
    record = diagnosis_record(result, None)
    assert record["location"]["component"] == "leg 1"
    assert record["location"]["candidates"][0]["component"] == "leg 1"
    assert record["effects"][0]["curve"] == "law-1.csv"
    assert result.errors.test_after < 0.3 * result.errors.test_before


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_law_is_found_beside_noise_that_nobody_states(seed: int) -> None:
    """Named effects that imitate it halve nothing; the noise is estimated with the law, and errors are given in it."""
    recordings = replace(recordings_of(softened(), seed=seed), deviations=None)
    result = diagnose(robot(BIPOD), recordings)
    assert result.noise.origin == "residuals"
    assert result.verdict == "modelled"
    assert result.laws is not None
    assert result.findings[0].component in ("leg 1", "all legs")
    assert result.errors.test_after < 0.3 * result.errors.test_before
    assert 0.7 < result.errors.test_after < 1.6
    assert diagnose(robot(BIPOD), replace(recordings_of(None, seed=seed), deviations=None)).verdict == "consistent"


def test_what_takes_nothing_away_is_not_explained() -> None:
    """A share of 0 % is not said, nor what usually behaves like that; what fits as well is, and what compensates."""
    laws = found().laws
    assert laws is not None
    part = laws.parts[0]
    said, silent, against = (
        sentence(replace(part, share=share), robot(BIPOD), ("base",)) for share in (0.4, 0.002, -0.12)
    )
    assert "(40 % of what is explained)" in said
    assert "It compensates other effects, by 12 % of what is explained." in against
    assert said.count("do that") + said.count("does that") == 1
    assert "explained" not in silent
    assert "does that" not in silent
    assert said.endswith(" These recordings also fit base.")


def test_a_law_that_is_likelier_elsewhere_says_where_and_never_itself() -> None:
    laws = found().laws
    assert laws is not None
    (part, *_) = laws.parts
    here = part.places[0]
    base = replace(here, component=BASE, log_evidence=here.log_evidence + 90.0, alike=True)
    elsewhere = replace(laws, parts=(replace(part, places=(base, replace(here, probability=0.01))),))
    (finding,) = law_findings(elsewhere, robot(BIPOD), ())
    assert finding.probability == 0.01
    assert finding.sentence.endswith(" These recordings also fit base.")


def test_what_is_said_of_all_legs_is_said_of_every_leg() -> None:
    laws = found().laws
    assert laws is not None
    law = laws.parts[0].effect
    assert isinstance(law, Law)
    assert law.subject == "Leg 1"
    assert Law(robot(BIPOD), replace(law.form, component=ALL_LEGS)).subject == "Every leg"


def test_the_band_covers_the_true_compliance() -> None:
    """Of five experiments together, at least 85 % of the points of the curve have the truth within the 95 % band."""
    middle, spread = lengths_of_leg_1()
    inside = []
    for seed in range(5):
        finding = found(seed).findings[0]
        curve = finding.curve
        assert curve is not None
        truth = 1.0 + 0.4 * np.exp(-0.5 * ((curve.inputs[:, 0] - middle) / (0.7 * spread)) ** 2)
        truth *= robot(BIPOD).compliance[0]
        chosen = np.array(curve.output) == "leg 1"
        inside.append(((curve.low < truth) & (truth < curve.high))[chosen])
    assert np.concatenate(inside).mean() > 0.85


def test_beyond_the_range_of_its_inputs_a_law_fades_and_says_so() -> None:
    result = found()
    chain, values = result.predictive.fit.chain, result.predictive.fit.values
    (law,) = (effect for effect in chain.effects if isinstance(effect, Law))
    rows = row_data(result.recordings, result.robot)
    base = Chain(result.robot)
    far = rows.values.copy()
    where = [i for i, name in enumerate(_names(chain)) if name == "lengths"]
    far[:, where] += 10.0 * (law.form.high[0, 0] - law.form.low[0, 0])
    moved = type(rows)(far, rows.series, rows.position)
    np.testing.assert_allclose(
        chain.predict(moved, values), base.predict(moved, values[: base.base]), rtol=0.0, atol=1e-12
    )
    inside = chain.predict_with_sensitivities(rows, values)[1]
    outside = chain.predict_with_sensitivities(moved, values)[1]
    covariance = result.predictive.fit.covariance
    spread = [np.sqrt(np.einsum("nkp,pq,nkq->nk", s, covariance, s)).mean() for s in (inside, outside)]
    assert spread[1] > 3.0 * spread[0]


def test_a_drift_stays_at_its_last_value_and_grows_less_certain() -> None:
    """Soon after the last row it is what it was there; after as long again its prediction is unsure by its own size."""
    here, end, size = robot(BIPOD), 100.0, 2e-6
    basis = basis_of("wiener", np.array([end]), np.linspace(0.0, end, 21)[:, None], 12)
    assert basis is not None
    channel = Channel(0, 0, (Quantity("clock"),))
    ends = np.array([[0.0]]), np.array([[end]])
    law = Law(here, LawForm("actuators", LEG_1, "offset", (channel,), basis, *ends, size))
    chain, rows = Chain(here, (law,)), row_data(recordings_of(None), here)
    (clock,) = (i for i, name in enumerate(_names(chain)) if name == "clock")
    values = np.concatenate([np.ones(2), np.random.default_rng(0).standard_normal(basis.rank) * size, [0.0]])
    seen, slopes = [], []
    for time in (0.5 * end, 1.1 * end, 2.0 * end, 5.0 * end):
        numbers = rows.values.copy()
        numbers[:, clock] = time
        moved = type(rows)(numbers, rows.series, rows.position)
        reading, slope = chain.predict_with_sensitivities(moved, values)
        seen.append(reading)
        slopes.append(np.abs(slope[..., -1]).max())
    assert np.abs(seen[1] - seen[0]).max() > 1e-7
    for later in seen[2:]:
        np.testing.assert_allclose(later, seen[1], rtol=0.0, atol=1e-15)
    assert slopes[0] < 1e-6
    assert slopes[3] / slopes[2] == pytest.approx(2.0, rel=1e-6)


def test_a_reading_that_refers_to_a_late_time_is_unsure_by_what_a_random_walk_does_between_both() -> None:
    """Oracle: Var[W(b) − W(b₀)] = |b − b₀|, b being how many ranges after the end; alike times have no difference."""
    here, end = robot(BIPOD), 100.0
    basis = basis_of("wiener", np.array([end]), np.linspace(0.0, end, 21)[:, None], 12)
    assert basis is not None
    channels = tuple(Channel(0, 0, (Quantity(kind),), gain=gain) for kind, gain in (("clock", 1.0), ("started", -1.0)))
    ends = np.zeros((2, 1)), np.full((2, 1), end)
    chain = Chain(here, (Law(here, LawForm("actuators", LEG_1, "offset", channels, basis, *ends, 2e-6)),))
    rows = row_data(recordings_of(None), here)
    columns = {name: index for index, name in enumerate(_names(chain))}

    def unsure(time: float, reference: float) -> float:
        numbers = rows.values.copy()
        numbers[:, columns["clock"]], numbers[:, columns["elapsed"]] = time, time - reference
        moved = type(rows)(numbers, rows.series, rows.position)
        slopes = chain.predict_with_sensitivities(moved, np.zeros(len(chain.parameters)))[1]
        return float(np.abs(slopes[..., -1]).max())

    once = unsure(2.0 * end, end)
    for time, reference in ((5.0 * end, 4.0 * end), (9.0 * end, 8.0 * end)):
        assert unsure(time, reference) == pytest.approx(once, rel=1e-6)
    assert unsure(6.0 * end, 2.0 * end) == pytest.approx(2.0 * once, rel=1e-6)
    assert unsure(5.0 * end, 5.0 * end) < 1e-6 * once


def _names(chain: Chain) -> list[str]:
    """Name of every number of a row, in the order of `Row.flat`."""
    row = chain.row_symbols()
    return [name for name, value in vars(row).items() for _ in range(value.numel())]


def test_a_law_written_as_data_predicts_the_same_number_for_number() -> None:
    result = found()
    fitted = result.predictive.fit
    effects = []
    for effect in fitted.chain.effects:
        assert isinstance(effect, Law)
        data = yaml.safe_load(yaml.safe_dump(form_data(effect.form)))
        effects.append(Law(result.robot, form_of(data, effect.component), effect.number))
    chain = Chain(result.robot, tuple(effects))
    assert [p.name for p in chain.parameters] == [p.name for p in fitted.chain.parameters]
    rows = row_data(result.recordings, result.robot)
    np.testing.assert_array_equal(chain.predict(rows, fitted.values), fitted.chain.predict(rows, fitted.values))


def test_physics_that_is_left_out_of_the_library_is_not_named() -> None:
    """A leg of another stiffness at another length, without the entry that says so, is a law at that leg."""
    robot_, recordings = robot(BIPOD), recordings_of(softened())
    known = {effect.physics for effect in library(robot_, recordings)}
    without = frozenset({"leg_backlash"})
    assert "leg_backlash" in known
    assert {effect.physics for effect in library(robot_, recordings, without=without)} == known - without
    result = diagnose(robot_, recordings, without=frozenset(known))
    assert result.verdict == "modelled"
    assert {finding.physics for finding in result.findings} == {"law"}


def test_physics_that_nobody_knows_cannot_be_left_out() -> None:
    with pytest.raises(InputError, match="no physics is called `leg_backlsh`"):
        diagnose(robot(BIPOD), recordings_of(None), without=frozenset({"leg_backlsh"}))


def test_what_is_unknown_beyond_the_range_has_a_derivative_within_it() -> None:
    """A root has none at exactly 0, where a law with memory is differentiated through its states."""
    value = ca.SX.sym("value")
    within = _within([value], np.array([0.0]), np.array([1.0]))
    beyond = ca.sqrt(ca.fmax(1.0 - within**2, _WITHIN))
    slope = ca.Function("slope", [value], [ca.jacobian(beyond, value)])
    for inside in (0.0, 0.3, 1.0):
        assert abs(float(slope(inside))) < 1e-6
    assert float(slope(1.2)) > 0.0


def test_every_effort_of_a_memory_has_a_name() -> None:
    """Actuator forces, the wrench at the platform, and the same about the origin of O."""
    here = robot("irregular")
    count = len(here.stiffness) + 2 * here.coordinates.n
    names = [Quantity("stop", index, (1.0,)).name(here) for index in range(count)]
    assert len(set(names)) == count


NAME = "bipod"


@pytest.mark.parametrize("share", [0.33, 0.62], ids=["early", "late"])
def test_a_leg_that_comes_loose_between_two_rows_is_one_weight_at_that_time(share: float) -> None:
    """Leg 1 yields by half more from there on; the time is found to 3 % of all of it."""
    here, plain = robot(NAME), recordings_of(None, NAME)
    assert plain.time is not None
    first, whole = float(plain.time[0]), float(np.ptp(plain.time))

    def loose(row: Row, force: ca.SX) -> ca.SX:
        return ca.if_else(row.clock > share * whole, 0.5, 0.0) * force

    sample = sample_of(NAME, recordings_of(loose, NAME))
    base = base_fit(NAME, sample)
    dictionary = Dictionary(here, sample, np.ones(Chain(here).compliances))
    present = linearised(base, sample)
    best = max((atom for atom in dictionary.atoms if atom.entry), key=lambda atom: present.gain(atom.directions)[0])
    found, _ = refined(best, dictionary.made, present) or (best, 0.0)
    assert found.entry is not None
    assert (found.entry.form, str(found.entry.component)) == ("compliance", "leg 1")
    (seen,) = found.entry.inputs
    assert seen.kind == "after"
    assert seen.setting[0] == pytest.approx(share * whole, abs=0.03 * whole)
    assert first == pytest.approx(0.0, abs=whole)
