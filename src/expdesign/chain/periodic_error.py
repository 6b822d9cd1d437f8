"""An error of an actuator's command that repeats, the same in a leg's screw and in a joint's gear."""

import casadi as ca

from expdesign.chain.row import Row


def with_periodic_error(elongation: ca.SX, row: Row, actuator: int, theta: ca.SX) -> ca.SX:
    """Elongations (n_p,) with sine and cosine `theta[0]`, `theta[1]` of the command in periods of `theta[2]`."""
    angle = 2.0 * ca.pi * row.lengths[actuator] / theta[2]
    gained = ca.SX.zeros(elongation.shape[0])
    gained[actuator] = theta[0] * ca.sin(angle) + theta[1] * ca.cos(angle)
    return elongation + gained


def amplitude_pitch_phase(theta: ca.SX, unit: str) -> dict[str, ca.SX]:
    """The same parameters as people know them, with amplitude and pitch in `unit` (m or rad)."""
    return {
        f"amplitude_{unit}": ca.sqrt(theta[0] ** 2 + theta[1] ** 2),
        f"pitch_{unit}": theta[2],
        "phase_rad": ca.atan2(theta[1], theta[0]),
    }
