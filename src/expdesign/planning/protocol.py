"""The poses to measure for a plan whose poses are freed of thermal deflection by a reference pose (theory.md 9.H)."""

import numpy as np
import pandas as pd

from expdesign.chain.instrument.deflection_noise import ReferencedNoise
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem


def protocol_frame(problem: DesignProblem, plan: Plan) -> pd.DataFrame | None:
    """Every pose of a plan in the order of measuring, for `expdesign correct` (docs/reference-poses.md).

    Before every pose stands the reference; what is measured is filled in as `measured_x_m …`. None where the
    configuration has no reference pose.
    """
    noise = problem.noise
    if not isinstance(noise, ReferencedNoise):
        return None
    loaded = problem.loaded
    frame = plan_frame(plan, loaded, problem.space.tilts)
    # Without the load its other columns, such as a centre of mass, keep their values and mean nothing.
    effective = [name for name in loaded.load.columns if name == "mass_kg" or name in loaded.robot.coordinates.wrench]
    order = noise.pose_order(plan.series)
    rows = frame.iloc[[row for _, row in order]].reset_index(drop=True)
    kinds = np.array([kind for kind, _ in order])
    rows.loc[kinds != "loaded", effective] = 0.0
    rows.loc[kinds == "reference", list(loaded.robot.configuration)] = noise.reference
    rows["sequence"] = np.arange(1, len(rows) + 1)
    if not noise.shared_reference:
        rows["series"] = [row + 1 for _, row in order]
    rows.insert(2, "kind", np.where(kinds == "reference", "reference", "pose"))
    return rows
