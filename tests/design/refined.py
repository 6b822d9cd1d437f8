"""Designs that a search makes of given ones, for tests of what holds at optima."""

from dataclasses import replace

from expdesign.planning.problem import DesignProblem
from expdesign.planning.search import search
from tests.oracle import Array


def refined(here: DesignProblem, designs: Array, generations: int | None = None) -> Array:
    """The front (d, m, g) of a search with gradients that begins with designs (b, m, g)."""
    options = here.optimiser.with_values(polish=True, generations=generations)
    return search(replace(here, optimiser=options), start=designs).decisions
