"""No correction at all: the base model fitted by least squares, its chi-squared test as the alarm.

What every other tool has to beat; its held-out error is the reference of "worse than base".
"""

from __future__ import annotations

from .question import Question, Reply, main


def solve(question: Question) -> Reply:
    """The base model's prediction."""
    return Reply(question.base_prediction(), question.mismatch())


if __name__ == "__main__":
    main(solve, __doc__)
