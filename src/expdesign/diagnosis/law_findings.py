"""Laws that were found, as findings: sentences, probabilities and curves."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.naming import FREE, LAW, physics_of
from expdesign.chain.ports.words import columns, depends_on, identifier, quantity_name, says, unit_of, usually
from expdesign.diagnosis.evidence.options import EVIDENCE
from expdesign.diagnosis.findings import Finding, reported
from expdesign.diagnosis.laws import FoundLaw, Laws
from expdesign.diagnosis.options import OPTIONS
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class LawFinding(Finding):
    """A law that is present, under the name of the physics whose port and inputs it has, or under none.

    Attributes:
        depends_on: identifiers of its inputs (`words.identifier`).
        columns: the same as columns of the curve.
        curve: with its band.
    """

    depends_on: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    curve: Curve | None = None


def law_findings(laws: Laws, robot: Robot, known: Collection[str]) -> tuple[Finding, ...]:
    """Findings of laws and of the named effects beside them that explain something.

    Args:
        laws: what was found.
        robot: the robot.
        known: identifiers of the physics that was looked for, which laws may have.
    """
    told = [index for index, part in enumerate(laws.parts) if part.share >= OPTIONS.listed] or [0]
    return tuple(_finding(laws, index, robot, known) for index in told)


def _finding(laws: Laws, index: int, robot: Robot, known: Collection[str]) -> Finding:
    part = laws.parts[index]
    where = laws.fit.chain.effects.index(part.effect)
    others = tuple(str(place.component) for place in part.places[1:] if place.probability >= EVIDENCE.open)
    probability = next((p.probability for p in part.places if p.component == part.effect.component), 0.0)
    effect = part.effect
    if not isinstance(effect, Law):
        beaten = any(isinstance(p.effect, Law) and p.effect.component == effect.component for p in laws.parts)
        factor = OPTIONS.beside_laws * (OPTIONS.beside_its_law if beaten else 1.0)
        values = reported(effect, laws.fit, laws.fit.chain.slices[where], 1.0)
        return Finding(
            effect.physics, str(effect.component), str(effect.variant), values, factor * probability, (),
            effect.sentence(values), form=effect.form_name, share=part.share,
        )  # fmt: skip
    inputs = effect.form.channels[0].inputs
    every = effect.form.depends_on
    names = tuple(dict.fromkeys(identifier(q, robot) for q in every))
    # What may as well be elsewhere has no name yet: the name depends on the part. Nor has what several laws of one part
    # make up together, unless all are the same physics.
    own = {physics_of(p.effect, known) for p in laws.parts if _beside(p.effect, effect)}
    physics = LAW if others or own - {physics_of(effect, known)} else physics_of(effect, known)
    return LawFinding(
        physics, str(effect.component), effect.form.kind, {}, probability, (), sentence(part, robot, others),
        form="" if physics == LAW else FREE, share=part.share,
        depends_on=names, columns=columns(inputs, robot), curve=part.curve,
    )  # fmt: skip


def _beside(other: Effect, law: Law) -> bool:
    """Whether another law is of the same component."""
    return isinstance(other, Law) and other.component == law.component


def sentence(part: FoundLaw, robot: Robot, others: tuple[str, ...] = ()) -> str:
    """What a technician should know of a law: where, what it does, on what it depends, how large, what does that."""
    effect, curve = part.effect, part.curve
    assert isinstance(effect, Law)
    assert curve is not None
    text = f"{effect.subject} {says(effect.form.kind, depends_on(effect.form.depends_on, robot))}"
    said = round(100.0 * part.share)
    text += f" ({said} % of the misfit of the base model)" if said else ""
    if curve.meaning == "compliance" and len(curve.quantities) == 1:
        middle = float(np.median(curve.mean))
        at = int(np.argmax(np.abs(curve.mean - middle)))
        relative = curve.mean[at] / middle - 1.0
        half = 1.96 * curve.deviation[at] / abs(middle)
        unit = unit_of(curve.quantities[0], robot)
        how = "softer" if relative > 0.0 else "stiffer"
        where = f"{quantity_name(curve.quantities[0], robot)} is {curve.inputs[at, 0]:.4g} {unit}"
        text += f": it is {100.0 * abs(relative):.0f} % (±{100.0 * half:.0f}) {how} than usual where {where}"
    text += f"; {usually(effect.form.kind)}." if said else "."
    if others:
        text += f" These recordings also fit {' or '.join(others)}."
    return text


def curves(findings: tuple[Finding, ...]) -> tuple[LawFinding, ...]:
    """The findings that have a curve, in the order of their files."""
    return tuple(f for f in findings if isinstance(f, LawFinding) and f.curve is not None)


def curve_file(findings: tuple[Finding, ...], finding: Finding) -> str | None:
    """Name of the file with the curve of a finding."""
    for number, one in enumerate(curves(findings), start=1):
        if one is finding:
            return f"law-{number}.csv"
    return None
