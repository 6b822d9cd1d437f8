"""What remembers the row before: a load behind dry friction, and what relaxes towards a value with time."""

import casadi as ca


def carried(before: ca.SX, load: ca.SX, friction: ca.SX) -> ca.SX:
    """Play operator: the part of a load behind dry friction, which follows only when the load has moved by more."""
    return ca.fmin(ca.fmax(before, load - friction), load + friction)


def relaxed(before: ca.SX, towards: ca.SX, interval: ca.SX, tau: ca.SX | float) -> ca.SX:
    """State after an interval (s) of τ·ds/dt = towards − s (Kelvin-Voigt)."""
    return before + (towards - before) * (1.0 - ca.exp(-interval / tau))
