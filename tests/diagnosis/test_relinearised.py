"""What a diagnosis writes predicts what it was judged by, also along what the recordings hardly determine."""

from dataclasses import replace

import numpy as np
import pytest

import expdesign as xd
from expdesign.chain.chain import Chain
from expdesign.chain.component import GEOMETRY, PLATFORM
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.effects.links.links import LinkCompliance
from expdesign.chain.effects.load.payload import UnknownTool
from expdesign.chain.identified import ChainBeside, Identified
from expdesign.chain.row import row_data
from expdesign.diagnosis.relinearised import AGREES, difference, proper, relinearised
from expdesign.estimation.fit import Data, fit
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arms import DEVIATION, READING, configurations, recordings_of
from tests.oracle import Array
from tests.plant import ROBOT, usual_faults
from tests.plant import recordings as of_arm


def chain_of(arm: SerialRobot) -> Chain:
    """With every geometric error free; the instrument and the marker stand anywhere."""
    return Chain(arm, (CalibratedGeometryError(arm, GEOMETRY),), reading=READING)


def beside(arm: SerialRobot, *, tool: bool = False) -> ChainBeside:
    """Linear about the drawing."""
    chain = chain_of(arm)
    spreads = np.array([0.05 if p.name.endswith("rad") else 1e-3 for p in chain.parameters[chain.base :]])
    sizes = np.concatenate([[p.spread for p in chain.parameters[: chain.base]], spreads])
    return Identified(chain, chain.start(), sizes).beside([UnknownTool(arm, PLATFORM)] if tool else [])


def sample_of(arm: SerialRobot, zeros: float, count: int = 60) -> Data:
    """Positions by an arm whose revolute joints have zeros off by `zeros` (rad), and noise."""
    q = configurations(count, 3)
    chain = chain_of(arm)
    values = chain.start()
    offsets = [i for i, p in enumerate(chain.parameters) if p.name.endswith("offset_rad")]
    values[offsets] = zeros * np.resize([1.0, -0.8, 0.6], len(offsets))
    blank = recordings_of(arm, q, np.zeros((count, 3)))
    positions = chain.predict(row_data(blank, arm), values)[:, :3]
    noise = DEVIATION * np.random.default_rng(5).standard_normal(positions.shape)
    recorded = recordings_of(arm, q, positions + noise)
    data = Data(recorded, row_data(recorded, arm), Whitening(np.full((count, 3), DEVIATION)), reading=chain.reading)
    return data.counting(np.ones(count, dtype=bool))


def test_frames_are_followed_to_first_order_as_joints_are(arm: SerialRobot) -> None:
    """A turn of the instrument against a joint's zero stretches nothing: both are linear, or neither is."""
    chain, rows = beside(arm), sample_of(arm, 0.0).rows
    step = np.zeros(len(chain.parameters))
    step[[i for i, p in enumerate(chain.parameters) if p.name.startswith("instrument r")]] = 0.04
    start = chain.predict(rows, chain.start())
    once, twice = (chain.predict(rows, chain.start() + size * step) - start for size in (1.0, 2.0))
    np.testing.assert_allclose(twice, 2.0 * once, atol=1e-12)


def test_a_long_step_is_repeated_about_its_end_until_file_and_fit_agree(arm: SerialRobot) -> None:
    """Zeros off by 40 mrad: the first fit is whole standard deviations from the exact chain, the last one nowhere."""
    sample = sample_of(arm, 0.04)
    chain = beside(arm)
    first = fit(chain, sample, None, chain.knowledge())
    assert difference(first, sample, chain.exact) > 1.0
    found = relinearised(first, sample)
    assert difference(found, sample, chain.exact) <= AGREES
    assert isinstance(found.chain, ChainBeside)
    exact = sample.residuals(found.chain.exact, found.values)
    assert np.sqrt((exact**2).mean()) == pytest.approx(1.0, abs=0.25)
    unseen = sample_of(arm, 0.04, 90)
    assert np.sqrt((unseen.residuals(found.chain.exact, found.values)[60:] ** 2).mean()) < 1.6


def test_what_nothing_determines_has_the_least_size(arm: SerialRobot) -> None:
    """Every parameter that is no shape has a proper prior, except where instrument and marker stand."""
    chain = beside(arm, tool=True)
    known = proper(fit(chain, sample_of(arm, 0.0), None, chain.knowledge()))
    assert known is not None
    free = [p.name for p, deviation in zip(chain.parameters, known[1], strict=True) if not np.isfinite(deviation)]
    assert all(name.startswith(("instrument", "marker")) for name in free)


@pytest.mark.slow
def test_steps_that_swing_about_end_no_worse_than_they_began(arm: SerialRobot) -> None:
    """Twelve rows, zeros off by 0.35 rad and an unknown tool: whole steps lead away without end."""
    sample, chain = sample_of(arm, 0.35, 12), beside(arm, tool=True)
    first = fit(chain, sample, None, chain.knowledge())

    def left(values: Array) -> float:
        return float((sample.residuals(chain.exact, values) ** 2).sum())

    assert left(relinearised(first, sample).values) < left(first.values)


def test_what_readings_determine_is_not_pulled_at(arm: SerialRobot) -> None:
    """A link thirty times as soft as its class: the fit about its estimate leaves what the first one left."""
    plain, soft = sample_of(arm, 0.04), LinkCompliance.from_text(arm, "link 3", "")
    chain = beside(arm).identified.beside([soft])
    zeros = fit(beside(arm), plain, None, beside(arm).knowledge()).values
    yields = [3e-4, 2e-4]
    values = np.append(zeros, yields)
    bent, stiff = (chain.exact.predict(plain.rows, v) for v in (values, np.append(zeros, [0.0, 0.0])))
    recordings = replace(plain.recordings, deflections=plain.recordings.deflections + (bent - stiff)[:, :3])
    sample = replace(plain, recordings=recordings)
    first = fit(chain, sample, None, chain.knowledge())
    assert difference(first, sample, chain.exact) > AGREES
    found = relinearised(first, sample)
    assert (found.residuals**2).mean() == pytest.approx(1.0, abs=0.3)
    part = found.chain.slices[0]
    assert (np.abs(found.values[part] - yields) < 4.0 * np.sqrt(np.diag(found.covariance)[part])).all()


@pytest.mark.slow
@pytest.mark.parametrize("seed", [2, 3])
def test_the_file_of_a_diagnosed_arm_predicts_the_fitted_rows_as_the_diagnosis_says(seed: int) -> None:
    """An arm with zeros, links, springs, a tool and a runout off: the RMS of file and diagnosis agree to 2 %."""
    frame = of_arm(usual_faults(seed), 150, seed)
    found = xd.diagnose(ROBOT, frame)
    assert found.result.written_difference <= AGREES
    predicted = xd.predict(found.model, frame).frame
    fitted = (frame["split"] == "train").to_numpy()
    names = ["px_m", "py_m", "pz_m"]
    left = (frame[names] - predicted[names]).to_numpy()[fitted] / 3e-5
    sample = found.result.names.sample
    said = found.result.predictive.fit.residuals[sample.counts]
    assert np.sqrt((left**2).mean()) == pytest.approx(np.sqrt((said**2).mean()), rel=0.02)
