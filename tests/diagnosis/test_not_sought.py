"""Recordings that cannot show a law say so in one sentence."""

from dataclasses import replace

import numpy as np

from expdesign.chain.recordings.recordings import Recordings
from expdesign.diagnosis.caveats import not_sought
from expdesign.estimation.fit import Data
from expdesign.report.remark_texts import sentences
from tests.cases import robot
from tests.fitting import data_of
from tests.ports.machines import BIPOD, recordings_of, softened


def _sample(recordings: Recordings, rows: int | None = None) -> Data:
    data = data_of(recordings, robot(BIPOD))
    counts = np.ones(len(recordings), dtype=bool)
    if rows is not None:
        counts[rows:] = False
    return data.counting(counts)


def test_too_few_rows_are_the_only_thing_that_is_said() -> None:
    (sentence,) = sentences(not_sought(_sample(recordings_of(softened()), rows=7)))
    assert "there are 7" in sentence
    assert "12 fitted rows" in sentence


def test_missing_times_and_loads_that_never_change_are_said() -> None:
    recordings = recordings_of(softened())
    still = replace(recordings, time=None, wrenches=np.ones_like(recordings.wrenches))
    text = " ".join(sentences(not_sought(_sample(still))))
    assert "`time_s`" in text
    assert "same load" in text
    assert "one pose" not in text


def test_recordings_that_show_everything_say_nothing_of_place_and_force() -> None:
    text = " ".join(sentences(not_sought(_sample(recordings_of(softened())))))
    assert "place" not in text
    assert "force" not in text
