"""What a physical effect is, and where on the measurement chain it acts.

The chain runs from left to right,

    assumed load → actual load → actuator forces → actuator length changes → structure → pose → instrument reading,

and the base model is the chain with nothing on it but linear actuator springs: Δq = c∘(Jᵀ·F), ΔX = J̌·Δq. An effect
overrides the links at which it acts; each override takes what comes from the left and returns what goes to the right.
At the neutral values of its parameters every effect is the identity, so that base model and effect are nested and their
comparison is a test of the parameters.

Most of it is data: places, parameters and words; and where the physics is a law of one force or motion of an actuator,
a form for each variant.

To add an effect: one subclass of `Effect` in a file of `chain/effects`, or a class of a package of your own that is
registered (docs/extending.md). Identification, prediction, compensation, diagnosis and MEIR find it there.
"""

from abc import ABC
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from typing import Any, ClassVar, Self

import casadi as ca
import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.component import ACTUATORS, PAYLOAD, Component, component_from_text
from expdesign.chain.declaration import TYPICAL, Beyond, Declaration, Parameter, Size, Variant
from expdesign.chain.form import ONLY, Acting, Form
from expdesign.chain.recorded_inputs import Ranges, held
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES, POSITIONS, LoadedPoints, Measurand
from expdesign.chain.row import Row
from expdesign.chain.sentences import ENDLESS, Alone, Listed, Reported
from expdesign.mechanics.robots.robot import Robot

__all__ = ["Effect", "Parameter"]

When = Callable[[Robot, LoadedPoints], object]
"""Whether recordings can show an effect on a robot."""
Shows = Callable[[Component, Variant], object]
"""Whether recordings can show an effect at a component in a variant."""
Values = dict[str, tuple[float, float, float]]
"""Reported values with their 95 % intervals: estimate, low, high."""

LOAD_DIRECTION = "load direction"
"""Port at which gravity acts in another direction than stated, at targets as well."""


def anywhere(robot: Robot, points: LoadedPoints) -> Shows:
    """Recordings that can show an effect show it at every component, in every variant."""
    return lambda component, variant: True


