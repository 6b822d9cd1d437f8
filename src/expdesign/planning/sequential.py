"""The next measurements: which would most improve the accuracy at the targets, given what is known (theory.md 10.3).

The recordings and every candidate are `Information`, which is a sum over measurements, so that thousands of candidates
cost one batch. Exchanges and descents along gradients are those of the search for plans, of a problem in which the
recordings are known before.
"""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError
from expdesign.estimation.identify import Identification, fitted_rows, identify
from expdesign.estimation.whitening import LoadColumns, Whitening
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.accuracy import Total, expected_total
from expdesign.planning.criteria.information import RANK_TOLERANCE, Information
from expdesign.planning.optimality.exchange import Exchange
from expdesign.planning.optimality.objectives import Objectives, Pace, descended
from expdesign.planning.problem import DesignProblem
from expdesign.planning.sampling import reachable_measurements
from expdesign.planning.scalarisation import Aims

_PACE = Pace(steps=40, tolerance=1e-7, inner=1e-5)


@dataclass(frozen=True)
class NextMeasurements:
    """Measurements to add, and what they promise.

    Attributes:
        decisions: of the design space, shape (k, g).
        before: expected total error of the recordings alone, in tolerances (infinite where undetermined).
        after: of the recordings with the first 1, 2, ... k of the measurements, shape (k,).
        informed: what the recordings alone say, and with the first 1, 2, ... k of the measurements.
    """

    decisions: FloatArray
    before: float
    after: FloatArray
    informed: tuple[Information, ...]


def next_measurements(
    problem: DesignProblem, known: Information, *, count: int, accuracy: float | None, seed: int
) -> NextMeasurements:
    """Up to `count` measurements that most improve the accuracy at the targets, in the order of their use.

    One at a time from a sample of the design space (greedy), then each in turn replaced by the best candidate for its
    place until none is better (exchange), then along gradients in their continuous variables.

    Args:
        problem: what can be measured, and where accuracy is wanted.
        known: what the recordings say.
        count: the most that may be added.
        accuracy: total error (in tolerances) at which to stop adding; None to add all.
        seed: of the sample.

    Raises:
        InfeasibleError: no measurement is within the robot's limits.
    """
    fewer = min(1.0, 8 / len(problem.loaded.scale))
    pool = reachable_measurements(problem, round(4000 * fewer), np.random.default_rng(seed))
    before = float(expected_total(known, problem.targets))
    decisions = _improved(problem, known, _added(problem, known, pool, count, accuracy)[0], pool)
    # Exchange and descent may reach with fewer what the first choice needed more for.
    decisions, after, informed = _added(problem, known, decisions, len(decisions), accuracy, once=True)
    return NextMeasurements(decisions, before, after, (known, *informed))


def _added(
    problem: DesignProblem,
    known: Information,
    pool: FloatArray,
    count: int,
    accuracy: float | None,
    *,
    once: bool = False,
) -> tuple[FloatArray, FloatArray, list[Information]]:
    """Measurements (k, g) of a pool (l, g), the most useful first, each at most once or again, the totals (k,) and what
    is known with the first 1, 2, ... k of them.
    """
    candidates, left = problem.informed(pool), np.ones(len(pool), dtype=bool)
    chosen: list[int] = []
    after: list[float] = []
    informed: list[Information] = []
    while len(chosen) < count and not (after and accuracy is not None and after[-1] <= accuracy):
        together = known.plus(candidates)
        reached = scores = expected_total(together, problem.targets)
        if not np.isfinite(scores).any():
            # Too little is known for any single one to determine all: take what adds most information.
            scores = -_determinant(together.in_units(problem.loaded.scale))
        best = int(np.argmin(np.where(left, scores, np.inf)))
        known = together.part(best)
        left[best] = not once
        chosen.append(best)
        after.append(float(reached[best]))
        informed.append(known)
    return pool[chosen], np.array(after), informed


def _determinant(information: Information) -> FloatArray:
    """Product of the non-zero singular values, in logarithms, of a batch; more rank comes first."""
    singular = np.linalg.svd(information.root, compute_uv=False)
    kept = singular > RANK_TOLERANCE * singular[..., :1]
    logs: FloatArray = np.where(kept, np.log(np.where(kept, singular, 1.0)) + 1e3, 0.0).sum(axis=-1)
    return logs


