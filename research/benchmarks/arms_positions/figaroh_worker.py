"""Calibration by FIGAROH (1.0.2) of the rows in a folder; runs where FIGAROH is installed.

    python figaroh_worker.py FOLDER LEVEL

`LEVEL` is `offsets`, `all` (its structural base parameters), `priors` (its estimation method `map`), or one of
`offsets` and `all` with `+compliances`. `task.json` names URDF, links, joints and markers; `train.csv` and `test.csv`
are in its own layout. Writes `result.json`: held-out positions, number of parameters, processor time.
"""

import contextlib
import io
import json
import logging
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np

warnings.simplefilter("ignore")
logging.disable(logging.CRITICAL)


def configuration(task: dict[str, Any], level: str, folder: Path) -> dict[str, Any]:
    kind = level.partition("+")[0]
    parameters = {
        "calibration_level": "joint_offset" if kind == "offsets" else "full_params",
        "include_non_geometric": level == "offsets+compliances",
        "outlier_threshold": 1.0,  # m: nothing is left out
        "estimation": {"method": "map" if kind == "priors" else "structural"},
    }
    markers = [{"measurable_dof": [True, True, True, False, False, False]}] * task["markers"]
    calibration = {
        "kinematics": {"base_frame": task["base"], "tool_frame": task["tip"]},
        "joints": {"active_joints": task["joints"]},
        "parameters": parameters,
        "measurements": {"markers": markers},
        "data": {"source_file": str(folder / "train.csv"), "number_of_samples": 200},
    }
    return {"robot": {"name": "arm"}, "tasks": {"calibration": calibration}}


def main() -> None:
    # Imported before the clock starts.
    import pinocchio as pin  # noqa: PLC0415
    import yaml  # noqa: PLC0415
    from figaroh.calibration.base_calibration import BaseCalibration  # noqa: PLC0415
    from figaroh.calibration.calibration_tools import calc_updated_fkm  # noqa: PLC0415
    from figaroh.calibration.config import _build_elastic_param_names  # noqa: PLC0415
    from figaroh.data.observations import PoseObservations  # noqa: PLC0415

    folder, level = Path(sys.argv[1]), sys.argv[2]
    task = json.loads((folder / "task.json").read_text(encoding="utf-8"))
    config = folder / "config.yaml"
    config.write_text(yaml.safe_dump(configuration(task, level, folder)), encoding="utf-8")

    class Arm(BaseCalibration):  # type: ignore[misc]
        """Positions in the instrument's axes, unweighted: as in its examples."""

        def cost_function(self, var: Any) -> Any:
            estimated = calc_updated_fkm(self.model, self.data, var, self.q_measured, self.calib_config)
            return self._compute_logmap_residuals(self.PEE_measured, estimated, position_frame="world")

    start = time.process_time()
    with contextlib.redirect_stdout(io.StringIO()):
        arm = Arm(pin.RobotWrapper.BuildFromURDF(str(folder / "arm.urdf")), str(config))
        settings = arm.calib_config
        settings["known_baseframe"] = settings["known_tipframe"] = False
        arm.initialize()
        if level == "all+compliances":
            # Named beforehand they would be overwritten by the names of the base's frame.
            settings["param_name"] += _build_elastic_param_names(arm.robot, settings["actJoint_idx"])
            settings["non_geom"] = True
        found, _ = arm.solve_optimisation()
    seconds = time.process_time() - start
    _, commands = PoseObservations.from_csv(str(folder / "test.csv"), arm.model, settings).to_legacy(
        arm.model, settings
    )
    flat = calc_updated_fkm(arm.model, arm.data, found.x, commands, dict(settings, NbSample=len(commands)))
    positions = np.reshape(flat, (task["markers"], 3, len(commands))).transpose(2, 0, 1)
    result = {"positions": positions.tolist(), "parameters": len(found.x), "seconds": seconds}
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")


if __name__ == "__main__":
    main()
