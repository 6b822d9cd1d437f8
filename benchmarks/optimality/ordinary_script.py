"""The same design problem as a competent person would script it in an afternoon: pymoo, NumPy, loops.

One class, one design at a time, Jacobians by finite differences, a pseudo-inverse. It is meant to be ordinary, not bad:
no more is computed than is needed, and the results agree with the program's (`hypervolume.py` checks that first).
"""

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pymoo.core.problem import ElementwiseProblem

GRAVITY = 9.80665


class OrdinaryScript(ElementwiseProblem):  # type: ignore[misc]
    """DUIR and FEIR of a payload on a hexapod (fixed-xyz), read from a configuration with one or more targets."""

    def __init__(self, path: Path) -> None:
        config = yaml.safe_load(path.read_text(encoding="utf-8"))
        robot = config["robot"]
        robot = yaml.safe_load((path.parent / robot).read_text(encoding="utf-8")) if isinstance(robot, str) else robot
        experiment = config["experiment"]
        self.base = np.array(robot["base_joints"], dtype=float)
        self.platform = np.array(robot["platform_joints"], dtype=float)
        self.home = np.array(robot["home"], dtype=float)
        self.compliance = 1.0 / np.array(robot["actuator_stiffness"], dtype=float)
        self.legs = robot["limits"]["leg_length"]
        self.m = experiment["measurements"]
        self.masses = experiment["load"]["mass_kg"]["choices"]
        self.com_z = experiment["load"]["com_z_m"]
        bounds = [experiment["poses"]["bounds"][k] for k in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")]
        bounds += [[0.0, len(self.masses) - 1e-9], experiment["load"]["com_x_m"], experiment["load"]["com_y_m"]]
        noise = experiment["deflection_noise"]["std"]
        self.whiten = np.diag([1.0 / float(noise[f"d{k}"]) for k in AXES])
        self.errors = experiment["load_error"]
        self.targets = []
        for target in config["targets"]:
            pose, load = np.array(target["pose"], dtype=float), target["payload"]
            a = self.observation(pose, load["mass_kg"], np.array(load["com_m"], dtype=float))[0]
            scale = np.array([1.0 / float(target["tolerance"].get(f"d{k}", np.inf)) for k in AXES])
            self.targets.append((scale[:, None] * a, float(target.get("weight", 1.0))))
        low, high = np.array(bounds, dtype=float).T
        super().__init__(n_var=9 * self.m, n_obj=2, n_ieq_constr=1, xl=np.tile(low, self.m), xu=np.tile(high, self.m))

    def rotation(self, angles: np.ndarray) -> np.ndarray:
        cx, cy, cz = np.cos(angles)
        sx, sy, sz = np.sin(angles)
        rx = np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
        ry = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
        rz = np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
        return rz @ ry @ rx

    def lengths(self, pose: np.ndarray) -> np.ndarray:
        r = self.rotation(pose[3:])
        p = self.home + pose[:3]
        return np.array([np.linalg.norm(p + r @ self.platform[i] - self.base[i]) for i in range(6)])

    def observation(
        self, pose: np.ndarray, mass: float, com: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """A, the compliance D, R and the wrench at one pose."""
        rates = np.zeros((6, 6))
        for k in range(6):
            step = np.zeros(6)
            step[k] = 1e-6
            rates[:, k] = (self.lengths(pose + step) - self.lengths(pose - step)) / 2e-6
        r = self.rotation(pose[3:])
        rz = self.rotation(np.array([0.0, 0.0, pose[5]]))
        ryz = self.rotation(np.array([0.0, pose[4], pose[5]]))
        e = np.stack([ryz[:, 0], rz[:, 1], np.array([0.0, 0.0, 1.0])], axis=1)
        twist = np.eye(6)
        twist[3:, 3:] = np.linalg.inv(e)
        j_pose = np.linalg.inv(rates)
        j = np.linalg.inv(rates @ twist)
        force = np.array([0.0, 0.0, -mass * GRAVITY])
        wrench = np.concatenate([force, np.cross(r @ com, force)])
        tau = j.T @ wrench
        return j_pose @ np.diag(tau), j_pose @ np.diag(self.compliance) @ j.T, r, wrench

    def sensitivity(self, source: str, r: np.ndarray, mass: float, com: np.ndarray) -> np.ndarray:
        """Change of the wrench per unit of a load error."""
        g = np.array([0.0, 0.0, -GRAVITY])
        if source == "com":
            columns = [np.concatenate([np.zeros(3), np.cross(r @ axis, mass * g)]) for axis in np.eye(3)]
        elif source == "mass":
            columns = [np.concatenate([g, np.cross(r @ com, g)])]
        elif source == "direction":
            turned = [np.cross(axis, g) for axis in np.eye(3)[:2]]
            columns = [np.concatenate([mass * t, np.cross(r @ com, mass * t)]) for t in turned]
        else:
            columns = list(np.eye(6))
        return np.stack(columns, axis=1)

    def _evaluate(self, x: np.ndarray, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        rows, effects, excess = [], [], -np.inf
        for i in range(self.m):
            decisions = x[9 * i : 9 * i + 9]
            pose, mass = decisions[:6], float(self.masses[int(decisions[6])])
            com = np.array([decisions[7], decisions[8], self.com_z])
            q = self.lengths(pose)
            excess = max(excess, (self.legs[0] - q).max(), (q - self.legs[1]).max())
            a, d, r, _ = self.observation(pose, mass, com)
            rows.append(self.whiten @ a)
            effects.append([self.whiten @ d @ self.sensitivity(s["source"], r, mass, com) for s in self.errors])
        gain = np.linalg.pinv(np.vstack(rows))
        duir = feir = weights = 0.0
        for target, weight in self.targets:
            z = target @ gain
            duir += weight * (z**2).sum()
            weights += weight
            for k, source in enumerate(self.errors):
                std = np.diag(np.atleast_1d(np.array(source["std"], dtype=float)))
                parts = [z[:, 6 * i : 6 * i + 6] @ effects[i][k] @ std for i in range(self.m)]
                if source.get("shared", True):
                    feir += weight * (sum(parts) ** 2).sum()
                else:
                    feir += weight * sum((part**2).sum() for part in parts)
        out["F"] = [np.sqrt(duir / weights), np.sqrt(feir / weights)]
        out["G"] = [excess]


AXES = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")