def _improved(problem: DesignProblem, known: Information, decisions: FloatArray, pool: FloatArray) -> FloatArray:
    """Measurements (k, g) after exchange with the pool and descent, in turn as long as that helps."""
    space = problem.space.alone()
    space.measurements = len(decisions)
    here = replace(problem, space=space, objectives=(Total(),), known=known, noise=problem.noise.alone())
    objectives, exchange = Objectives(here), Exchange(here, ("total",))
    best, least = decisions, np.inf
    for _ in range(6):
        # Ends of ranges and other poses may be beyond the robot's limits, from which a descent may come back.
        tried = np.concatenate(
            [exchange.singles(best[None], Aims.of_one(1), pool, varied=varied) for varied in (False, True)]
        )
        if objectives.smooth:
            tried = np.concatenate([tried, descended(objectives, tried, Aims.of_one(2), _PACE)])
        values = np.nan_to_num(objectives.values(here.assessed(tried))[:, 0], nan=np.inf)
        values[~problem.loaded.robot.usable(space.decode(tried)[0]).all(axis=1)] = np.inf
        reached = int(values.argmin())
        if not values[reached] < (1.0 - 1e-4) * least:
            break
        best, least = tried[reached], float(values[reached])
    return best


def recorded_knowledge(
    problem: DesignProblem, recordings: Recordings, loads: FloatArray | None, found: Identification | None
) -> Information:
    """Information and load errors of recordings.

    Standard deviations are those of the recordings; where they state none those that are estimated, or, where the
    recordings are too few for that, those of the configuration.

    Args:
        problem: the robot and its sources of load error.
        recordings: what was measured; rows held out for testing do not count.
        loads: load parameters of every row (N, k) in the order of the recordings; None where there are no load errors.
        found: what the recordings identify (`identified_so_far`), or None.

    Raises:
        InputError: the noise is not known.
    """
    loaded, robot = problem.loaded, problem.loaded.robot
    fitted = fitted_rows(recordings)
    train = recordings.rows(fitted)
    deviations = train.deviations
    if deviations is None:
        deviations = _configured_deviations(problem, train) if found is None else found.noise.deviations
    jacobians = robot.jacobians(train.configurations)
    measured = loaded.under(Wrench(robot.coordinates)).measure(train.configurations, train.wrenches)
    wrenches: tuple[FloatArray, ...] = ()
    if loads is not None:
        wrenches = loaded.load_errors(jacobians.rotation, loads[fitted])
    columns = [measured.observation, *(measured.compliance @ error for error in wrenches)]
    rows, *errors = (each[:, train.axes] for each in columns)
    shared = tuple(source.shared for source in loaded.sources) if errors else ()
    own = [each for each, common in zip(errors, shared, strict=True) if not common]
    weighed = LoadColumns(rows[..., :0], np.concatenate([rows[..., :0], *own], axis=-1))
    whitening = Whitening(
        deviations,
        references=train.references,
        within=train.within,
        loads=weighed if problem.estimator == "generalised" else None,
    )
    size = deviations.size
    across = whitening.decorrelated(np.eye(size).reshape(*deviations.shape, size)).reshape(size, size)
    scaled = [each / deviations[..., None] for each in (rows, *errors)]
    return Information.of_measurements(scaled[0], tuple(scaled[1:]), shared, across, estimator=problem.estimator)


def require_readings_of(problem: DesignProblem, recordings: Recordings) -> None:
    """Raise where the recordings are not of what the configuration calibrates: poses for geometry, else deflections.

    Raises:
        InputError: which columns are missing.
    """
    geometry = not problem.loaded.regressor.referenced
    if geometry == recordings.poses:
        return
    wanted, columns = ("measured poses", "measured_x_m ...") if geometry else ("deflections", "dx_m ...")
    what = f"the configuration calibrates the {problem.loaded.regressor.noun}, and these are no {wanted}"
    remedy = f"Give {wanted} (columns {columns}), or change `experiment.calibration`."
    raise InputError(what, where=recordings.source, remedy=remedy)


def identified_so_far(problem: DesignProblem, recordings: Recordings) -> Identification:
    """What the recordings identify of what the configuration calibrates; raises as `identify` does."""
    regressor = problem.loaded.regressor
    known = regressor.redundant == 0
    return identify(
        problem.loaded.robot,
        recordings,
        calibration=regressor.calibration,
        frames_known=known,
        load_errors=problem.load_errors,
        estimator=problem.estimator,
    )


def _configured_deviations(problem: DesignProblem, recordings: Recordings) -> FloatArray:
    """The configuration's standard deviations of every reading."""
    stated = dict(zip(problem.noise.axes.tolist(), np.sqrt(np.diag(problem.noise.covariance)), strict=True))
    missing = [axis for axis in recordings.axes.tolist() if axis not in stated]
    if missing:
        name = problem.loaded.robot.coordinates.deviation[missing[0]]
        what = "the standard deviation is neither stated nor in the configuration, and cannot be estimated"
        raise InputError(what, where=f"{recordings.source}, column {name}", remedy="Add the column.")
    return np.tile([stated[axis] for axis in recordings.axes.tolist()], (len(recordings), 1))
