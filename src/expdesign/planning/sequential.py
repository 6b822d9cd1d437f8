"""The next measurements: which would most improve the accuracy at the targets, given what is known (theory.md 10.3).

The recordings and every candidate are `Information`, which is a sum over measurements, so that thousands of candidates
cost one batch.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import Recordings
from expdesign.errors import InputError, NotIdentifiableError
from expdesign.estimation.identify import Identification, fitted_rows, identify
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.loads.load import Wrench
from expdesign.planning.criteria.accuracy import Total
from expdesign.planning.criteria.information import RANK, Information
from expdesign.planning.criteria.target_variances import GivenVariances
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.problem import DesignProblem
from expdesign.planning.start import reachable_measurements

CANDIDATES = 4000
_FEW = 8
"""Parameters up to which as many candidates are drawn; more of them cost more each, and are drawn fewer times."""
_ROUNDS = 10
_BROOD, _STEPS = 200, 40


def information_of(problem: DesignProblem, decisions: FloatArray) -> Information:
    """What each of the measurements (c, g) of the design space would say by itself, batch shape (c,)."""
    rows, errors = problem.whitened(*problem.space.decode(decisions))
    return Information.of_rows(rows * problem.loaded.scale, errors, problem.shared_errors)


def expected_total(information: Information, targets: Targets, scale: FloatArray) -> FloatArray:
    """√total² of a batch, in tolerances, shape (...); infinite where a target depends on parameters not determined.

    Args:
        information: of all measurements.
        targets: where accuracy is wanted.
        scale: units of the parameters in `information`, shape (p,).
    """
    noise, force, known = information.variances(targets.observation * scale)
    usable = (known | ~(targets.importance > 0.0)).all(axis=(-2, -1))
    total = Total().values(GivenVariances(targets, noise, force))
    result: FloatArray = np.where(usable, total, np.inf)
    return result


@dataclass(frozen=True)
class NextMeasurements:
    """Measurements to add, and what they promise.

    Attributes:
        decisions: of the design space, shape (k, g).
        before: expected total error of the recordings alone, in tolerances (infinite where undetermined).
        after: of the recordings with the first 1, 2, ... k of the measurements, shape (k,).
    """

    decisions: FloatArray
    before: float
    after: FloatArray


def next_measurements(
    problem: DesignProblem, known: Information, *, count: int, accuracy: float | None, seed: int
) -> NextMeasurements:
    """Up to `count` measurements that most improve the accuracy at the targets, in the order of their use.

    One at a time from a sample of the design space (greedy), then each in turn replaced by the best candidate for its
    place until none is better (exchange), then refined in their continuous variables.

    Args:
        problem: what can be measured, and where accuracy is wanted.
        known: what the recordings say.
        count: the most that may be added.
        accuracy: total error (in tolerances) at which to stop adding; None to add all.
        seed: of the sample.

    Raises:
        InfeasibleError: no measurement is within the robot's limits.
    """
    generator = np.random.default_rng(seed)
    pool = reachable_measurements(problem, round(CANDIDATES * _fewer(problem)), generator)
    candidates = information_of(problem, pool)
    scale, targets = problem.loaded.scale, problem.targets

    def totals(base: Information, added: Information) -> FloatArray:
        return expected_total(base.plus(added), targets, scale)

    before = float(expected_total(known, targets, scale))
    chosen: list[FloatArray] = []
    base = known
    while len(chosen) < count:
        scores = totals(base, candidates)
        if not np.isfinite(scores).any():
            # Too little is known for any single one to determine all: take what adds most information.
            scores = -_determinant(base.plus(candidates))
        best = int(np.argmin(scores))
        chosen.append(pool[best])
        base = base.plus(candidates.part(best))
        if accuracy is not None and float(expected_total(base, targets, scale)) <= accuracy:
            break
    decisions = _exchanged(problem, known, np.array(chosen), pool, candidates, generator)
    decisions = _ordered(problem, known, decisions)
    after, base = [], known
    for row in decisions:
        base = base.plus(information_of(problem, row[None]).part(0))
        after.append(float(expected_total(base, targets, scale)))
        if accuracy is not None and after[-1] <= accuracy:
            # Exchange and refinement may reach with fewer what the first choice needed more for.
            break
    return NextMeasurements(decisions[: len(after)], before, np.array(after))


def _fewer(problem: DesignProblem) -> float:
    """Share of the usual number of candidates."""
    return min(1.0, _FEW / len(problem.loaded.scale))


def _determinant(information: Information) -> FloatArray:
    """Product of the non-zero singular values, in logarithms, of a batch; more rank comes first."""
    singular = np.linalg.svd(information.root, compute_uv=False)
    kept = singular > RANK * singular[..., :1]
    logs: FloatArray = np.where(kept, np.log(np.where(kept, singular, 1.0)) + 1e3, 0.0).sum(axis=-1)
    return logs


def _exchanged(
    problem: DesignProblem,
    known: Information,
    decisions: FloatArray,
    pool: FloatArray,
    candidates: Information,
    generator: np.random.Generator,
) -> FloatArray:
    """Measurements (k, g) after exchange with the pool and refinement of the continuous variables."""
    scale, targets, space = problem.loaded.scale, problem.targets, problem.space
    robot = problem.loaded.robot
    decisions = decisions.copy()

    def others(place: int) -> Information:
        rest = np.delete(decisions, place, axis=0)
        if len(rest) == 0:
            return known
        each, total = information_of(problem, rest), known
        for index in range(len(rest)):
            total = total.plus(each.part(index))
        return total

    def score(base: Information, place: int) -> float:
        return float(expected_total(base.plus(information_of(problem, decisions[place][None]).part(0)), targets, scale))

    for _ in range(_ROUNDS if len(decisions) > 1 else 1):
        improved = False
        for place in range(len(decisions)):
            base = others(place)
            now = score(base, place)
            scores = expected_total(base.plus(candidates), targets, scale)
            best = int(np.argmin(scores))
            if scores[best] < now * (1.0 - 1e-9):
                decisions[place], improved = pool[best], True
        if not improved:
            break
    span = (space.upper - space.lower) * ~space.discrete
    brood_size = round(_BROOD * _fewer(problem))
    for place in range(len(decisions)):
        base, size = others(place), 0.1
        now = score(base, place)
        for _ in range(_STEPS if span.any() else 0):
            moves = generator.standard_normal((brood_size, space.decisions)) * size * span
            brood = np.clip(decisions[place] + moves, space.lower, space.upper)
            brood = brood[robot.usable(space.decode(brood)[0])]
            scores = expected_total(base.plus(information_of(problem, brood)), targets, scale)
            size *= 1.2 if len(brood) and (scores < now).mean() > 0.1 else 0.7
            if len(brood) and scores.min() < now:
                decisions[place], now = brood[int(np.argmin(scores))], float(scores.min())
    return decisions


def _ordered(problem: DesignProblem, known: Information, decisions: FloatArray) -> FloatArray:
    """The same measurements, the most useful first."""
    scale, targets = problem.loaded.scale, problem.targets
    left, ordered, base = list(range(len(decisions))), [], known
    each = information_of(problem, decisions)
    while left:
        scores = [float(expected_total(base.plus(each.part(i)), targets, scale)) for i in left]
        best = left.pop(int(np.argmin(scores)))
        ordered.append(best)
        base = base.plus(each.part(best))
    return decisions[ordered]


def recorded_knowledge(problem: DesignProblem, recordings: Recordings, loads: FloatArray | None) -> Information:
    """Information and load errors of recordings.

    Standard deviations are those of the recordings; where they state none they are estimated, or, where the recordings
    are too few for that, those of the configuration.

    Args:
        problem: the robot and its sources of load error.
        recordings: what was measured; rows held out for testing do not count.
        loads: load parameters of every row (N, k) in the order of the recordings; None where there are no load errors.

    Raises:
        InputError: the noise is not known.
    """
    loaded, robot = problem.loaded, problem.loaded.robot
    fitted = fitted_rows(recordings)
    train = recordings.rows(fitted)
    deviations = train.deviations if train.deviations is not None else estimated_deviations(problem, recordings, train)
    whitening = Whitening(deviations, references=train.references)
    jacobians = robot.jacobians(train.configurations)
    measured = loaded.under(Wrench(robot.coordinates)).measure(train.configurations, train.wrenches)
    observation = measured.observation[:, train.axes] * loaded.scale
    rows = whitening.apply(observation)
    count = rows.shape[-1]
    # The whitening of the readings, transposed, so that every row's load error meets all that it is whitened with.
    gain = whitening.apply(rows * deviations[..., None]) / deviations[..., None]
    own = np.zeros((count, count))
    common = [np.zeros((count, 0))]
    if loads is not None:
        for source, error in zip(loaded.sources, loaded.wrenches(jacobians.rotation, loads[fitted])[1], strict=True):
            moved = (measured.compliance @ error)[:, train.axes]
            seen = gain.swapaxes(-1, -2) @ moved
            if source.shared:
                common.append(seen.sum(axis=0))
            else:
                flat = seen.swapaxes(0, 1).reshape(count, -1)
                own += flat @ flat.T
    root = rows.reshape(-1, count)
    if len(root) > count:
        root = np.asarray(np.linalg.qr(root, mode="r"))
    return Information(root, np.concatenate(common, axis=-1), own)


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
    return identify(problem.loaded.robot, recordings, calibration=regressor.calibration, frames_known=known)


def estimated_deviations(problem: DesignProblem, recordings: Recordings, train: Recordings) -> FloatArray:
    """Estimated standard deviations, or those of the configuration."""
    try:
        return identified_so_far(problem, recordings).noise.deviations
    except NotIdentifiableError:
        pass
    stated = dict(zip(problem.noise.axes.tolist(), np.sqrt(np.diag(problem.noise.covariance)), strict=True))
    missing = [axis for axis in train.axes.tolist() if axis not in stated]
    if missing:
        name = problem.loaded.robot.coordinates.deviation[missing[0]]
        what = "the standard deviation is neither stated nor in the configuration, and cannot be estimated"
        raise InputError(what, where=f"{recordings.source}, column {name}", remedy="Add the column.")
    return np.tile([stated[axis] for axis in train.axes.tolist()], (len(train), 1))
