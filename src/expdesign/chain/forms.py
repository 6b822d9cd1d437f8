"""Forms of physics at an actuator: laws of the force that it carries, its place, time or history."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import casadi as ca

from expdesign.chain.declaration import Beyond, Parameter
from expdesign.chain.row import Row


@dataclass(frozen=True)
class Acting:
    """One of the actuators concerned, at a row.

    Attributes:
        index: which one.
        before: its force in the reference state (N or N·m).
        force: by which the load changes that.
        compliance: c (m/N or rad/(N·m)).
        elongation: what it has gained so far (m or rad).
        place: its commanded coordinate (m or rad).
        state: what it remembers of the row before, (`Form.memory`,).
        row: the row.
    """

    index: int
    before: ca.SX
    force: ca.SX
    compliance: ca.SX
    elongation: ca.SX
    place: ca.SX
    state: ca.SX
    row: Row


Law = Callable[[Acting, ca.SX], tuple[ca.SX, ca.SX]]
"""What an actuator gains (m or rad) and its next states, from what is known of it and parameters."""
LoadLaw = Callable[[ca.SX, Row, ca.SX], ca.SX]
"""The actual wrench (n,) from the assumed one, the row and parameters."""


@dataclass(frozen=True)
class Form:
    """A variant of physics: a law of single actuators or of the load, with everything that is the variant's own.

    Attributes:
        law: what each actuator gains.
        name: text of the variant in files, which tells it from others; empty for the only one.
        memory: states of one actuator.
        load: what the load is.
        parameters: with names as `DeclaredEffect.quantities` has them; empty where those of the physics are its own.
        says: its sentence, where it is another one than that of the physics.
        called: name of the parametric form, where its physics has several (`Effect.form_name`).
        beyond: what it does beyond the recorded range, where that is not what its physics does.
    """

    law: Law | None = field(default=None, compare=False)
    name: str = ""
    memory: int = field(default=0, compare=False)
    parameters: tuple[Parameter, ...] = field(default=(), compare=False)
    says: str = field(default="", compare=False)
    called: str = field(default="", compare=False)
    beyond: Beyond | None = field(default=None, compare=False)
    load: LoadLaw | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return self.name


def carried(before: ca.SX, load: ca.SX, friction: ca.SX) -> ca.SX:
    """Play operator: the part of a load behind dry friction, which follows only when the load has moved by more."""
    return ca.fmin(ca.fmax(before, load - friction), load + friction)


def relaxed(before: ca.SX, towards: ca.SX, interval: ca.SX, tau: ca.SX | float) -> ca.SX:
    """State after an interval (s) of τ·ds/dt = towards − s (Kelvin-Voigt)."""
    return before + (towards - before) * (1.0 - ca.exp(-interval / tau))


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


def warm_up(at: Acting, theta: ca.SX, *, by_rows: bool = False) -> tuple[ca.SX, ca.SX]:
    """Δq gains drift·(e^(−t₀/τ) − e^(−t/τ)), since the first row of all; t₀ is that of the series' first row.

    In recordings without time t counts rows (`by_rows`); positions are relative to no row, and t₀ is 0.
    """
    row = at.row
    before, now = (row.reference, row.number) if by_rows else (row.clock - row.elapsed, row.clock)
    return theta[0] * (ca.exp(-before / theta[1]) - ca.exp(-now / theta[1])), at.state
