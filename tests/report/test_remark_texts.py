"""Every remark has words."""

from expdesign.chain.recordings.recordings import Remark
from expdesign.diagnosis.remarks import Averaged
from expdesign.report.remark_texts import TEXTS, sentence


def test_every_remark_has_a_sentence_of_its_own() -> None:
    assert set(TEXTS) == set(Remark.__subclasses__())


def test_an_average_over_what_may_be_there_says_nothing_of_missing_physics() -> None:
    """The verdict beside it may be `consistent`."""
    text = sentence(Averaged(6, ("creep / leg 1",)))
    assert "too few to rule out small effects" in text
    assert "missing" not in text
