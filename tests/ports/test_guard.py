"""When laws may be predicted with: left-out blocks decide, all of them and not a few."""

import numpy as np
import pytest

from expdesign.arrays import FloatArray, IntArray
from expdesign.diagnosis.cross_validation import LeftOut
from expdesign.diagnosis.options import OPTIONS

BLOCKS: IntArray = np.repeat(np.arange(20), 12)


def _noise(seed: int) -> FloatArray:
    return np.random.default_rng(seed).standard_normal(len(BLOCKS))


def test_a_law_that_brings_every_block_to_the_noise_predicts() -> None:
    left_out = LeftOut(_noise(0) + 3.0, _noise(0), BLOCKS)
    assert left_out.doubt == ""
    assert left_out.better == 1.0


def test_a_law_that_helps_few_blocks_much_and_harms_the_rest_a_little_does_not() -> None:
    few = BLOCKS < 3
    left_out = LeftOut(np.where(few, 12.0, 1.0), np.where(few, 1.0, 1.2), BLOCKS)
    assert left_out.rms_after < 0.3 * left_out.rms_before
    assert "of the blocks" in left_out.doubt


def test_a_law_that_leaves_most_of_the_misfit_does_not() -> None:
    assert "excess" in LeftOut(_noise(1) * 3.0, _noise(1) * 2.8, BLOCKS).doubt


def test_a_gain_in_noise_alone_passes_as_often_as_the_level_says() -> None:
    """Of 400 comparisons of independent noise, 5 % ± 3 standard errors have a p-value below the level."""
    p_values = [LeftOut(_noise(2 * seed), _noise(2 * seed + 1), BLOCKS).p_value for seed in range(400)]
    share = float(np.mean(np.array(p_values) < OPTIONS.gain_level))
    assert share == pytest.approx(
        OPTIONS.gain_level, abs=3.0 * np.sqrt(OPTIONS.gain_level * (1.0 - OPTIONS.gain_level) / 400)
    )


def test_squares_of_a_few_blocks_do_not_make_a_sure_gain_uncertain() -> None:
    """Every series is brought to the noise; that two were far worse than the others takes nothing away."""
    far = np.where(BLOCKS < 2, 300.0, 3.0)
    left_out = LeftOut(_noise(3) + far, _noise(4), BLOCKS)
    assert left_out.doubt == ""


def test_laws_that_leave_a_third_have_to_help_nearly_everywhere() -> None:
    """Of 20 blocks 14 are better: enough where little is left, not where laws imitate something else."""
    worse = BLOCKS >= 14
    before = np.where(worse, 1.0, 5.0) * np.sign(_noise(5))
    for remains, doubted in ((1.2, False), (3.0, True)):
        after = np.where(worse, 1.4, remains) * np.sign(_noise(6))
        assert ("of the blocks" in LeftOut(before, after, BLOCKS).doubt) is doubted
