"""One effect in a model file: the only place where texts become components, variants and classes of effects.

What physics a robot can have beside its base model: places, forms, parameters and their usual sizes.

Everything is read off the effects' own declarations.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import Field

from expdesign.chain.component import Component, component_from_text
from expdesign.chain.declaration import Beyond, Parameter
from expdesign.chain.effect import Effect
from expdesign.chain.ports.law import Law, form_data, form_of
from expdesign.chain.recordings.recordings import POSITIONS
from expdesign.io.schema import Number, Section
from expdesign.io.units import measured_column
from expdesign.mechanics.robots.robot import Robot
from expdesign.plugins import implementations

_AGAIN = "Identify or diagnose the recordings again with this version."


class EffectSection(Section):
    """An entry of `effects`; files of version 1 may have no `identifier`."""

    identifier: str = ""
    physics: str
    component: str
    variant: str = ""
    parameters: dict[str, Number]
    law: dict[str, Any] | None = None
    recorded: dict[str, Annotated[list[Number], Field(min_length=2, max_length=2)]] = Field(default_factory=dict)


def effect_classes() -> list[type[Effect]]:
    """Every effect by its identifier, those from outside last; raises `ValueError` where two have one identifier."""
    found = implementations("expdesign.chain.effects", Effect)
    found.sort(key=lambda cls: (not cls.__module__.startswith("expdesign."), cls.identifier))
    names = [cls.identifier for cls in found]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"effects with the same identifier: {', '.join(twice)}")
    return found


def effect_entry(effect: Effect, values: list[float]) -> dict[str, object]:
    """The entry of an effect with the values of its parameters; a law has its form beside them."""
    entry: dict[str, object] = {
        "identifier": effect.identifier,
        "physics": effect.physics,
        "component": str(effect.component),
        "variant": str(effect.variant),
        "parameters": {parameter.name: value for parameter, value in zip(effect.parameters, values, strict=True)},
    }
    if isinstance(effect, Law):
        entry["law"] = form_data(effect.form)
    if effect.beyond is Beyond.HOLDS and effect.recorded is not None:
        entry["recorded"] = {name: list(ends) for name, ends in effect.recorded.items()}
    return entry


def require_identifiers(entries: list[EffectSection]) -> None:
    """Raise an `InputError` where an effect has no identifier; a law, which is its own form, needs none."""
    for entry in entries:
        if not entry.identifier and entry.law is None:
            raise entry.where("identifier").fault("the key is missing", "Add it; only files of version 1 do without.")


def effect_of(entry: EffectSection, robot: Robot) -> Effect:
    """The effect of an entry.

    An entry without identifier is that of the only effect of its physics that this robot can have at the component, in
    the variant, with the same parameters.

    Args:
        entry: the entry.
        robot: the robot of the model.

    Raises:
        InputError: the effect is not known, is at a component that the robot does not have or in a form that the
            effect does not have, has other parameters, or may be several effects.
    """
    if entry.law is not None:
        return _law(entry, robot)
    known = effect_classes()
    if entry.identifier:
        known = [cls for cls in known if cls.identifier == entry.identifier]
        if not known:
            remedy = f"Known: {', '.join(sorted(cls.identifier for cls in effect_classes()))}."
            raise entry.where("identifier").fault(f"unknown effect `{entry.identifier}`", remedy)
        if known[0].physics != entry.physics:
            what = f"`{entry.identifier}` is `{known[0].physics}`, not `{entry.physics}`"
            raise entry.where("physics").fault(what, _AGAIN)
    effect = _only(_fitting(known, entry, robot), entry)
    if entry.recorded:
        effect.recorded = {name: (low, high) for name, (low, high) in entry.recorded.items()}
    return effect


def _fitting(known: list[type[Effect]], entry: EffectSection, robot: Robot) -> list[Effect]:
    """The effects that an entry may be; raises where no class of its physics is, or none has its place or its form."""
    of_physics = [cls for cls in known if cls.physics == entry.physics]
    if not of_physics:
        remedy = f"Known: {', '.join(sorted({cls.physics for cls in known})) or 'none'}."
        raise entry.where("physics").fault(f"unknown physics `{entry.physics}`", remedy)
    places = [str(component) for cls in of_physics for component in cls.components(robot)]
    try:
        component = component_from_text(entry.component)
    except ValueError:
        component = None
    here = [cls for cls in of_physics if component in cls.components(robot)]
    if not here:
        what = f"`{robot.name}` has no `{entry.component}` at which `{entry.physics}` could be"
        remedy = f"It can be at {', '.join(dict.fromkeys(places))}." if places else f"A {robot.kind} does not have it."
        raise entry.where("component").fault(what, remedy)
    found = []
    for cls in here:
        try:
            found.append(cls.from_text(robot, entry.component, entry.variant))
        except ValueError:
            continue
    if not found:
        what = f"`{entry.physics}` at `{entry.component}` has no variant `{entry.variant}` on this robot"
        raise entry.where("variant").fault(what, _AGAIN)
    return found


def _only(found: list[Effect], entry: EffectSection) -> Effect:
    """The one of several effects that has the parameters of the entry."""
    fitting = [e for e in found if {parameter.name for parameter in e.parameters} == set(entry.parameters)]
    if not fitting:
        what = f"`{entry.physics}` at `{entry.component}` does not have these parameters on this robot"
        raise entry.where("parameters").fault(what, _AGAIN)
    if len(fitting) > 1:
        names = ", ".join(effect.identifier for effect in fitting)
        what = f"`{entry.physics}` at `{entry.component}` may be several effects: {names}"
        raise entry.where().fault(what, "Write which one as `identifier`.")
    return fitting[0]


def _law(entry: EffectSection, robot: Robot) -> Law:
    """The law of an entry, from its data."""
    assert entry.law is not None
    try:
        law = Law(robot, form_of(entry.law, component_from_text(entry.component)), int(entry.variant.split()[-1]))
        known = {parameter.name for parameter in law.parameters} == set(entry.parameters)
    except (KeyError, TypeError, ValueError, IndexError):
        known = False
    if not known:
        raise entry.where("law").fault("this is not a law as this version writes it", _AGAIN)
    return law


_SMALL = 1e-3
"""m or rad, below which sizes are written in millionths."""


@dataclass(frozen=True)
class Offered:
    """One physics at places where it has the same parameters.

    Attributes:
        effect: at the first of its places.
        components: where it can be.
        variants: its forms there; the first is taken where none is named.
    """

    effect: Effect
    components: tuple[Component, ...]
    variants: tuple[str, ...]

    @property
    def physics(self) -> str:
        """Its identifier."""
        return self.effect.physics

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """With their bounds and typical values."""
        return self.effect.parameters

    @property
    def sentence(self) -> str:
        """What it is: the first line that its class says of itself."""
        return (type(self.effect).__doc__ or "").strip().split("\n")[0]

    @property
    def example(self) -> str:
        """What `simulate --conceal` takes, with the usual sizes; '' where it shows in positions of markers only."""
        if set(self.effect.measurands) <= {POSITIONS}:
            return ""
        free = [parameter for parameter in self.parameters if not parameter.shape]
        parts = [f"{self.physics} at {self.components[0]}"] + [each for each in self.variants[:1] if each]
        if len(self.parameters) <= 3:
            parts += [self._written(each, named=len(free) > 1 or each.shape) for each in self.parameters]
        return ", ".join(part for part in parts if part)

    def _written(self, parameter: Parameter, *, named: bool) -> str:
        """A parameter with its usual size; '' where that is a multiple of what the robot has."""
        size = self.effect.size(parameter)
        value = parameter.neutral if parameter.shape else size.value
        if parameter.shape and value == 0.0:
            return ""
        if size.of and not parameter.shape:
            return ""
        unit, factor = unit_of_parameter(parameter.name), 1.0
        if unit in ("m", "rad"):
            unit, factor = (f"u{unit}", 1e6) if value < _SMALL else (f"m{unit}", 1e3)
        text = f"{value * factor:.4g} {unit}".strip() if "/" not in unit else f"{value:.4g}"
        return f"{parameter.name} {text}" if named else text


def offered(robot: Robot) -> list[Offered]:
    """Every physics that the robot can have, by name."""
    found = [each for cls in effect_classes() for each in _of_class(cls, robot)]
    return sorted(found, key=lambda each: (each.physics, each.effect.identifier))


def unit_of_parameter(name: str) -> str:
    """The SI unit at the end of a parameter's name, such as `m`, `1/K` or `rad/Nm`; '' for a ratio."""
    head, per, last = name.rpartition("_per_")
    if per:
        before = head.rpartition("_")[2]
        return f"{before if before in ('m', 'rad', 'Nm', 'N') else '1'}/{last}"
    unit = name.rpartition("_")[2]
    if unit in ("m", "rad", "N", "Nm", "s", "kg", "kgm"):
        return unit
    measured = measured_column(name)
    return "" if measured is None else measured.unit.name


def effects_of(cls: type[Effect], robot: Robot) -> Iterator[Effect]:
    """The effect at every component in every form that the robot, and not recordings, decides."""
    for component in cls.components(robot):
        for variant in cls.variants(robot):
            try:
                effect = cls(robot, component, variant)
                if effect.parameters:
                    yield effect
            except ValueError:  # this form is not at this component
                continue


def _of_class(cls: type[Effect], robot: Robot) -> list[Offered]:
    groups: dict[tuple[str, ...], list[Effect]] = {}
    for effect in effects_of(cls, robot):
        groups.setdefault(tuple(parameter.name for parameter in effect.parameters), []).append(effect)
    return [
        Offered(
            effects[0],
            tuple(dict.fromkeys(effect.component for effect in effects)),
            tuple(dict.fromkeys(str(effect.variant) for effect in effects)),
        )
        for effects in groups.values()
    ]
