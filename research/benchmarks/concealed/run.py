"""The proof in one command: `python -m research.benchmarks.concealed.run` generates cases, asks and scores.

Every diagnosis is a process of its own, started in an empty folder, given a folder that holds the robot file and the
recordings alone. The seed is drawn afresh unless one is given.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from .case import Case, generate
from .cases import draw_case, orders
from .pipeline import arguments, conduct


def main() -> None:
    parser = arguments(__doc__, jobs=2)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--only", action="append", default=[], help="an identifier, or none, one, two, outside")
    parser.add_argument("--again", type=int, default=2, help="how many cases to diagnose a second time")
    chosen = parser.parse_args()
    proof = chosen.seed is None and not chosen.only
    if proof and not chosen.results:
        chosen.results = Path("results/concealed")

    def draw(seed: int) -> Iterator[Case]:
        return generate(draw_case, orders(chosen.count, seed, chosen.only)[: chosen.limit], seed, chosen.jobs)

    title = "Proof on concealed data" if proof else "Development set of concealed data"
    conduct(chosen, draw, title, "" if proof else "-development", repeated=chosen.again)


if __name__ == "__main__":
    main()
