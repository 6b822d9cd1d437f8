"""Play: an actuator with a gap, which its force closes to one side; of legs (`effects/legs/transmission.py`) and of
joints (`effects/joints/backlash.py`).
"""

from functools import partial

import casadi as ca

from expdesign.chain.form import Acting, Form

SLACK = 1e-3
"""N or N·m; an actuator with less force than this rests where it rested unloaded."""


def play(at: Acting, theta: ca.SX, upper: float = 0.5, lower: float = -0.5) -> tuple[ca.SX, ca.SX]:
    """Δq gains the way from where the unloaded actuator rests to the end of the gap at which its force holds it.

    The gap is θ₀, or θ₀ + θ₁·q where there are two parameters, and never negative. A positive and a negative force hold
    the actuator at `upper` and `lower`, in gaps from where it rests. The reference state may be loaded.
    """

    def place(total: ca.SX) -> ca.SX:
        return ca.if_else(total > SLACK, upper, ca.if_else(total < -SLACK, lower, 0.0))

    gap = theta[0]
    if theta.shape[0] > 1:
        gap = gap + theta[1] * at.place
        # At a gap of 0 exactly, where every search starts, the slope must not be lost.
        gap = ca.if_else(gap < 0.0, 0.0, gap)
    return gap * (place(at.before + at.force) - place(at.before)), at.state


def resting(low: str, high: str) -> tuple[Form, Form, Form]:
    """Play of an actuator that rests in the middle of its gap, or at its lower or upper end, by the names of these."""
    ends = partial(play, upper=1.0, lower=0.0), partial(play, upper=0.0, lower=-1.0)
    return Form(play, "middle"), Form(ends[0], low), Form(ends[1], high)
