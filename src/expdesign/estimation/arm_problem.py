"""The fitted rows of an arm's calibration, and which of its parameters they are fitted by."""

from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.instrument.frame import FrameWander
from expdesign.chain.effects.joints.geometry import CalibratedGeometryError
from expdesign.chain.effects.joints.readings import JointHarmonics
from expdesign.chain.effects.links.links import LinkMassError
from expdesign.chain.effects.load.payload import UnknownTool
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.chain.row import RowData, row_data
from expdesign.estimation.arm_options import Held
from expdesign.estimation.groups import Priors, Sized
from expdesign.estimation.remarks import BeyondManufacture, BlindPoses
from expdesign.mechanics.minimal_set import MinimalSet, minimal_set

GROUPS = ("zeros", "lengths", "angles", "compliances", "harmonics", "masses", "shifts", "turns")
"""Errors of one kind, which have one variance."""
_ZEROS, _LENGTHS, _ANGLES, _COMPLIANCES, _HARMONICS, _MASSES, _SHIFTS, _TURNS = range(len(GROUPS))
_UNITS = ("rad", "m", "rad", "relative", "rad", "relative", "m", "rad")
LENGTH, ANGLE = 8e-4, 3e-3
"""m, rad; with which frames of joints are made: the limit for 400 to 1000 mm in ISO 2768-1, class m, and half the limit
(20') for sides of 50 to 120 mm there."""
_ZERO, _ZERO_LENGTH = 1e-2, 2e-3
"""rad, m; of zeros of revolute joints (mastering by marks reaches some tenths of a degree) and of prismatic ones."""
_COMPLIANCE = 3.0
"""Of a joint, in units of the robot file's, whose order of magnitude is all that is taken as known."""
_TOOL_MASS, _TOOL_MOMENT = 2.0, 0.3
"""kg, kg·m; of what rides on a tip: a gripper, and its first moments at 0.15 m."""
_SPREAD = 2.3
"""Standard deviation of the logarithm of a factor on these sizes beforehand: ten times better or worse is usual."""
_BEYOND = 5.0
"""Deviations of manufacture beyond which the drawing is of another machine, or the correction holds something else."""
_REDUNDANT = 1e-7
"""Part of a column, orthogonal to the columns before it, below which rows do not tell parameters apart: rounding of
exact derivatives, squared by no normal equation."""
_MANY = 60
"""Rows from which poses at random tell apart whatever poses can."""
_SEED = 1


@dataclass(frozen=True)
class Level:
    """The size of one group of errors, as the rows decided it.

    Attributes:
        name: of the group (`GROUPS`).
        unit: `rad`, `m` or `relative` (of compliances and masses).
        made: standard deviation with which such things are made.
        size: the one that the rows ask for; 0 where the group is held.
        count: parameters that were identified.
        determined: how many of them the rows determine, the rest being at the drawing.
    """

    name: str
    unit: str
    made: float
    size: float
    count: int
    determined: float


def levels_of(sizes: FloatArray, kinds: IntArray, live: IntArray, solution: Sized) -> list[Level]:
    """Of all groups of a chain's parameters with sizes and kinds (p,), of which those `live` were fitted."""
    levels = []
    for kind in np.unique(kinds[kinds >= 0]).tolist():
        made, count = float(np.median(sizes[kinds == kind])), int((kinds[live] == kind).sum())
        size, shown = made * float(solution.factors[kind]) * (count > 0), float(solution.determined[kind])
        levels.append(Level(GROUPS[kind], _UNITS[kind], made, size, count, shown))
    return levels


