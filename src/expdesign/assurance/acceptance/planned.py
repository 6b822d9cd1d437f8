"""What is expected of a plan before anything is measured, and how many check readings will prove it.

`verify` proves conformity of an axis where |ē| + k·s ≤ T, ē being the mean of n readings and s = σ/√n its standard
uncertainty. Before the experiment the error e is expected within ±k·u_c of 0, and ē within ±k·√(u_c² + s²): with the
probability that the coverage states, conformity is proven where

    k·√(u_c² + s²) + k·s ≤ T,  that is  s ≤ (T² − U²)/(2·k·T).
"""

from dataclasses import replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import NOISE, OWN_PAYLOAD, Contribution, UncertaintyBudget, tolerances
from expdesign.assurance.acceptance.decision import MOST_REPETITIONS, Basis, Decision
from expdesign.assurance.acceptance.repetition import planned_repetitions
from expdesign.chain.models.acting import own_names
from expdesign.estimation.acting_loads import ACTING, own_part
from expdesign.estimation.compensation.target_loads import unit_sources
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import DirectionError, LoadErrorSource
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.information import Information
from expdesign.planning.front import Front
from expdesign.planning.problem import DesignProblem


def planned_decisions(problem: DesignProblem, assessment: Assessment) -> list[Decision]:
    """The decisions on the plans of an assessment."""
    deviations = reading_deviations(problem) if problem.loaded.regressor.referenced else None
    return [
        Decision(budget, Basis.PLAN, check_readings=None if deviations is None else check_readings(budget, deviations))
        for budget in planned_budgets(problem, assessment)
    ]


def planned_budgets(problem: DesignProblem, assessment: Assessment) -> list[UncertaintyBudget]:
    """The budgets of the designs of an assessment, before anything is measured."""
    own, acting = own_payload(problem), acting_loads(problem)
    constant = np.zeros(problem.targets.importance.shape) if own is None else own.deviation**2
    parts = map(assessment.information.part, range(assessment.batch))
    together = zip(parts, assessment.number, planned_repetitions(assessment, acting, constant), strict=True)
    return [
        replace(_budget(problem, information, int(number), own, acting), repetition=repetition)
        for information, number, repetition in together
    ]


def informed_decision(
    problem: DesignProblem, information: Information, measurements: int, degrees: float = float("inf")
) -> Decision:
    """The decision, as of a plan, that rests on what so many measurements say (one set without batch dimensions).

    `degrees` are those of freedom of the noise level, infinite where it is stated.
    """
    own, acting = own_payload(problem), acting_loads(problem)
    return Decision(_budget(problem, information, measurements, own, acting, degrees), Basis.PLAN)


def _budget(
    problem: DesignProblem,
    information: Information,
    measurements: int,
    own: Contribution | None,
    acting: tuple[FloatArray, ...],
    degrees: float = float("inf"),
) -> UncertaintyBudget:
    """Of noise and every source of load error, which do `acting` at the targets, beside the targets' own payloads."""
    noise, load = information.budget(problem.targets.observation, acting)
    names = (source.source for source in problem.loaded.sources)
    sources = (Contribution(name, np.sqrt(part)) for name, part in zip(names, np.moveaxis(load, -1, 0), strict=True))
    return UncertaintyBudget(
        contributions=(Contribution(NOISE, np.sqrt(noise), degrees), *sources, *(() if own is None else (own,))),
        tolerance=tolerances(problem),
        axes=problem.loaded.robot.coordinates.deflection,
        coverage=problem.coverage,
        measurements=measurements,
    )


def acting_loads(problem: DesignProblem) -> tuple[FloatArray, ...]:
    """What shared errors of the load do at the targets, per standard deviation of each source, shape (t, n, d) each.

    The direction of gravity acts at every target, which stands on the same base, errors of the weights where a target
    carries these (`estimation/compensation/target_loads`). An error that every measurement has for itself acts nowhere.
    """
    targets, own, found = problem.targets, problem.own_loads, []
    for source in problem.loaded.sources:
        acts = np.zeros(len(targets.weights), dtype=bool)
        if source.shared and problem.loaded.load.has_mass and source.source in ACTING:
            acts = (
                np.ones_like(acts) if source.source == DirectionError.source else acts if own is None else own.carries
            )
        nothing = np.zeros((*targets.importance.shape, len(source.deviation)))
        found.append(np.where(acts[:, None, None], _moved(problem, source), 0.0) if acts.any() else nothing)
    return tuple(found)


