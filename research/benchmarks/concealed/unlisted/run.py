"""Outside the library: `python -m research.benchmarks.concealed.unlisted.run` generates, asks and scores.

150 cases outside the library, 60 of listed physics whose entries are left out, 200 consistent ones, from a seed that is
drawn afresh unless one is given.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..case import Case, generate
from ..pipeline import arguments, conduct
from .cases import FAMILIES, counts_of, draw_case, orders


def main() -> None:
    parser = arguments(__doc__, jobs=2)
    parser.add_argument("--count", type=int, default=150, help="cases outside the library (of --family: of it)")
    parser.add_argument("--left-out", type=int, default=60, help="cases of listed physics whose entries are left out")
    parser.add_argument("--none", type=int, default=200, help="consistent cases")
    parser.add_argument("--family", choices=FAMILIES, help="only this family")
    parser.add_argument("--only", action="append", default=[], help="names of recipes")
    chosen = parser.parse_args()
    counts = {chosen.family: chosen.count} if chosen.family else counts_of(chosen.count, chosen.left_out, chosen.none)

    def draw(seed: int) -> Iterator[Case]:
        return generate(draw_case, orders(counts, seed, chosen.only)[: chosen.limit], seed, chosen.jobs)

    conduct(chosen, draw, "Outside the library", f"-outside{'' if chosen.seed is None else '-development'}")


if __name__ == "__main__":
    main()
