"""One effect in a model file: the only place where texts become components, variants and classes of effects."""

from typing import Any

from expdesign.chain.component import component_from_text
from expdesign.chain.effect import Effect
from expdesign.chain.ports.law import Law, form_data, form_of
from expdesign.errors import InputError
from expdesign.io.schema import Number, Section
from expdesign.io.yaml_reader import YamlDocument
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


def effect_classes() -> list[type[Effect]]:
    """Every effect that lies in `chain/effects`; raises `ValueError` where two have one identifier."""
    found = implementations("expdesign.chain.effects", Effect)  # type: ignore[type-abstract]
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
    return entry


def require_identifiers(entries: list[EffectSection], document: YamlDocument) -> None:
    """Raise an `InputError` where an effect has no identifier; a law, which is its own form, needs none."""
    for index, entry in enumerate(entries):
        if not entry.identifier and entry.law is None:
            where = document.where(("effects", index, "identifier"))
            raise InputError("the key is missing", where=where, remedy="Add it; only files of version 1 do without.")


def effect_of(entry: EffectSection, robot: Robot, document: YamlDocument) -> Effect:
    """The effect of an entry.

    An entry without identifier is that of the only effect of its physics that this robot can have at the component, in
    the variant, with the same parameters.

    Args:
        entry: the entry.
        robot: the robot of the model.
        document: the part of the file in which it stands.

    Raises:
        InputError: the effect is not known, is at a component that the robot does not have or in a form that the
            effect does not have, has other parameters, or may be several effects.
    """
    if entry.law is not None:
        return _law(entry, robot, document)
    known = effect_classes()
    if entry.identifier:
        known = [cls for cls in known if cls.identifier == entry.identifier]
        if not known:
            remedy = f"Known: {', '.join(sorted(cls.identifier for cls in effect_classes()))}."
            where = document.where(("identifier",))
            raise InputError(f"unknown effect `{entry.identifier}`", where=where, remedy=remedy)
        if known[0].physics != entry.physics:
            where = document.where(("physics",))
            what = f"`{entry.identifier}` is `{known[0].physics}`, not `{entry.physics}`"
            raise InputError(what, where=where, remedy=_AGAIN)
    return _only(_fitting(known, entry, robot, document), entry, document)


def _fitting(known: list[type[Effect]], entry: EffectSection, robot: Robot, document: YamlDocument) -> list[Effect]:
    """The effects that an entry may be; raises where no class of its physics is, or none has its place or its form."""
    of_physics = [cls for cls in known if cls.physics == entry.physics]
    if not of_physics:
        remedy = f"Known: {', '.join(sorted({cls.physics for cls in known})) or 'none'}."
        raise InputError(f"unknown physics `{entry.physics}`", where=document.where(("physics",)), remedy=remedy)
    places = [str(component) for cls in of_physics for component in cls.components(robot)]
    try:
        component = component_from_text(entry.component)
    except ValueError:
        component = None
    here = [cls for cls in of_physics if component in cls.components(robot)]
    if not here:
        what = f"`{robot.name}` has no `{entry.component}` at which `{entry.physics}` could be"
        remedy = f"It can be at {', '.join(dict.fromkeys(places))}." if places else f"A {robot.kind} does not have it."
        raise InputError(what, where=document.where(("component",)), remedy=remedy)
    found = []
    for cls in here:
        try:
            found.append(cls.from_text(robot, entry.component, entry.variant))
        except ValueError:
            continue
    if not found:
        what = f"`{entry.physics}` at `{entry.component}` has no variant `{entry.variant}` on this robot"
        raise InputError(what, where=document.where(("variant",)), remedy=_AGAIN)
    return found


def _only(found: list[Effect], entry: EffectSection, document: YamlDocument) -> Effect:
    """The one of several effects that has the parameters of the entry."""
    fitting = [e for e in found if {parameter.name for parameter in e.parameters} == set(entry.parameters)]
    if not fitting:
        what = f"`{entry.physics}` at `{entry.component}` does not have these parameters on this robot"
        raise InputError(what, where=document.where(("parameters",)), remedy=_AGAIN)
    if len(fitting) > 1:
        names = ", ".join(effect.identifier for effect in fitting)
        what = f"`{entry.physics}` at `{entry.component}` may be several effects: {names}"
        raise InputError(what, where=document.where(), remedy="Write which one as `identifier`.")
    return fitting[0]


def _law(entry: EffectSection, robot: Robot, document: YamlDocument) -> Law:
    """The law of an entry, from its data."""
    assert entry.law is not None
    try:
        law = Law(robot, form_of(entry.law, component_from_text(entry.component)), int(entry.variant.split()[-1]))
        known = {parameter.name for parameter in law.parameters} == set(entry.parameters)
    except (KeyError, TypeError, ValueError, IndexError):
        known = False
    if not known:
        raise InputError("this is not a law as this version writes it", where=document.where(("law",)), remedy=_AGAIN)
    return law
