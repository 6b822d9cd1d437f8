"""Which rows share an unloaded reading is read off the recordings, and said by an option or a configuration else."""

import numpy as np
import pandas as pd
import pytest

from expdesign.chain.recordings.reader import recordings_from_tables
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.recordings.references import Sharing, groups, sharing_rows, with_references
from expdesign.errors import InputError
from expdesign.estimation.identify import identify
from tests.identification.experiments import Experiment, by_series, experiment, read, table_of

BY_CONFIGURATION = Sharing(configured=True, configuration="run.yaml")


def made() -> Experiment:
    return experiment("bipod", 6, seed=3, loads_per_pose=2)


def recordings(names: list[str] | None = None) -> Recordings:
    """Three series of two rows, with a column `reference` where names are given."""
    frame = made().frame(made().exact)
    return read(frame if names is None else frame.assign(reference=names), made().robot)


def numbers(found: Recordings) -> list[int]:
    assert found.references is not None
    return groups(found.references).tolist()


def test_nothing_said_means_independent_rows() -> None:
    found, contradictions = with_references(recordings(), Sharing())
    assert found.references is None
    assert not contradictions
    assert not sharing_rows(found).any()


def test_the_column_says_it_and_an_empty_cell_leaves_it_to_the_configuration() -> None:
    one = recordings(["a", "a", "b", "c", "", ""])
    assert "reference" not in one.extra
    assert sharing_rows(one).tolist() == [True, True, False, False, False, False]
    found, contradictions = with_references(one, BY_CONFIGURATION)
    assert sharing_rows(found).tolist() == [True, True, False, False, True, True]
    assert [each.what for each in contradictions] == [
        "rows 4 and 5 are counted from an unloaded reading each, and by `shared_reference: true` of run.yaml from one"
    ]


def test_the_configuration_says_it_for_recordings_that_do_not() -> None:
    found, contradictions = with_references(recordings(), BY_CONFIGURATION)
    assert numbers(found) == [0, 0, 1, 1, 2, 2]
    assert not contradictions
    same, contradictions = with_references(found, BY_CONFIGURATION)
    assert numbers(same) == numbers(found)
    assert not contradictions


@pytest.mark.parametrize(
    ("said", "what"),
    [
        (Sharing(configured=False, configuration="run.yaml"), "by `shared_reference: false` of run.yaml from one each"),
        (Sharing(option=False), "by argument `shared_reference=False` from one each"),
    ],
)
def test_a_contradiction_is_named_and_only_the_option_overrides(said: Sharing, what: str) -> None:
    found, contradictions = with_references(recordings(["a", "a", "b", "b", "c", "c"]), said)
    assert sharing_rows(found).any() == (said.option is None)
    assert len(contradictions) == 1
    assert contradictions[0].what == f"rows 2 and 3 are counted from one unloaded reading, and {what}"


def test_one_unloaded_reading_belongs_to_one_command() -> None:
    with pytest.raises(InputError, match=r"row 4, column reference: the command differs from that of row 2") as raised:
        recordings(["a", "a", "a", "b", "c", "c"])
    assert "at its own command" in raised.value.remedy


def test_the_column_gives_the_estimate_of_shared_references() -> None:
    deflections = made().noisy(np.random.default_rng(5), shared_reference=True)
    frame = made().frame(deflections)
    named = frame.assign(reference=[f"zero {number}" for number in frame["series"]])
    expected = identify(made().robot, by_series(read(frame, made().robot), True))
    found = identify(made().robot, read(named, made().robot))
    np.testing.assert_allclose(found.covariance, expected.covariance, rtol=1e-12)
    assert found.goodness == expected.goodness
    assert found.goodness.chi2 != identify(made().robot, read(frame, made().robot)).goodness.chi2


def joined(*files: tuple[pd.DataFrame, str]) -> Recordings:
    return recordings_from_tables([table_of(*file) for file in files], made().robot)


def test_names_of_separate_sessions_are_of_separate_readings_and_of_one_session_the_same() -> None:
    frame = made().frame(made().exact).assign(reference=["a", "a", "b", "b", "c", "c"])
    again = joined((frame, "monday.csv"), (frame, "tuesday.csv"))
    assert len(set(numbers(again))) == 6
    parts = joined((frame.iloc[:3], "a.csv"), (frame.iloc[3:], "b.csv"))
    assert numbers(parts) == [0, 0, 1, 1, 2, 2]
    mixed = joined((frame, "a.csv"), (frame.drop(columns="reference"), "b.csv"))
    assert sharing_rows(mixed).tolist() == [True] * 6 + [False] * 6
    assert sharing_rows(with_references(mixed, BY_CONFIGURATION)[0]).all()


def test_replicates_of_mixed_references_are_those_of_one_kind() -> None:
    """Pure error of rows with one reference counts twice, of rows with their own once (the loaded half scatters)."""
    from expdesign.estimation.noise_level import pure_error, replicate_groups  # noqa: PLC0415

    one = made()
    frame = one.frame(one.exact)
    same = ["x_m", "y_m", "fx_N", "fy_N"]
    frame[same] = frame[same].iloc[0].to_numpy()
    frame["series"] = 1
    frame["dx_m"] = [1e-6, 3e-6, 1e-6, 3e-6, 5e-6, 1e-6]
    found = read(frame.assign(reference=["a", "a", "b", "c", "d", "e"]), one.robot)
    alike = replicate_groups(found)
    assert alike.tolist() == [0, 0, 1, 1, 1, 1]
    error = pure_error(found, np.full((6, 2), 1e-6), alike)
    assert error.squares[0] == pytest.approx(2.0 * 2.0 + 11.0)
    assert error.dof == 4
