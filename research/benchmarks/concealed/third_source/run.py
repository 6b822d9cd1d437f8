"""The third source: `python -m research.benchmarks.concealed.third_source.run` generates, asks and scores.

40 cases and 8 healthy ones from a seed that is drawn afresh unless one is given; a seed makes the same cases again,
with the same versions of the engines (extra `third-source`). `--kept DIR` asks another state of the program about cases
that were kept, without the engines.
"""

from __future__ import annotations

from ..pipeline import conduct_kinds
from .cases import draw_case
from .kinds import KINDS

if __name__ == "__main__":
    conduct_kinds(__doc__, tuple(KINDS), draw_case, "The third source", "-third-source")
