"""What is read off a front, with values that can be checked by hand or by comparing all pairs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from expdesign.planning.front import hypervolume, knee, non_dominated, reference_point

VALUES = np.array([[1.0, 5.0], [2.0, 2.0], [5.0, 1.0], [3.0, 3.0], [2.0, 2.0], [1.0, 6.0]])


@given(hnp.arrays(np.float64, st.tuples(st.integers(1, 12), st.integers(2, 4)), elements=st.integers(0, 4)))
def test_non_dominated_rows_by_all_pairs(values: np.ndarray) -> None:
    expected = []
    for i, row in enumerate(values):
        beaten = any((other <= row).all() and (other < row).any() for other in values)
        repeated = any((values[j] == row).all() for j in range(i))
        if not beaten and not repeated:
            expected.append(i)
    np.testing.assert_array_equal(non_dominated(values), expected)


def test_hypervolume_by_hand() -> None:
    point = np.array([6.0, 6.0])
    assert hypervolume(VALUES[:3], point) == pytest.approx(1.0 * 1.0 + 3.0 * 4.0 + 1.0 * 5.0)
    assert hypervolume(np.array([[7.0, 0.0]]), point) == 0.0


def test_knee_is_nearest_to_the_ideal_of_the_scaled_front() -> None:
    assert knee(VALUES[:3]) == 1
    assert knee(VALUES[:3] * [1e6, 1e-6]) == 1
    assert knee(VALUES[:1]) == 0


def test_reference_point_is_worse_than_every_design() -> None:
    np.testing.assert_allclose(reference_point(VALUES), [5.4, 6.5])
    assert np.all(reference_point(VALUES[:1]) > VALUES[0])
    assert np.all(reference_point(np.array([[0.0, -2.0]])) > [0.0, -2.0])
