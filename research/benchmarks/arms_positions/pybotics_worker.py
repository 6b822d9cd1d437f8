"""Calibration by pybotics (3.1.2) of the rows in a folder; runs where pybotics is installed.

    python pybotics_worker.py FOLDER

`task.npz` holds the axes of the joints at zero (`points`, `axes`, `prismatic`, in the base's frame), the tip, commands
and positions. The arm is written in modified Denavit-Hartenberg parameters, which are its only form, and calibrated as
its documentation does: parameters of the chain, the tool's position and the world's frame by SciPy's `least_squares`
over `optimize_accuracy`, the distances to the readings. Writes `result.json`, as `figaroh_worker.py`.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def frames_along(points: Array, axes: Array) -> list[Array]:
    """Frame of every joint (n, 4, 4) in modified Denavit-Hartenberg form: z along it, x along the normal to the next.

    Parallel axes have many normals: the one through the joint's own point is taken.
    """
    found = []
    for index, (point, z) in enumerate(zip(points, axes, strict=True)):
        foot, x = point, np.cross(z, np.eye(3)[np.argmin(np.abs(z))])
        if index + 1 < len(points):
            other, along = points[index + 1], axes[index + 1]
            normal = np.cross(z, along)
            away = other - point
            if np.linalg.norm(normal) > 1e-9:
                # Feet of the common normal: point + s·z and other + t·along.
                s, _ = np.linalg.lstsq(np.stack([z, -along], axis=1), away, rcond=None)[0]
                foot, x = point + s * z, normal
            else:
                across = away - (away @ z) * z
                x = across if np.linalg.norm(across) > 1e-9 else x
        x = x / np.linalg.norm(x)
        frame = np.eye(4)
        frame[:3] = np.stack([x, np.cross(z, x), z, foot], axis=1)
        found.append(frame)
    return found


def between(before: Array, after: Array) -> list[float]:
    """Parameters alpha, a, theta, d from one frame to the next; `before` has its x along their common normal."""
    relative = np.linalg.inv(before) @ after
    alpha = np.arctan2(-relative[1, 2], relative[2, 2])
    theta = np.arctan2(-relative[0, 1], relative[0, 0])
    d = -np.sin(alpha) * relative[1, 3] + np.cos(alpha) * relative[2, 3]
    return [alpha, relative[0, 3], theta, d]


def main() -> None:
    from pybotics.kinematic_chain import MDHKinematicChain  # noqa: PLC0415
    from pybotics.link import PrismaticMDHLink, RevoluteMDHLink  # noqa: PLC0415
    from pybotics.optimization import OptimizationHandler, optimize_accuracy  # noqa: PLC0415
    from pybotics.robot import Robot  # noqa: PLC0415
    from pybotics.tool import Tool  # noqa: PLC0415
    from scipy.optimize import least_squares  # noqa: PLC0415

    folder = Path(sys.argv[1])
    task = np.load(folder / "task.npz")
    frames = frames_along(task["points"], task["axes"])
    links = []
    for index, sliding in enumerate(task["prismatic"]):
        parameters = [0.0, 0.0, 0.0, 0.0] if index == 0 else between(frames[index - 1], frames[index])
        links.append((PrismaticMDHLink if sliding else RevoluteMDHLink)(*parameters))
    last = np.linalg.inv(frames[-1]) @ task["tip"]
    robot = Robot(MDHKinematicChain(links), tool=Tool(last), world_frame=task["world"] @ frames[0])
    drawn = np.array([robot.fk(each)[:3, 3] for each in task["commands"][:5]])
    assert np.allclose(drawn, task["drawn"], atol=1e-9), "the chain is not that of the URDF"

    start = time.process_time()
    mask = np.ones(4 * len(links), dtype=bool)
    mask[:4] = False  # they are the world's frame
    # Its own form: the tool's place, and all of the world's frame.
    handler = OptimizationHandler(robot, kinematic_chain_mask=mask, tool_mask=[True] * 3 + [False] * 3, world_mask=True)
    found = least_squares(
        optimize_accuracy,
        handler.generate_optimization_vector(),
        args=(handler, task["commands"], task["positions"]),
        x_scale="jac",
    )
    handler.apply_optimization_vector(found.x)
    seconds = time.process_time() - start
    positions = [[handler.robot.fk(each)[:3, 3].tolist()] for each in task["held_out"]]
    result = {"positions": positions, "parameters": len(found.x), "seconds": seconds}
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main()
