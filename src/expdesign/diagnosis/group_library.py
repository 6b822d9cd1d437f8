"""Which groups of effects and laws recordings could show, with the sizes that their members have beforehand."""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, rms
from expdesign.chain.component import ALL_JOINTS, BASE, GEOMETRY, Component, Part
from expdesign.chain.declaration import Beyond
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.ports.port import Entry
from expdesign.chain.ports.quantities import Quantity
from expdesign.chain.ports.sight import Sight
from expdesign.diagnosis.evidence.columns import Dense
from expdesign.diagnosis.evidence.dictionary import Atom, Dictionary
from expdesign.diagnosis.evidence.state import Present, linearised
from expdesign.diagnosis.library import Candidate, physical_sizes
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Data, Fit
from expdesign.mechanics.robots.robot import Robot

Members = tuple[tuple[Effect, int], ...]
"""Effects and numbers of their parameters."""


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
    members: Members = ()
    atoms: tuple[Atom, ...] = ()

    @property
    def end(self) -> Quantity | None:
        """What laws of guides are multiplied by."""
        return _end(_entry(self.atoms[0])) if self.atoms else None

    @property
    def kind(self) -> tuple[Component, str]:
        """What people would call it; laws of guides that end elsewhere are of one kind."""
        return self.component, self.form or self.name

    @property
    def atom(self) -> Atom:
        """All members as one entry of a search."""
        return Atom(self.component, Dense(self.directions), self.directions.T @ self.directions)


@dataclass(frozen=True)
class GroupLibrary:
    """Groups that recordings could show, and what their laws see."""

    groups: tuple[Group, ...]
    sight: Sight

    def of_readings(self, kept: BoolArray) -> "GroupLibrary":
        """The same beside some of the readings alone, shape (M,)."""
        return replace(self, groups=tuple(replace(g, directions=g.directions[kept]) for g in self.groups))


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
    present = linearised(base, sample, known_noise=False)
    names = [] if robot.on_support else _named(robot, sample, base, library)
    return GroupLibrary((*names, *_few_ends(_laws(dictionary, robot), present)), dictionary.sight)


def _laws(dictionary: Dictionary, robot: Robot) -> list[Group]:
    """Every law of a joint by itself, and laws of a support that have one form, kernel and guide's end, of every axis.

    Of joints that turn laws repeat with every turn, so that they hold at angles that no row has.
    """
    turning = {atom.component for atom in dictionary.atoms if _entry(atom).kernel == "periodic"}
    kinds: dict[Hashable, list[Atom]] = {}
    for number, atom in enumerate(dictionary.atoms):
        entry = _entry(atom)
        scale = entry.scales if entry.kernel == "matern" else None
        kind = (entry.form, entry.kernel, scale, _end(entry)) if robot.on_support else number
        if not atom.component.several and (entry.kernel == "periodic" or atom.component not in turning):
            kinds.setdefault(kind, []).append(atom)
    return [_of_laws(atoms) for atoms in kinds.values()]


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


def _entry(atom: Atom) -> Entry:
    assert atom.entry is not None
    return atom.entry


def _end(entry: Entry) -> Quantity | None:
    """What the law of a guide is multiplied by."""
    return entry.channels[0].amplitude if entry.form.startswith("guide") else None


def _of_laws(atoms: Sequence[Atom]) -> Group:
    """Laws of unit mean variance each become a group of unit mean variance."""
    directions = np.hstack([atom.directions for atom in atoms])
    scale = 1.0 / np.sqrt(len(atoms))
    form = _entry(atoms[0]).form
    scales = np.full(directions.shape[1], scale)
    return Group(form, "law", atoms[0].component, form, scale * directions, scales, atoms=tuple(atoms))


def _named(robot: Robot, sample: Data, base: Fit, library: Sequence[Candidate]) -> list[Group]:
    """Effects of one kind in their declared sizes; of the geometry lengths and angles apart."""
    sizes = physical_sizes(robot, sample, base)
    kinds: dict[str, list[tuple[Effect, int, float, FloatArray]]] = {}
    for candidate in _all_together(library):
        effect, moved = candidate.effect, candidate.directions[0].matrix()[sample.kept].T
        for index, (parameter, column) in enumerate(zip(effect.parameters, moved, strict=True)):
            size = sizes.of(effect.size(parameter), effect, parameter, column)
            kinds.setdefault(_kind(effect, parameter), []).append((effect, index, size, column))
    found = []
    for name, members in kinds.items():
        deviations = np.array([size for _, _, size, _ in members])
        columns = deviations * np.column_stack([column for _, _, _, column in members])
        size = float(np.sqrt((columns**2).sum(axis=1).mean()))
        if size > 0.0:
            where = tuple(dict.fromkeys(effect.component for effect, _, _, _ in members))
            own = tuple((effect, index) for effect, index, _, _ in members)
            physics = members[0][0].physics
            found.append(Group(name, physics, _where(where), "", columns / size, deviations / size, own))
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
    """Group of a parameter; dimensions are those of which it is known how well machines are made."""
    made = bool(np.isfinite(parameter.spread)) and parameter.name.endswith(("_rad", "_m"))
    kind = "angles" if parameter.name.endswith("_rad") else "lengths"
    return effect.physics.replace("_", " ") + (f", {kind}" if made else "")
