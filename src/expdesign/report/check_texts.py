"""What `expdesign check` says of a file, in words."""

import numpy as np

from expdesign.design.feasibility import Feasibility
from expdesign.design.problem import DesignProblem
from expdesign.identification.identify import Identification
from expdesign.robots.robot import Robot

_FEW = 0.01
"""Share of reachable poses below which the units of `experiment.poses` are probably wrong."""


def robot_summary(robot: Robot, condition: float) -> str:
    """That a robot can be used.

    Args:
        robot: the robot.
        condition: scaled condition number at its reference configuration.
    """
    return (
        f"{robot.kind} `{robot.name}` with {len(robot.stiffness)} actuators is usable "
        f"(scaled condition number {condition:.3g} at its reference pose)."
    )


def model_summary(effects: int, robot: str) -> str:
    """What a model file holds, with the summary of its robot."""
    return f"identified model with {_counted(effects, 'effect')} of a {robot}"


def problem_summary(problem: DesignProblem, found: Feasibility) -> str:
    """What a configuration asks for, and how much of its design space serves."""
    space = problem.space
    continuous = int((~space.discrete).sum())
    return (
        f"{problem.loaded.robot.kind} `{problem.loaded.robot.name}`, {space.measurements} measurements with "
        f"{continuous} continuous and {space.decisions - continuous} discrete variables each, "
        f"{_counted(len(problem.targets.weights), 'target')}; {found.reachable:.0%} of the poses can be reached, "
        f"{found.identifying:.0%} of random designs identify what the targets need."
    )


def problem_remarks(problem: DesignProblem, found: Feasibility) -> tuple[str, ...]:
    """What is doubtful about a configuration."""
    remarks = []
    if found.reachable < _FEW:
        remarks.append("hardly any pose in `experiment.poses` can be reached; check their units (m, rad)")
    if problem.found is not None:
        remarks.append(problem.found.note)
    return tuple(f"{problem.source}: {remark}" for remark in remarks)


def sweep_summary(runs: int, keys: list[str]) -> str:
    """How many runs a sweep has, and which keys it varies."""
    return f"sweep of {runs} runs over {', '.join(keys)}"


def identified_summary(result: Identification) -> str:
    """What recordings identify, and how well: the stiffness of every actuator, the geometry, or both."""
    texts = []
    if result.calibration != "geometric":
        relative = np.sqrt(np.diag(result.covariance)) / np.abs(result.compliance.estimate)
        worst = int(np.argmax(relative))
        texts.append(
            f"They identify all {len(relative)} stiffnesses, the worst "
            f"({result.robot.actuators[worst]}) to {relative[worst]:.2%} (one standard deviation)."
        )
    if result.geometry is not None:
        half = (result.geometry.high - result.geometry.low) / 2.0
        texts.append(
            f"They identify {half.size} parameters of the geometry, their 95 % intervals being within "
            f"±{1e6 * half.min():.3g} to ±{1e6 * half.max():.3g} µm."
        )
    return " ".join(texts)


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
