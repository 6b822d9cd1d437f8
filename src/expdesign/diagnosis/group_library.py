"""Which groups of effects and laws recordings could show, with the sizes that their members have beforehand."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import FloatArray, rms
from expdesign.chain.component import ALL_JOINTS, BASE, GEOMETRY, Component, Part
from expdesign.chain.declaration import Beyond
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.ports.port import Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.evidence.dictionary import Atom, Dictionary
from expdesign.diagnosis.evidence.state import Present, base_alone
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True, eq=False)
class Group:
    """Effects or laws of one kind, with one size.

    Attributes:
        name: in words.
        physics: identifier, or `law`.
        component: where it acts; all joints or the geometry where its members act at several.
        form: of laws, a key of `words.FORMS`; empty for effects of known form.
        directions: whitened derivatives of the readings that count with respect to its weights, of which as many as
            there are readings have unit mean square in all, shape (M, f).
        scales: parameters of the members for weights of 1, shape (f,).
        members: effect and number of the parameter of each weight; empty for laws.
        atoms: laws.
    """

    name: str
    physics: str
    component: Component
    form: str
    directions: FloatArray
    scales: FloatArray
    members: tuple[tuple[Effect, int], ...] = ()
    atoms: tuple[Atom, ...] = ()

    @property
    def end(self) -> Quantity | None:
        """What laws of guides are multiplied by."""
        return _end(_entry(self.atoms[0])) if self.atoms else None

    @property
    def goes_on(self) -> bool:
        """Whether it depends on time or remembers, so that it goes on after the last row."""
        seen = [quantity for atom in self.atoms for quantity in _entry(atom).quantities]
        return any(quantity.states or quantity.drifts or quantity.kind == "settling" for quantity in seen)

    @property
    def kind(self) -> tuple[Component, str]:
        """What people would call it; laws of guides that end elsewhere are of one kind."""
        return self.component, self.form or self.name

    @property
    def width(self) -> int:
        """Number of weights."""
        return self.directions.shape[1]


@dataclass(frozen=True)
class GroupLibrary:
    """Groups that recordings could show, and what their laws see."""

    groups: tuple[Group, ...]
    sight: Sight

    @property
    def lasting(self) -> "GroupLibrary":
        """The same without laws of time and memory."""
        return replace(self, groups=tuple(group for group in self.groups if not group.goes_on))


def groups_of(robot: Robot, sample: Data, base: Fit, library: Sequence[Candidate]) -> GroupLibrary:
    """All groups: what a body stands on, or parts of an arm and laws of its joints.

    Args:
        robot: the robot.
        sample: the rows that may be fitted.
        base: fit of the base model.
        library: named physics.
    """
    ports = ("supports",) if robot.on_support else ("joints",)
    dictionary = Dictionary(robot, sample, base.values, only=ports)
    present = base_alone(base, sample, known_noise=False)
    laws = _laws_of_supports(dictionary) if robot.on_support else _laws_of_joints(dictionary)
    names = [] if robot.on_support else _named(sample, rms(present.readings), library)
    return GroupLibrary((*names, *_few_ends(laws, present)), dictionary.sight)


def _laws_of_supports(dictionary: Dictionary) -> list[Group]:
    """Laws of one form, kernel, scale and guide's end, of every measured axis."""
    kinds: dict[Hashable, list[Atom]] = {}
    for atom in dictionary.atoms:
        entry = _entry(atom)
        scale = entry.scales if entry.kernel == "matern" else None
        kinds.setdefault((entry.form, entry.kernel, scale, _end(entry)), []).append(atom)
    return [_of_laws(_entry(atoms[0]).form, BASE, atoms) for atoms in kinds.values()]


def _laws_of_joints(dictionary: Dictionary) -> list[Group]:
    """Smooth laws of every joint.

    Of sliding joints, whose guides overlap more or less: compliances and motions that change with the place as smoothly
    as the dictionary has them, motions that follow the moments that the guides carry, with kinks where these change
    sides (Wiener processes), and tilts of guides. Of revolute joints: what repeats with every turn.
    """
    atoms = [atom for atom in dictionary.atoms if not atom.component.several]
    turning = {atom.component for atom in atoms if _entry(atom).kernel == "periodic"}
    widest: dict[Component, float] = {}
    for atom in atoms:
        if _smooth(atom):
            widest[atom.component] = max(widest.get(atom.component, 0.0), _entry(atom).scales[0])
    found = []
    for atom in atoms:
        entry, where = _entry(atom), atom.component
        if where in turning:
            wanted = entry.kernel == "periodic"
        else:
            smooth = _smooth(atom) and entry.scales[0] == widest[where]
            kinks = entry.kernel == "wiener" and entry.inputs[0].kind == "joint_moment"
            wanted = smooth or kinks or entry.form == "guide"
        if wanted:
            seen = {"guide": "tilt of its guide"}.get(entry.form)
            what = seen or f"{entry.form} of its {'place' if entry.inputs[0].kind == 'length' else 'moments'}"
            found.append(_of_laws(f"{where}, {what}", where, [atom]))
    return found