@dataclass(frozen=True)
class ArmProblem:
    """The fitted rows; parameters outside `live` stay as they are."""

    chain: Chain
    train: Recordings
    rows: RowData
    live: IntArray

    @property
    def seen(self) -> BoolArray:
        """Which components were read, shape (N, k)."""
        return np.isfinite(self.train.deflections)

    def linearised(
        self, values: FloatArray, deviations: FloatArray, start: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Whitened residuals (M,) and derivatives (M, live) of what was read, at values of `live`."""
        whole = start.copy()
        whole[self.live] = values
        predicted, slopes = self.chain.predict_with_sensitivities(self.rows, whole)
        axes, seen = self.train.axes, self.seen
        residuals = ((self.train.deflections - predicted[:, axes]) / deviations)[seen]
        return residuals, slopes[:, axes][seen][:, self.live] / deviations[seen][:, None]


def sizes_of(chain: Chain) -> tuple[FloatArray, IntArray]:
    """Standard deviations beforehand (p,), and the kind of every parameter, −1 for those without a factor."""
    sizes = np.array([parameter.spread for parameter in chain.parameters])
    kinds = np.full(len(sizes), -1, dtype=np.int64)
    sizes[: chain.compliances], kinds[: chain.compliances] = _COMPLIANCE, _COMPLIANCES
    for effect, part in zip(chain.effects, chain.slices, strict=True):
        if not isinstance(effect, CalibratedGeometryError):
            sizes[part], kinds[part] = _further_sizes(effect)
            continue
        for index, parameter in zip(range(part.start, part.stop), effect.parameters, strict=True):
            angle = parameter.name.endswith("_rad")
            if "_offset_" in parameter.name:
                sizes[index], kinds[index] = (_ZERO if angle else _ZERO_LENGTH), _ZEROS
            else:
                sizes[index] = ANGLE if angle else LENGTH
                kinds[index] = _ANGLES if angle else _LENGTHS
    return sizes, kinds


def _further_sizes(effect: Effect) -> tuple[FloatArray, IntArray]:
    """The same of what is identified on request."""
    names = [parameter.name for parameter in effect.parameters]
    sizes = np.array([parameter.spread for parameter in effect.parameters])
    kinds = np.full(len(names), -1, dtype=np.int64)
    if isinstance(effect, UnknownTool):
        sizes = np.array([_TOOL_MASS if "mass" in name else _TOOL_MOMENT for name in names])
    elif isinstance(effect, JointHarmonics):
        kinds[:] = _HARMONICS
    elif isinstance(effect, LinkMassError):
        kinds[:] = _MASSES
    elif isinstance(effect, FrameWander):
        kinds = np.array([_SHIFTS if name.startswith("shift") else _TURNS for name in names])
    return sizes, kinds


def chosen_set(problem: ArmProblem, sizes: FloatArray, hold: tuple[Held, ...], *, compliances: bool) -> MinimalSet:
    """A minimal complete set: instrument and markers, then zeros, lengths and angles along the chain, unless held.

    It is that of rigid kinematics, since sag tells parameters apart by less than it is known. Compliances and what is
    identified on request, of which each has a meaning of its own and a deviation beforehand, are all kept.
    """
    chain = problem.chain
    rigid = chain.start()
    rigid[: chain.compliances] = 0.0
    _, slopes = problem.linearised(rigid, np.ones_like(problem.train.deflections), rigid)
    scale = np.where(np.isfinite(sizes), sizes, 1.0)
    kept = np.arange(chain.compliances, chain.base)
    names = [parameter.name for parameter in chain.parameters]
    parts = list(zip(chain.effects, chain.slices, strict=True))
    every = np.arange(len(sizes))
    geometry = np.concatenate([every[:0], *(every[p] for e, p in parts if isinstance(e, CalibratedGeometryError))])
    further = np.concatenate([every[:0], *(every[p] for e, p in parts if not isinstance(e, CalibratedGeometryError))])
    rank = [(_ANGLES if n.endswith("_rad") else _LENGTHS) if "_offset_" not in n else _ZEROS for n in names]
    free = [kind for kind in range(3) if GROUPS[kind] not in hold]
    order = np.concatenate([kept, *(geometry[[rank[i] == kind for i in geometry]] for kind in free)]).astype(int)
    found = minimal_set(slopes * scale, order, _REDUNDANT)
    units = found.combinations * scale[found.kept] / scale[found.dropped][:, None]
    found = replace(found, combinations=units)
    own = every[: chain.compliances] if compliances else every[:0]
    none = [np.zeros((len(found.dropped), len(each))) for each in (own, further)]
    wider = np.hstack([none[0], found.combinations, none[1]])
    return MinimalSet(np.concatenate([own, found.kept, further]), found.dropped, wider)


def blind_poses(
    problem: ArmProblem, minimal: MinimalSet, labels: list[str], sizes: FloatArray, hold: tuple[Held, ...]
) -> list[Remark]:
    """What any poses would tell apart and these do not."""
    if not any(isinstance(effect, CalibratedGeometryError) for effect in problem.chain.effects):
        return []
    random, robot = np.random.default_rng(_SEED), problem.chain.robot
    train = problem.train.rows(np.resize(np.arange(len(problem.train)), max(_MANY, len(problem.train))))
    configurations = train.configurations.copy()
    joints = len(robot.stiffness)
    configurations[:, :joints] += random.uniform(-1.0, 1.0, (len(train), joints))
    spread = replace(train, configurations=configurations)
    every = np.arange(len(sizes))
    wide = ArmProblem(problem.chain, spread, row_data(spread, robot), every)
    structural = chosen_set(wide, sizes, hold, compliances=False)
    lost = [labels[index] for index in minimal.dropped if index not in structural.dropped]
    return [BlindPoses(tuple(lost))] if lost else []


def beyond_manufacture(
    chain: Chain, values: FloatArray, minimal: MinimalSet, sizes: FloatArray, labels: list[str]
) -> list[Remark]:
    """Corrections of the geometry beyond what machines are made with, those that they stand for included.

    Args:
        chain: of the fit.
        values: of its parameters, shape (p,).
        minimal: which of them were identified.
        sizes: their standard deviations in manufacture, shape (p,).
        labels: their names, for people.
    """
    limits, every = minimal.widened(sizes), np.arange(len(values))
    geometry = [every[part] for effect, part in zip(chain.effects, chain.slices, strict=True)
                if isinstance(effect, CalibratedGeometryError)]  # fmt: skip
    own = np.intersect1d(np.concatenate([every[:0], *geometry]), minimal.kept)
    far = own[np.abs(values[own]) > _BEYOND * limits[own]]
    if not len(far):
        return []
    far = far[np.argsort(-np.abs(values[far]) / limits[far])]
    return [BeyondManufacture(
        tuple(labels[index] for index in far), tuple(values[far].tolist()), tuple(limits[far].tolist()),
        tuple(chain.parameters[index].name.endswith("_rad") for index in far),
    )]  # fmt: skip


def priors_of(chain: Chain, sizes: FloatArray, kinds: IntArray, live: IntArray) -> Priors:
    """What is known beforehand of the parameters `live`, from deviations and kinds (p,) of all."""
    mean = np.array([parameter.neutral for parameter in chain.parameters])
    low, high = chain.bounds()
    return Priors(mean[live], sizes[live], kinds[live], low[live], high[live], len(GROUPS), _SPREAD)
