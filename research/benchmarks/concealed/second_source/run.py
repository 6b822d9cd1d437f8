"""The second source: `python -m research.benchmarks.concealed.second_source.run` generates, asks and scores.

40 cases and 8 healthy ones from a seed that is drawn afresh unless one is given; a seed makes the same cases again,
with the same versions of the engines (extra `second-source`). `--kept DIR` asks another state of the program about
cases that were kept, without the engines.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..case import Case, generate
from ..concealment import orders
from ..pipeline import arguments, conduct
from .cases import KINDS, draw_case


def main() -> None:
    parser = arguments(__doc__, jobs=1)
    parser.add_argument("--count", type=int, default=40, help="cases in which something is hidden")
    parser.add_argument("--healthy", type=int, default=8, help="cases in which nothing is")
    parser.add_argument("--only", action="append", default=[], choices=KINDS, help="kinds")
    chosen = parser.parse_args()

    def draw(seed: int) -> Iterator[Case]:
        """One by one, since an engine is one to a process."""
        wanted = orders(KINDS, chosen.count, chosen.healthy, seed, tuple(chosen.only))
        return generate(draw_case, wanted[: chosen.limit], seed)

    conduct(chosen, draw, "The second source", "-second-source", every=True)


if __name__ == "__main__":
    main()