class Effect(ABC):
    """One kind of physics at one component of a robot.

    Where its variants are forms (`Form`), each of the actuators concerned gains what the form says of it, and the load
    is what the form makes of it; parameters and sentence are those of the form if this has some.

    Names of parameters may hold `{force}` and `{motion}`, the units where it acts (N and m, or Nm and rad), and
    `{axis}` or `{deflection}`, for which they are repeated: along every axis of the robot's workspace, or for every
    component of a deflection.

    Attributes:
        identifier: of the class, kept in model files: its place in `chain/effects` (`legs.backlash`), unless the class
            declares one. A file that moves keeps the identifier that its class had by declaring it.
        physics: identifier (file-formats.md, Identifiers of physics), shared by effects that people call by one name.
        declared: what is known of it before anything is measured: how large it is, its name in sentences, its inputs.
        forms: its variants, where the robot and the recordings do not decide which there are.
        measurands: readings that show it. Geometry and own weight show in positions to first order and cancel from
            deflections; what only shifts or turns the instrument is part of every model of positions.
        when: whether recordings of one of these can show it on a robot.
        at: its components on a robot.
        shows: which of these, in which variants, recordings can show.
        quantities: its parameters.
        says: its sentence, with `{component}`, `{subject}` (the same as first word), `{variant}`, `{s}` (of a verb),
            `{force}` and `{motion}`, and the reported values (`Reported`): `{first}`, `{all}`, and by name, with or
            without these units.
        component: where it acts.
        variant: which of several forms, `ONLY` where there is one.
        parameters: in the order of `theta` in the overrides.
        states: number of states that the effect carries from row to row of a series, all 0 at its start.
        together: whether several forms of it may be at one component.
        builds_on: physics without which this effect has no meaning at its component (play, friction and creep of a
            support are ways in which it is not the spring that it is first of all); empty where there is none.
        changes_geometry: whether `geometry`, `lengths` or `unloaded` is overridden, which makes the kinematic maps
            symbolic.
        changes_reading: whether `reading` is overridden; other effects show as they move the platform.
        recorded: ranges of the times and temperatures from which its parameters are; None where it has not been fitted.
    """

    identifier: ClassVar[str]
    physics: ClassVar[str]
    declared: ClassVar[Declaration] = Declaration()
    forms: ClassVar[tuple[Variant, ...]] = (ONLY,)
    measurands: ClassVar[tuple[Measurand, ...]] = (DEFLECTIONS, POSITIONS, POSES)
    when: ClassVar[When] = lambda robot, points: True
    at: ClassVar[Callable[[Robot], Sequence[Component]]]
    shows: ClassVar[Callable[[Robot, LoadedPoints], Shows]] = anywhere
    quantities: ClassVar[tuple[Parameter, ...]] = ()
    says: ClassVar[str] = ""
    component: Component
    variant: Any
    parameters: tuple[Parameter, ...]
    states: int = 0
    together: ClassVar[bool] = False
    builds_on: str = ""
    changes_geometry: bool = False
    changes_reading: ClassVar[bool] = False
    recorded: Ranges | None = None

    def __init_subclass__(cls, **options: object) -> None:
        super().__init_subclass__(**options)
        if "reading" in vars(cls):
            cls.changes_reading = True
        if "identifier" not in vars(cls):
            cls.identifier = cls.__module__.partition(".chain.effects.")[2] or cls.__name__

    def __init__(self, robot: Robot, component: Component, variant: Variant = ONLY) -> None:
        """Raises `ValueError` where the robot has no such component."""
        if component not in self.components(robot):
            raise ValueError(f"this robot has no `{component}` at which `{self.identifier}` could be")
        self.robot = robot
        self.component = component
        self.variant = variant
        self.parameters = self.describe()
        if self.variant_form is not None and self.variant_form.memory:
            self.states = self.variant_form.memory * len(self.actuators)

    @property
    def variant_form(self) -> Form | None:
        """The form of its variant, where it separates."""
        return self.variant if isinstance(self.variant, Form) else None

    def describe(self) -> tuple[Parameter, ...]:
        """The parameters of this component and variant."""
        return self.described((self.variant_form is not None and self.variant_form.parameters) or self.quantities)

    def described(self, quantities: Sequence[Parameter]) -> tuple[Parameter, ...]:
        """Parameters with their names filled in."""
        (force, motion), coordinates = self.units, self.robot.coordinates
        repeated = {"axis": coordinates.axes, "deflection": coordinates.deflection}
        found = []
        for each in quantities:
            along = next((name for name in repeated if f"{{{name}}}" in each.name), "")
            for item in repeated.get(along, ("",)):
                name = each.name.format(force=force, motion=motion, **{along: item})
                found.append(replace(each, name=name))
        return tuple(found)

    @property
    def units(self) -> tuple[str, str]:
        """Units of force and motion where it acts, as names of parameters have them."""
        turns = self.component.part in ACTUATORS and self.robot.units[self.actuators[0]] == "rad"
        return ("Nm", "rad") if turns else ("N", "m")

    @property
    def of_weights(self) -> bool:
        """Whether it is an error of the loads that were applied, not of the machine nor of the direction of gravity."""
        return self.component == PAYLOAD and self.port_name != LOAD_DIRECTION

    @classmethod
    def port_at(cls, component: Component) -> str:
        """Port of the chain at which it acts at a component, as laws without a name do."""
        return cls.declared.port

    @property
    def port_name(self) -> str:
        """Port of the chain at which it acts."""
        return self.port_at(self.component)

    @classmethod
    def components(cls, robot: Robot) -> Sequence[Component]:
        """Components of a robot at which this physics can be, by what the robot offers; none for other robots."""
        return cls.at(robot)

    @classmethod
    def variants(cls, robot: Robot) -> Sequence[Variant]:
        """The forms that this physics can have on a robot, as far as recordings do not decide it."""
        return cls.forms

    @classmethod
    def places(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        """Components and variants that these recordings could show on this robot."""
        shown = points.measurand in cls.measurands and cls.components(robot) and cls.when(robot, points)
        return cls.shown(robot, points) if shown else []

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        """`places` on a robot that has components for it, in recordings that can show it; to be narrowed where these
        decide which.
        """
        shows, variants = cls.shows(robot, points), cls.variants(robot)
        return [(at, form) for at in cls.components(robot) for form in variants if shows(at, form)]

    @classmethod
    def candidates(cls, robot: Robot, points: LoadedPoints) -> list[Self]:
        """The effect at every place."""
        return [cls(robot, component, variant) for component, variant in cls.places(robot, points)]

    @classmethod
    def variant_from_text(cls, robot: Robot, text: str) -> Variant:
        """The variant whose text a file holds; raises `ValueError` where there is none."""
        found = [variant for variant in cls.variants(robot) if str(variant) == text]
        if not found:
            raise ValueError(f"`{cls.identifier}` has no variant `{text}` on this robot")
        return found[0]

    @classmethod
    def from_text(cls, robot: Robot, component: str, variant: str = "") -> Self:
        """The effect that a file names; raises `ValueError` where the robot has no such component or variant."""
        return cls(robot, component_from_text(component), cls.variant_from_text(robot, variant))

    def starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Neutral parameters with every value of the shapes from which a search has to start, shape (p,) each."""
        return [self.neutral()]

    def large_starts(self, points: LoadedPoints) -> list[FloatArray]:
        """Further starts away from neutral, where much of an effect with one parameter and states is unlike a little
        of it.
        """
        return []

    @property
    def actuators(self) -> tuple[int, ...]:
        """Indices of the actuators concerned: one, or all."""
        return tuple(range(len(self.robot.stiffness))) if self.component.several else (self.component.index,)

    @property
    def slot(self) -> tuple[Hashable, ...]:
        """What a model holds at most once: forms of one physics at one component exclude each other, as a rule."""
        return (self.physics, self.component, self.variant) if self.together else (self.physics, self.component)

    @property
    def key(self) -> str:
        """Names of physics, component and variant, for people."""
        return " / ".join(text for text in (self.physics, str(self.component), str(self.variant)) if text)

    @property
    def subject(self) -> str:
        """The component as the first words of a sentence."""
        return str(self.component).capitalize()

    def geometry(self, geometry: ca.SX, theta: ca.SX) -> ca.SX:
        """True joint coordinates, from the nominal ones."""
        return geometry

    def lengths(self, commanded: ca.SX, theta: ca.SX) -> ca.SX:
        """True coordinates of the unloaded actuators (n_p,), from the commanded ones."""
        return commanded

    def unloaded(self, pose: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """True pose of the unloaded platform, from the one that geometry alone leads to."""
        return pose

    def own_weight_change(self, row: Row, theta: ca.SX) -> ca.SX:
        """Actual minus assumed actuator forces by the robot's own weight (n_p,)."""
        return ca.SX.zeros(row.own.shape[0])

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """Actual wrench (n,), from the assumed one."""
        law = self.variant_form.load if self.variant_form is not None else None
        return wrench if law is None else law(wrench, row, theta)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """Length changes of the actuators (n_p,) and the effect's next states, from those so far.

        Args:
            elongation: length changes so far (n_p,), c∘τ in the base model.
            force: actuator forces τ (n_p,).
            compliance: c (n_p,).
            row: the row.
            state: the effect's states after the row before (zero at the start of a series).
            theta: parameters.
        """
        if self.variant_form is None or self.variant_form.law is None or self.component.part not in ACTUATORS:
            return elongation, state
        memory, gained, following = self.variant_form.memory, ca.SX.zeros(elongation.shape[0]), []
        for number, index in enumerate(self.actuators):
            own = state[number * memory : (number + 1) * memory] if memory else ca.SX.zeros(0)
            before, place = row.reference_force[index], row.lengths[index]
            at = Acting(index, before, force[index], compliance[index], elongation[index], place, own, row)
            gained[index], after = self.variant_form.law(at, theta)
            following.append(after)
        return elongation + gained, ca.vertcat(*following) if memory else state

    def structure(self, deflection: ca.SX, wrench: ca.SX, compliance: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """Deflection of the platform (n,) in pose coordinates, from the one due to the actuators."""
        return deflection

    def structure_with_memory(
        self, deflection: ca.SX, wrench: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        """Deflection (n,) and the effect's next states, for effects of the structure that depend on history."""
        return deflection, state

    def reading(self, reading: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        """What the instrument reads (n,), from what the platform does."""
        return reading

    def reported(self, theta: ca.SX) -> dict[str, ca.SX]:
        """The parameters as people know them (names of file-formats.md, diagnosis.json), as expressions of `theta`."""
        return {parameter.name: theta[i] for i, parameter in enumerate(self.parameters)}

    def sentence(self, values: Values) -> str:
        """What a technician should know, from reported values with their 95 % intervals."""
        says = (self.variant_form is not None and self.variant_form.says) or self.says
        if says:
            return self.said(says, values)
        listed = ", ".join(f"{name} = {v[0]:.3g} ({v[1]:.3g} to {v[2]:.3g})" for name, v in values.items())
        return f"{self.component}: {self.physics.replace('_', ' ')}, {listed}."

    def said(self, text: str, values: Values) -> str:
        """A text like `says` with what it names filled in."""
        force, motion = self.units
        limits = {p.name: (max(p.low, ENDLESS[0]), min(p.high, ENDLESS[1])) for p in self.parameters}
        known = {
            name: Reported(Alone(best), Alone(low), Alone(high), limits.get(name, ENDLESS))
            for name, (best, low, high) in values.items()
        }
        plain = {name.removesuffix(f"_{force}").removesuffix(f"_{motion}"): value for name, value in known.items()}
        return text.format(
            component=self.component,
            subject=self.subject,
            variant=self.variant,
            s="" if self.component.several else "s",
            force=force.replace("Nm", "N·m"),
            motion=motion,
            first=next(iter(known.values())),
            all=Listed(known.values()),
            **plain | known,
        )

    @property
    def phrase(self) -> str:
        """A machine that has it, as the subject of a sentence: `play in leg 3`."""
        phrase = self.declared.phrase or f"{self.physics.replace('_', ' ')} ({{component}})"
        return phrase.format(component=self.component)

    @property
    def form_name(self) -> str:
        """Name of its parametric form (file-formats.md, diagnosis.json)."""
        return (self.variant_form is not None and self.variant_form.called) or self.declared.form

    @property
    def beyond(self) -> Beyond:
        """What it does beyond the recorded range of its inputs."""
        return (self.variant_form is not None and self.variant_form.beyond) or self.declared.beyond

    def seen(self, row: Row) -> Row:
        """A row as it acts on it: where `beyond` says so, with times and temperatures held within what was recorded."""
        return held(row, self.recorded) if self.recorded is not None and self.beyond is Beyond.HOLDS else row

    def size(self, parameter: Parameter) -> Size:
        """How large a parameter is on machines of this class: as declared, else its typical size."""
        declared = (size for size in self.declared.sizes if fnmatchcase(parameter.name, size.parameter))
        return next(declared, Size(parameter.name, parameter.scale, TYPICAL))

    def neutral(self) -> FloatArray:
        """Parameters at which the effect vanishes."""
        return np.array([p.neutral for p in self.parameters])
