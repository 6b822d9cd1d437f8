"""Every remark has words."""

from expdesign.chain.recordings.recordings import Remark
from expdesign.report.remark_texts import sentence


def test_every_remark_has_a_sentence_of_its_own() -> None:
    silent = [kind.__name__ for kind in Remark.__subclasses__() if sentence.dispatch(kind) is sentence.dispatch(Remark)]
    assert len(Remark.__subclasses__()) > 10
    assert silent == []