def own_payload(problem: DesignProblem) -> Contribution | None:
    """What is not known of the targets' own payloads, D·L·Σ_δ along the axes of the tolerances.

    No plan shows it (`estimation/compensation/target_loads`), nor what every loading has for itself: a target that
    carries the weights of the experiment has these anew, and every target the direction of gravity. None where all are
    exact.
    """
    loaded, loads = problem.loaded, problem.own_loads
    if loads is None:
        return None
    coordinates, part = loaded.robot.coordinates, own_part(loaded.robot.coordinates)
    own = np.zeros(len(own_names(coordinates)))
    for source in loaded.sources if loaded.load.has_mass else ():
        if not source.shared and source.source in ACTING:
            own[part[source.source]] = np.hypot(own[part[source.source]], source.deviation)
    deviations = loads.apart(own, coordinates)
    if not deviations.any():
        return None
    moved = np.concatenate([_moved(problem, source) for source in unit_sources(coordinates)], axis=-1)
    return Contribution(OWN_PAYLOAD, np.sqrt(((moved * deviations[:, None, :]) ** 2).sum(axis=-1)))


def _moved(problem: DesignProblem, source: LoadErrorSource) -> FloatArray:
    """Change of the poses attained at the targets, per standard deviation of an error of the load there, (t, n, d)."""
    targets = problem.targets
    moved = np.zeros((*targets.importance.shape, len(source.deviation)))
    for here in {id(each): each for each, _ in problem.target_loads}.values():
        inside = np.array([each is here for each, _ in problem.target_loads])
        if source.dimension(here.load) != len(source.deviation):
            continue
        loads = np.array([load for each, load in problem.target_loads if each is here])
        wrong = LoadedRobot(here.robot, here.load, (source,), here.regressor, here.physics, instrument=False)
        measured = wrong.measure(targets.configurations[inside], loads)
        moved[inside] = measured.compliance @ measured.load_errors
    return moved if targets.axes is None else targets.axes @ moved


def with_recommended(problem: DesignProblem, front: Front) -> Front:
    """The front whose recommended design has the least `total` of those expected to pass; of all where none is."""
    passes = np.array([d.robot_passes for d in planned_decisions(problem, problem.assessed(front.decisions))])
    total = front.criteria["total"]
    best = int(np.where(passes, total, np.inf).argmin() if passes.any() else total.argmin())
    return replace(front, recommended=best, passing=int(passes.sum()))


def recommended_acceptance(problem: DesignProblem, front: Front) -> Decision:
    """The decision on the plan of the design that a search recommends."""
    return planned_decisions(problem, problem.assessed(front.decisions[front.recommended][None]))[0]


def reading_deviations(problem: DesignProblem) -> FloatArray:
    """Standard deviation of one reading along the axes of the tolerances, (t, n); NaN where the instrument sees none.

    A tolerance along an axis of the body that turns an axis which is not measured into it is not seen either.
    """
    targets, noise = problem.targets, problem.noise
    pose_map = problem.loaded.robot.jacobians(targets.configurations).pose
    deviations = np.full(targets.importance.shape, np.nan)
    deviations[:, noise.axes] = noise.deviations_at(pose_map)
    if targets.axes is None:
        return deviations
    turned = targets.axes
    parts = np.where(turned != 0.0, (turned * deviations[:, None, :]) ** 2, 0.0)
    found: FloatArray = np.sqrt(parts.sum(axis=2))
    return found


def check_readings(budget: UncertaintyBudget, deviations: FloatArray) -> int:
    """How many independent readings of every target will prove conformity; 0 where no number will.

    Args:
        budget: of the attained pose.
        deviations: standard deviation of one reading along each axis (m, rad), shape (t, n).
    """
    tolerance, expanded, k = budget.tolerance, budget.expanded, budget.coverage.factor
    room = tolerance**2 - expanded**2
    with np.errstate(divide="ignore", invalid="ignore"):
        needed = np.ceil((2.0 * k * tolerance * deviations / room) ** 2 * (1.0 - 1e-12))
    provable = (room > 0.0) & np.isfinite(deviations)
    most = float(np.where(provable, needed, np.inf)[budget.matters].max(initial=1.0))
    return int(most) if most <= MOST_REPETITIONS else 0
