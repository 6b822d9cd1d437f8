"""Which physics a law is, whatever its form: a name is a port and what it depends on.

Creep that follows no exponential, friction that hardens, a gear error with harmonics of its own remain creep, friction
and a periodic error. What no declaration covers is a law without a name.
"""

from collections.abc import Collection

from expdesign.chain.component import Component
from expdesign.chain.declaration import Input
from expdesign.chain.effect import Effect
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.quantities import Quantity
from expdesign.mechanics.robots.robot import Robot
from expdesign.plugins import implementations

LAW = Law.physics
"""Identifier of a law that no physics covers."""
FREE = "free"
"""Form of physics whose law is that of no declared form."""
_INPUTS = {
    "effort": Input.FORCE, "effort_sign": Input.FORCE, "whole": Input.FORCE, "rest": Input.FORCE, "ground": Input.FORCE,
    "joint_moment": Input.FORCE, "carried": Input.FORCE, "pair": Input.FORCE, "pair_sign": Input.FORCE,
    "weight": Input.FORCE,
    "clock": Input.TIME, "after": Input.TIME, "elapsed": Input.TIME, "started": Input.TIME,
    "warming": Input.TEMPERATURE, "temperature": Input.TEMPERATURE, "warmth": Input.TEMPERATURE,
}  # fmt: skip
"""What laws see, in the words of declarations; memory is known by its states, and all other things are places."""


def input_of(quantity: Quantity) -> Input:
    """On what a law depends that sees this."""
    return Input.HISTORY if quantity.states else _INPUTS.get(quantity.kind, Input.PLACE)


def physics_of(law: Law, known: Collection[str]) -> str:
    """Identifier of the physics at this port that declares such laws and depends on nothing else; `LAW` if none does.

    Amplitudes count as inputs: a compliance that varies with time depends on a force and on time.

    Args:
        law: the law.
        known: identifiers that may be given: those of the library that was searched.
    """
    form = law.form
    seen = {*form.depends_on, *(channel.amplitude for channel in form.channels)}
    inputs = {input_of(quantity) for quantity in seen if quantity is not None}
    for kind in implementations("expdesign.chain.effects", Effect):  # type: ignore[type-abstract]
        declared = kind.declared
        if kind.physics not in known or form.kind not in declared.laws or not inputs <= {*declared.inputs}:
            continue
        if form.component not in kind.components(law.robot):
            continue
        if form.port in ports_of_kind(kind, law.robot, form.component):
            return kind.physics
    return LAW


def ports_of_kind(kind: type[Effect], robot: Robot, component: Component) -> set[str]:
    """Ports at which a kind of physics acts: the declared one, unless its variants act elsewhere."""
    if kind.acts_at is Effect.acts_at:
        return {kind.declared.port}
    return {kind(robot, component, variant).acts_at for variant in kind.variants(robot)}
