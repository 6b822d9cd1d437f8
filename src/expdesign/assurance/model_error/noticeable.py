"""How far from the null hypothesis an effect has to be for the goodness-of-fit test to find it."""

from functools import lru_cache

from scipy.optimize import brentq
from scipy.special import chdtri, chndtr

from expdesign.errors import InputError

LEVEL = 0.01
"""α: share of sound machines in which the test raises an alarm."""
POWER = 0.8
"""1 − β: share of experiments in which an effect that is just noticed is found."""


@lru_cache(maxsize=256)
def noncentrality(dof: int, level: float = LEVEL, power: float = POWER) -> float:
    """λ at which a χ² test with `dof` degrees of freedom at the given level has the given power.

    P(χ²_dof(λ) > q) = 1 − β with q the (1 − α) quantile of the central distribution (Patnaik 1949). 11.68 for one
    degree of freedom, 1 % and 80 %.

    Raises:
        InputError: the level and the power are not 0 < α < 1 − β < 1.
    """
    if not 0.0 < level < power < 1.0:
        what = f"a test at the level {level:g} with the power {power:g} does not exist"
        raise InputError(what, where="model_error", remedy="Choose 0 < level < power < 1, such as 0.01 and 0.8.")
    if dof < 1:
        raise ValueError("a test needs at least one degree of freedom")
    critical = chdtri(dof, level)
    high = 1.0
    while 1.0 - chndtr(critical, dof, high) < power:
        high *= 2.0
    return float(brentq(lambda value: 1.0 - chndtr(critical, dof, value) - power, 0.0, high, xtol=1e-12, rtol=1e-12))
