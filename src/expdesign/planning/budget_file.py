"""`experiment.budget`, `experiment.costs` and `experiment.validation` of a run configuration, read."""

from expdesign.errors import InputError
from expdesign.io.yaml_reader import KeyPath, YamlDocument
from expdesign.planning.budget import LARGEST, Budget, Structure
from expdesign.planning.laboratory_sheet import Costs
from expdesign.planning.schema import ExperimentSection

_WHERE: KeyPath = ("experiment", "budget")


def read_costs(experiment: ExperimentSection) -> Costs | None:
    """What measuring costs, or None where nothing is said."""
    stated = experiment.costs
    return None if stated is None else Costs(stated.pose_change, stated.mass_change, stated.reading)


def read_budget(experiment: ExperimentSection, referenced: bool, document: YamlDocument) -> Budget | None:
    """The budget, or None where there is a number of measurements.

    Args:
        experiment: as configured.
        referenced: whether deflections are measured, which need references without load.
        document: for messages.

    Raises:
        InputError: neither a budget nor a number is given, costs are missing, or not one measurement fits.
    """
    section, costs = experiment.budget, read_costs(experiment)
    if section is None:
        if experiment.measurements is None:
            where = document.where(("experiment", "measurements"))
            raise InputError("the key is missing", where=where, remedy="Add it, or a `budget` with `costs`.")
        return None
    if costs is None or not costs.known:
        what = "a budget says nothing where measuring costs nothing"
        remedy = "Add `experiment.costs`, e.g. `{pose_change: 2, mass_change: 10, reading: 0.5}` (min)."
        raise InputError(what, where=document.where(_WHERE), remedy=remedy)
    if experiment.reference_pose is not None:
        what = "with a reference pose every pose stands between references, which a budget does not count"
        where = document.where(_WHERE)
        raise InputError(what, where=where, remedy="Give a number of `measurements`.")
    constraints = experiment.constraints
    least = Structure(1, 1)
    if constraints is not None:
        poses = max(constraints.distinct_poses, len(constraints.poses), 1)
        least = Structure(max(poses, constraints.distinct_masses, len(constraints.masses_kg)), poses)
    budget = Budget(
        minutes=section.minutes,
        costs=costs,
        referenced=referenced,
        shared=experiment.deflection_noise.shared_reference,
        validation=0 if experiment.validation is None else experiment.validation.measurements,
        least=least,
        most=experiment.measurements,
        poses=section.distinct_poses,
    )
    _require_structure(budget, document)
    return budget


def _require_structure(budget: Budget, document: YamlDocument) -> None:
    where = document.where((*_WHERE, "minutes"))
    if budget.largest:
        if budget.largest > LARGEST and budget.most is None:
            what = f"the budget allows more than {LARGEST} measurements"
            remedy = "Add `experiment.measurements` as the largest number, or a cost of each reading."
            raise InputError(what, where=where, remedy=remedy)
        return
    least = budget.least
    needed = float(budget.minutes_of(least.measurements, least.poses))
    limits = [("measurements", budget.most, least.measurements), ("distinct_poses", budget.poses, least.poses)]
    for name, limit, wanted in limits:
        if limit is not None and limit < wanted:
            what = f"`{name}` allows {limit}, and `constraints` demand {wanted}"
            raise InputError(what, where=document.where(_WHERE), remedy="Allow more, or demand less.")
    smallest = "one measurement" if least == Structure(1, 1) else f"the {least.measurements} measurements demanded"
    more = f" and the {budget.validation} for validation" if budget.validation else ""
    what = f"{budget.minutes:g} min are too little for {smallest}{more}, which takes {needed:g} min by `costs`"
    raise InputError(what, where=where, remedy=f"Allow at least {needed:g} min, or correct `costs`.")
