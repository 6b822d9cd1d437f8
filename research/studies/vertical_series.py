"""A series of vertical loads: its slope, one stiffness for all legs, is the robot linear (theory.md 9.G)?"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.stats import chi2

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import Estimate, mean, standard_deviation
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from research.studies.equilibrium import EquilibriumPlant
from research.studies.pose_errors import MICRO

Z = 2


def _vertical(forces: Sequence[float]) -> Plan:
    """Vertical forces at the zero pose."""
    loads = np.zeros((len(forces), 6))
    loads[:, Z] = forces
    series = np.arange(len(loads)) + 1
    return Plan(np.zeros((len(loads), 6)), loads, series)


def exact_deflections(true: DesignProblem, forces: Sequence[float]) -> FloatArray:
    """Exact deflections of z of the vertical series (m), shape (m,)."""
    plan = _vertical(forces)
    deflections: FloatArray = EquilibriumPlant(true.loaded, plan).deflections(np.zeros((1, len(plan), 6)))[0, :, Z]
    return deflections


def _vertical_sum(true: DesignProblem) -> float:
    """Σu_z² of the unit vectors along the legs at the zero pose."""
    inverse = np.linalg.inv(true.loaded.robot.jacobians(np.zeros(6)).forward)
    return float((inverse[:, Z] ** 2).sum())


def _noise_of_z(true: DesignProblem) -> float:
    return float(np.sqrt(true.noise.covariance[Z, Z]))


def measured_series(true: DesignProblem, vertical: Sequence[float], exact: FloatArray, seed: int) -> pd.DataFrame:
    """One series with noise, and the line through it."""
    forces = np.array(vertical)
    noise = _noise_of_z(true) * np.random.default_rng(seed).standard_normal(len(forces))
    measured = MICRO * (exact + noise)
    slope = float(forces @ measured / (forces @ forces))
    return pd.DataFrame({"force_N": forces, "z_um": measured, "line_um": slope * forces})


def repeated_lines(
    true: DesignProblem, vertical: Sequence[float], exact: FloatArray, samples: int, seed: int
) -> pd.DataFrame:
    """Slope and equal-leg stiffness of repeated series, and the sum of squares about the lines."""
    forces, deviation = np.array(vertical), _noise_of_z(true)
    noise = deviation * np.random.default_rng([seed, 1]).standard_normal((samples, len(forces)))
    slopes = (exact + noise) @ forces / (forces @ forces)
    squares = ((exact + noise - slopes[:, None] * forces) ** 2).sum(axis=1) / deviation**2
    slope = float(true.loaded.robot.compliance @ _reach(true))
    spread = deviation / float(np.sqrt(forces @ forces))
    total = _vertical_sum(true)
    stiffness = 1e-6 / (slopes * total)
    freedom = len(forces) - 1
    # To second order E[1/s] = (1 + σ²/s²)/s.
    apk = 1e-6 / (slope * total) * (1.0 + (spread / slope) ** 2)
    quantities: list[tuple[str, Estimate, float]] = [
        ("slope (nm/N)", mean(1e9 * slopes), 1e9 * slope),
        ("its standard deviation (nm/N)", standard_deviation(1e9 * slopes), 1e9 * spread),
        ("apk (N/µm)", mean(stiffness), apk),
        ("its standard deviation (N/µm)", standard_deviation(stiffness), apk * spread / slope),
        ("squares about the line over σ²", mean(squares), float(freedom)),
        ("their 95 % quantile is exceeded by (share)", mean((squares > chi2.ppf(0.95, freedom)).astype(float)), 0.05),
    ]
    rows = [
        {"quantity": name, "value": float(e.value), "value_se": float(e.standard_error), "value_predicted": predicted}
        for name, e, predicted in quantities
    ]
    return pd.DataFrame(rows)


def _reach(true: DesignProblem) -> FloatArray:
    """Deflection of z per compliance and unit of vertical force at the zero pose, shape (6,)."""
    jacobians = true.loaded.robot.jacobians(np.zeros(6))
    reach: FloatArray = jacobians.pose[Z] * jacobians.forward[Z]
    return reach
