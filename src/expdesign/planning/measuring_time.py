"""How long a plan takes, in the order of the laboratory sheet, without looking for that order.

With deflections, whatever is measured at one pose stands together, and the number of changes does not depend on the
order of the poses: p changes of the pose; without shared references 2m readings and 2m − 1 changes of the load (on and
off around every unloaded reading); with them one more reading for every series, and in every series its distinct loads,
with the load taken off between series, each of which is a setting of the robot. Absolute poses are put in order by
`laboratory_sheet.ordered` where both poses and loads vary.
"""

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.instrument.deflection_noise import series_by_pose
from expdesign.planning.laboratory_sheet import Costs, ordered
from expdesign.planning.plan import Plan


def plan_minutes(plan: Plan, costs: Costs, *, referenced: bool, shared: bool) -> float:
    """Minutes that a plan takes in the best order that is known.

    Args:
        plan: what is measured.
        costs: of changes and readings (min).
        referenced: whether deflections are measured, which need references without load.
        shared: whether measurements at one pose share their reference.
    """
    if not referenced:
        alone = Plan(plan.configurations, plan.loads, series_by_pose(plan.configurations))
        return ordered(alone, costs, referenced=False, shared=False).minutes(costs)
    poses = len(np.unique(plan.configurations, axis=0))
    if not shared:
        return float(minutes_of(costs, poses=poses, load_changes=2 * len(plan) - 1, readings=2 * len(plan)))
    series = len(np.unique(plan.series))
    loads = len(np.unique(np.column_stack([plan.series, plan.loads]), axis=0))
    # Every series is a setting of the robot, also where several are at one pose.
    return float(minutes_of(costs, poses=series, load_changes=loads + series - 1, readings=len(plan) + series))


def most_minutes(
    measurements: IntArray | int, poses: IntArray | int, costs: Costs, *, referenced: bool, shared: bool
) -> FloatArray:
    """Minutes that no plan of m measurements at p settings exceeds in its best order.

    Absolute poses are counted pose by pose, with another load before every reading.
    """
    m, p = np.asarray(measurements), np.asarray(poses)
    if not referenced:
        return minutes_of(costs, poses=p, load_changes=m, readings=m)
    if not shared:
        return minutes_of(costs, poses=p, load_changes=2 * m - 1, readings=2 * m)
    return minutes_of(costs, poses=p, load_changes=m + p - 1, readings=m + p)


def minutes_of(
    costs: Costs, *, poses: IntArray | int, load_changes: IntArray | int, readings: IntArray | int
) -> FloatArray:
    """The time of so many changes and readings (min)."""
    return np.asarray(poses * costs.pose_change + load_changes * costs.mass_change + readings * costs.reading)
