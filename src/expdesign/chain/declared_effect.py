"""Physics as data: places, parameters and words, and where it separates a form for each of its variants."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import ClassVar

import casadi as ca

from expdesign.chain.component import ACTUATORS, Component
from expdesign.chain.declaration import ONLY, Beyond, Parameter, Variant
from expdesign.chain.effect import Effect, Values
from expdesign.chain.form import Acting, Form
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.row import Row
from expdesign.chain.sentences import ENDLESS, Alone, Listed, Reported
from expdesign.mechanics.robots.robot import Robot

Shows = Callable[[Component, Variant], object]
"""Whether recordings can show a physics at a component in a variant."""


def anywhere(robot: Robot, points: LoadedPoints) -> Shows:
    """Recordings that can show a physics show it at every component, in every variant."""
    return lambda component, variant: True


class DeclaredEffect(Effect):
    """An effect whose places, parameters and sentence are data.

    Names of parameters may hold `{force}` and `{motion}`, the units where it acts (N and m, or Nm and rad), and
    `{axis}` or `{deflection}`, for which they are repeated: along every axis of the robot's workspace, or for every
    component of a deflection.

    Where its variants are forms (`forms`), each of the actuators concerned gains what the form says of it, and the load
    is what the form makes of it; parameters and sentence are those of the form if this has some.

    Attributes:
        at: its components on a robot.
        shows: which of these, in which variants, recordings can show.
        quantities: its parameters.
        says: its sentence, with `{component}`, `{subject}` (the same as first word), `{variant}`, `{s}` (of a verb),
            `{force}` and `{motion}`, and the reported values (`Reported`): `{first}`, `{all}`, and by name, with or
            without these units.
    """

    at: ClassVar[Callable[[Robot], Sequence[Component]]]
    shows: ClassVar[Callable[[Robot, LoadedPoints], Shows]] = anywhere
    quantities: ClassVar[tuple[Parameter, ...]] = ()
    says: ClassVar[str] = ""

    def __init__(self, robot: Robot, component: Component, variant: Variant = ONLY) -> None:
        super().__init__(robot, component, variant)
        if self.form is not None and self.form.memory:
            self.states = self.form.memory * len(self.actuators)

    @property
    def form(self) -> Form | None:
        """The form of its variant, where it separates."""
        return self.variant if isinstance(self.variant, Form) else None

    @classmethod
    def components(cls, robot: Robot) -> Sequence[Component]:
        return cls.at(robot)

    @classmethod
    def shown(cls, robot: Robot, points: LoadedPoints) -> Sequence[tuple[Component, Variant]]:
        shows = cls.shows(robot, points)
        return [place for place in super().shown(robot, points) if shows(*place)]

    @property
    def units(self) -> tuple[str, str]:
        """Units of force and motion where it acts, as names of parameters have them."""
        turns = self.component.part in ACTUATORS and self.robot.units[self.actuators[0]] == "rad"
        return ("Nm", "rad") if turns else ("N", "m")

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

    def describe(self) -> tuple[Parameter, ...]:
        return self.described((self.form is not None and self.form.parameters) or self.quantities)

    def load(self, wrench: ca.SX, row: Row, theta: ca.SX) -> ca.SX:
        law = self.form.load if self.form is not None else None
        return wrench if law is None else law(wrench, row, theta)

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        if self.form is None or self.form.law is None or self.component.part not in ACTUATORS:
            return elongation, state
        memory, gained, following = self.form.memory, ca.SX.zeros(elongation.shape[0]), []
        for number, index in enumerate(self.actuators):
            own = state[number * memory : (number + 1) * memory] if memory else ca.SX.zeros(0)
            before, place = row.reference_force[index], row.lengths[index]
            at = Acting(index, before, force[index], compliance[index], elongation[index], place, own, row)
            gained[index], after = self.form.law(at, theta)
            following.append(after)
        return elongation + gained, ca.vertcat(*following) if memory else state

    @property
    def form_name(self) -> str:
        return (self.form is not None and self.form.called) or super().form_name

    @property
    def beyond(self) -> Beyond:
        return (self.form is not None and self.form.beyond) or super().beyond

    def sentence(self, values: Values) -> str:
        says = (self.form is not None and self.form.says) or self.says
        return self.said(says, values) if says else super().sentence(values)

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
