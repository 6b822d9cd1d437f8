"""Cases of serial arms: a random arm, an experiment with deflections, physics of 2 to 10 standard deviations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ..hidden import UnsuitableError, plain
from ..linear_model import Array
from ..unlisted.cases import LEAST, MOST, Case
from .mechanics import DEFLECTION, JOINTS, WRENCH, Arm, Hidden
from .recipes import RECIPES

_ATTEMPTS = 100


def draw_arm(rng: np.random.Generator) -> tuple[dict[str, Any], str, Array]:
    """Robot file, URDF and true joint compliances (rad/(N m)) of a six-axis arm with a spherical-like wrist."""
    size = rng.uniform(0.8, 1.4)
    upper, fore, side = (size * rng.uniform(*each) for each in ((0.38, 0.5), (0.35, 0.45), (0.02, 0.12)))
    joints = [  # place in the parent (m), axis, mass (kg) and centre of the link that it moves
        ((0, 0, 0.16 * size), "0 0 1", 6.0, (0, 0, 0.02)),
        ((0, side, 0.05), "0 1 0", 9.0, (0, 0, upper / 2)),
        ((0, -0.5 * side, upper), "0 1 0", 4.0, (0, 0, fore / 2)),
        ((0, 0, fore), "0 0 1", 1.5, (0, 0, 0.02)),
        ((0, 0.01, 0.09 * size), "0 1 0", 1.2, (0, 0, 0.03)),
        ((0, 0, 0.09 * size), "0 0 1", 0.4, (0, 0, 0.01)),
    ]
    text = '<robot name="arm"><link name="base"/>'
    for number, (place, axis, mass, centre) in enumerate(joints, start=1):
        xyz, middle = (" ".join(f"{each:.6g}" for each in values) for values in (place, centre))
        parent = "base" if number == 1 else f"part_{number - 1}"
        text += (
            f'<link name="part_{number}"><inertial><origin xyz="{middle}" rpy="0 0 0"/><mass value="{mass:.4g}"/>'
            '<inertia ixx="0.05" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>'
            f'<joint name="axis_{number}" type="revolute"><origin xyz="{xyz}" rpy="0 0 0"/><parent link="{parent}"/>'
            f'<child link="part_{number}"/><axis xyz="{axis}"/>'
            '<limit lower="-6.28" upper="6.28" effort="300" velocity="3"/></joint>'
        )
    text += (
        '<link name="flange"/><joint name="mount" type="fixed"><origin xyz="0 0 0.05" rpy="0 0 0"/>'
        '<parent link="part_6"/><child link="flange"/></joint></robot>'
    )
    true = np.array([3e4, 3e4, 1.5e4, 6e3, 6e3, 5e3]) * size**2 * rng.uniform(0.8, 1.25, 6)
    described = [float(f"{each:.3g}") for each in true * rng.uniform(0.75, 1.3, 6)]
    robot = {"name": "arm", "kind": "serial", "urdf": "arm.urdf", "base_link": "base", "tip_link": "flange"}
    return robot | {"actuator_stiffness": described}, text, 1.0 / true


def _rows(rng: np.random.Generator) -> tuple[pd.DataFrame, NDArray[np.bool_]]:
    """Series of loads at configurations, and which of the rows are the judge's: inside and between the others."""
    count = int(rng.integers(14, 26))
    commands = rng.uniform([-1.5, -0.9, 0.5, -1.2, -1.3, -1.5], [1.5, 0.6, 1.9, 1.2, 1.3, 1.5], (count, 6)).round(4)
    series = []
    for command in commands:
        levels = np.array([0.0, 0.5, 1.0, 0.5, 0.0 if rng.random() < 0.3 else 0.25])[: int(rng.integers(4, 6))]
        direction = rng.normal(size=6) * [40, 40, 60, 8, 8, 8]
        series.append((command, np.outer(levels, direction), False))
    for _ in range(max(4, count // 4)):
        one, other = rng.choice(count, 2, replace=False)
        share = rng.uniform(0.2, 0.8)
        command = (share * commands[one] + (1 - share) * commands[other]).round(4)
        series.insert(int(rng.integers(1, len(series))), (command, 0.85 * series[one][1], True))
    blocks, aside = [], []
    for number, (command, wrench, later) in enumerate(series, start=1):
        block = pd.DataFrame(np.tile(command, (len(wrench), 1)), columns=list(JOINTS))
        block.insert(0, "series", number)
        blocks.append(pd.concat([block, pd.DataFrame(wrench.round(3) + 0.0, columns=list(WRENCH))], axis=1))
        aside += [later] * len(wrench)
    rows = pd.concat(blocks, ignore_index=True)
    rows.insert(0, "sequence", np.arange(1, len(rows) + 1))
    return rows, np.array(aside)


def draw_case(physics: str, rng: np.random.Generator) -> Case:
    """One case; `physics` is a recipe's name or `none`."""
    reasons = []
    for _ in range(_ATTEMPTS):
        try:
            return _attempt(physics, rng)
        except UnsuitableError as error:
            reasons.append(str(error))
    raise RuntimeError(f"{physics}: no suitable experiment in {_ATTEMPTS}: {sorted(set(reasons))}")


def _attempt(physics: str, rng: np.random.Generator) -> Case:
    robot, urdf, compliance = draw_arm(rng)
    rows, aside = _rows(rng)
    std = np.array([rng.uniform(8, 30) * 1e-6] * 3 + [rng.uniform(15, 60) * 1e-6] * 3)
    arm = Arm(urdf, compliance)
    each = zip(rows[list(JOINTS)].to_numpy(dtype=float), rows[list(WRENCH)].to_numpy(dtype=float), strict=True)
    maps = [(jacobian := arm.jacobian(q), jacobian.T @ wrench) for q, wrench in each]
    matrices, torques = np.array([j * t for j, t in maps]), np.array([t for _, t in maps])
    whitened = (matrices[~aside] / std[None, :, None]).reshape(-1, 6)
    basis = np.linalg.svd(whitened, full_matrices=False)[0]
    dof = len(whitened) - 6

    def clean(hidden: Hidden | None) -> Array:
        return Arm(urdf, compliance, [] if hidden is None else [hidden]).deflections(rows)

    def mismatch(deflections: Array) -> float:
        left = (deflections[~aside] / std).ravel()
        left = left - basis @ (basis.T @ left)
        return float(np.sqrt(left @ left / dof))

    effects: list[dict[str, Any]] = []
    true = clean(None)
    if mismatch(true) > 0.1:
        raise UnsuitableError("the change of geometry under load shows")
    if physics != "none":
        concealed = RECIPES[physics](compliance, torques, rng)
        target = float(np.exp(rng.uniform(np.log(LEAST), np.log(MOST))))
        at, found = float(np.sqrt(concealed.low * concealed.high)), 0.0
        for _ in range(12):
            true = clean(concealed.of_size(at))
            found = mismatch(true)
            if abs(np.log(found / target)) < 0.1:
                break
            at = float(np.clip(at * (target / found) ** 1.0, concealed.low, concealed.high))
        if not 0.9 * LEAST <= found <= 1.1 * MOST:
            raise UnsuitableError(f"{physics} cannot be made to show as much as wanted")
        entry = {"physics": physics, "listed": False, "parts": concealed.parts, "names": concealed.names, "size": at}
        effects = [entry | {"mismatch_in_std": found, "curves": []}]
    recorded = true + rng.normal(size=true.shape) * std
    base = np.linalg.lstsq(whitened, (recorded[~aside] / std).ravel(), rcond=None)[0]
    written = rows.copy()
    written[list(DEFLECTION)] = recorded
    for name, value in zip(DEFLECTION, std, strict=True):
        written["s" + name[1:]] = value
    later = written[aside].reset_index(drop=True)
    for axis, name in enumerate(DEFLECTION):
        later[f"true_{name}"], later[f"base_{name}"] = true[aside][:, axis], (matrices[aside] @ base)[:, axis]
    truth: dict[str, Any] = {
        "family": "none" if physics == "none" else "alone",
        "robot": "arm",
        "made_for": [physics],
        "without": [],
    }
    truth |= {"effects": effects, "mismatch_in_std": mismatch(true), "true_stiffness": 1.0 / compliance}
    truth |= {"rows": int((~aside).sum()), "series": int(rows.loc[~aside, "series"].nunique())}
    return Case(robot, written[~aside].reset_index(drop=True), later, plain(truth), {"arm.urdf": urdf})