def _few_ends(groups: list[Group], present: Present) -> list[Group]:
    """Of the ends that guides may have those that explain most beside a law of the load, and one length of the latter.

    They are judged by the evidence of laws of a size that the misfit allows, with noise of a share of it: what matters
    is how a tilt grows with what is drawn out, which no other law can make up for.
    """
    level = OPTIONS.listed * rms(present.readings) or 1.0
    quiet = replace(present, base=present.base / level, readings=present.readings / level, known_noise=True)
    size = OPTIONS.listed**-2

    def with_loads(state: Present) -> tuple[float, Group | None]:
        trials = [(state.beside(group.directions, size).log_evidence, group) for group in loads]
        return max(trials, key=lambda trial: trial[0], default=(state.log_evidence, None))

    loads = [group for group in groups if group.form == "force law" and group.component == BASE]
    wanted: set[Hashable] = set()
    best: tuple[float, Group | None] = with_loads(quiet)
    for where in dict.fromkeys(group.component for group in groups):
        guides = [group for group in groups if group.form == "guide" and group.component == where]
        judged = [(*with_loads(quiet.beside(group.directions, size)), group) for group in guides]
        judged.sort(key=lambda trial: -trial[0])
        best = max([best, *(trial[:2] for trial in judged[:1])], key=lambda trial: trial[0])
        wanted |= {(where, group.end) for _, _, group in judged[: OPTIONS.each]}
    groups = [group for group in groups if group not in loads or group is best[1]]
    return [group for group in groups if group.end is None or (group.component, group.end) in wanted]


def _smooth(atom: Atom) -> bool:
    entry = _entry(atom)
    return entry.kernel == "squared_exponential" and len(entry.inputs) == 1 and entry.inputs[0].kind == "length"


def _entry(atom: Atom) -> Entry:
    assert atom.entry is not None
    return atom.entry


def _end(entry: Entry) -> Quantity | None:
    """What the law of a guide is multiplied by."""
    return entry.channels[0].amplitude if entry.form.startswith("guide") else None


def _of_laws(name: str, component: Component, atoms: Sequence[Atom]) -> Group:
    """Laws of unit mean variance each become a group of unit mean variance."""
    directions = np.hstack([atom.directions for atom in atoms])
    scale = 1.0 / np.sqrt(len(atoms))
    form = _entry(atoms[0]).form
    scales = np.full(directions.shape[1], scale)
    return Group(name, "law", component, form, scale * directions, scales, atoms=tuple(atoms))


def _named(sample: Data, misfit: float, library: Sequence[Candidate]) -> list[Group]:
    """Effects of one kind; of the geometry lengths and angles apart. `misfit`: RMS that the base model leaves."""
    kinds: dict[str, list[tuple[Effect, int, FloatArray]]] = {}
    for candidate in _all_together(library):
        for index, parameter in enumerate(candidate.effect.parameters):
            column = candidate.directions[0].matrix()[sample.kept][:, index]
            kinds.setdefault(_kind(candidate.effect, parameter), []).append((candidate.effect, index, column))
    found = []
    for name, members in kinds.items():
        columns = np.column_stack([column for _, _, column in members])
        deviations = _deviations([(effect, effect.parameters[i]) for effect, i, _ in members], columns, misfit)
        size = float(np.sqrt((columns**2).mean(axis=0) @ deviations**2))
        if size > 0.0:
            scales = deviations / size
            where = tuple(dict.fromkeys(effect.component for effect, _, _ in members))
            own = tuple((effect, index) for effect, index, _ in members)
            found.append(Group(name, members[0][0].physics, _where(where), "", columns * scales, scales, own))
    return found


def _where(components: tuple[Component, ...]) -> Component:
    """One component for a group: all joints, or the geometry, which links belong to."""
    if len(components) == 1:
        return components[0]
    return ALL_JOINTS if all(one.part is Part.JOINT for one in components) else GEOMETRY


def _all_together(library: Sequence[Candidate]) -> list[Candidate]:
    """Effects that may all be there together: linear, without memory, each place once.

    What stays at its last value beyond the range would be judged by blocks of time in which it is not what it was.
    """
    chosen: dict[Hashable, Candidate] = {}
    physics = {(c.effect.physics, c.effect.component) for c in library}
    for candidate in library:
        effect = candidate.effect
        if effect.states or any(p.shape for p in effect.parameters) or effect.component.several:
            continue
        if not effect.declared.linear or effect.declared.beyond is Beyond.HOLDS or len(candidate.directions) > 1:
            continue
        if (effect.physics, GEOMETRY) in physics and effect.component.part in (Part.JOINT, Part.LINK):
            continue
        best = chosen.get(effect.slot)
        if best is None or len(effect.parameters) > len(best.effect.parameters):
            chosen[effect.slot] = candidate
    return list(chosen.values())


def _kind(effect: Effect, parameter: Parameter) -> str:
    """Group of a parameter."""
    kind = "angles" if parameter.name.endswith("_rad") else "lengths"
    return effect.physics.replace("_", " ") + (f", {kind}" if _made(parameter) else "")


def _made(parameter: Parameter) -> bool:
    """Whether it is a dimension, of which it is known how well machines are made."""
    return bool(np.isfinite(parameter.spread)) and parameter.name.endswith(("_rad", "_m"))


_MOST_TYPICAL = 1e3
"""Typical sizes of a parameter that keep the arithmetic within what numbers hold."""


def _deviations(members: Sequence[tuple[Effect, Parameter]], columns: FloatArray, misfit: float) -> FloatArray:
    """Deviations of physical size: what an effect says of itself, else what would show as much as all that shows."""
    shows = np.sqrt((columns**2).mean(axis=0))
    scales = np.array([parameter.scale for _, parameter in members])
    found = np.empty(len(members))
    for k, (effect, parameter) in enumerate(members):
        if _made(parameter):
            found[k] = effect.size(parameter).value
        else:
            # What does not show at all stays where it is.
            shown = misfit / shows[k] if shows[k] > 0.0 else parameter.scale
            found[k] = min(shown, parameter.spread, _MOST_TYPICAL * parameter.scale)
    typical = OPTIONS.unlike * np.median(found / scales)
    limited: FloatArray = np.minimum(found, typical * scales)
    return limited
