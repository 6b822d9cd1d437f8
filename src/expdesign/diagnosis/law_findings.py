"""Laws that were found, and groups of effects and laws, as findings: sentences, probabilities and curves."""

from collections.abc import Collection

import numpy as np

from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve, curve_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.sight import Sight
from expdesign.chain.ports.words import FORMS, USUALLY, columns, depends_on, says
from expdesign.diagnosis.findings import Finding, compensating, reported
from expdesign.diagnosis.groups import FoundGroup, Groups
from expdesign.diagnosis.laws import FoundLaw, Laws
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Fit
from expdesign.mechanics.robots.robot import Robot

FREE = "free"
"""Form of physics whose law is that of no declared form."""
_PLACES = 3
"""That a sentence names beside the likeliest."""
_POINTS = 31
"""Of a curve that is drawn of the change from a reference's load."""


def law_findings(laws: Laws, robot: Robot, known: Collection[str]) -> tuple[Finding, ...]:
    """Findings of laws and of the named effects beside them that explain something.

    Args:
        laws: what was found.
        robot: the robot.
        known: identifiers of the physics that was looked for, which laws may have.
    """
    told = [index for index, part in enumerate(laws.parts) if abs(part.share) >= OPTIONS.listed] or [0]
    return tuple(_finding(laws, index, robot, known) for index in told)


def _finding(laws: Laws, index: int, robot: Robot, known: Collection[str]) -> Finding:
    part = laws.parts[index]
    where = laws.fit.chain.effects.index(part.effect)
    effect, here = part.effect, part.effect.component
    others = tuple(str(place.component) for place in part.places if place.alike and place.component != here)
    probability = next((p.probability for p in part.places if p.component == here), 0.0)
    if not isinstance(effect, Law):
        beaten = any(isinstance(p.effect, Law) and p.effect.component == effect.component for p in laws.parts)
        factor = OPTIONS.doubted ** (2 if beaten else 1)
        values = reported(effect, laws.fit, laws.fit.chain.slices[where], 1.0)
        return Finding(
            effect.physics, str(effect.component), str(effect.variant), values, factor * probability, (),
            compensating(effect.sentence(values), part.share), form=effect.form_name, share=part.share,
        )  # fmt: skip
    inputs = effect.form.channels[0].inputs
    every = effect.form.depends_on
    names = tuple(dict.fromkeys(q.identifier(robot) for q in every))
    # What may as well be elsewhere has no name yet: the name depends on the part. Nor has what several laws of one part
    # make up together, unless all are the same physics.
    beside = [p.effect for p in laws.parts if p.effect.component == effect.component]
    own = {law.physics_among(known) for law in beside if isinstance(law, Law)}
    physics = Law.physics if others or own - {effect.physics_among(known)} else effect.physics_among(known)
    return Finding(
        physics, str(effect.component), effect.form.kind, {}, probability, (), sentence(part, robot, others),
        form="" if physics == Law.physics else FREE, share=part.share,
        depends_on=names, columns=columns(inputs, robot), curve=part.curve,
    )  # fmt: skip


def sentence(part: FoundLaw, robot: Robot, others: tuple[str, ...] = ()) -> str:
    """What a technician should know of a law: where, what it does, on what it depends, how large, what does that."""
    effect, curve = part.effect, part.curve
    assert isinstance(effect, Law)
    assert curve is not None
    text = f"{effect.subject} {says(effect.form.kind, depends_on(effect.form.depends_on, robot))}"
    said = round(100.0 * part.share)
    text += f" ({said} % of what is explained)" if said > 0 else ""
    if curve.meaning == "compliance" and len(curve.quantities) == 1:
        middle = float(np.median(curve.mean))
        at = int(np.argmax(np.abs(curve.mean - middle)))
        relative = curve.mean[at] / middle - 1.0
        half = 1.96 * curve.deviation[at] / abs(middle)
        unit = curve.quantities[0].unit(robot)
        how = "softer" if relative > 0.0 else "stiffer"
        where = f"{curve.quantities[0].name(robot)} is {curve.inputs[at, 0]:.4g} {unit}"
        text += f": it is {100.0 * abs(relative):.0f} % (±{100.0 * half:.0f}) {how} than usual where {where}"
    text = compensating(f"{text}; {USUALLY[effect.form.kind]}." if said else f"{text}.", part.share)
    if len(others) > _PLACES:
        text += f" These recordings hardly tell where: {len(others)} other places fit as well."
    elif others:
        text += f" These recordings also fit {' or '.join(others)}."
    return text


def curves(findings: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """The findings that have a curve, in the order of their files."""
    return tuple(f for f in findings if f.curve is not None)


def curve_file(findings: tuple[Finding, ...], finding: Finding) -> str | None:
    """Name of the file with the curve of a finding."""
    for number, one in enumerate(curves(findings), start=1):
        if one is finding:
            return f"law-{number}.csv"
    return None


def group_findings(groups: Groups, robot: Robot, known: Collection[str]) -> tuple[Finding, ...]:
    """One finding per group that takes away enough to be one, the largest first; `known` as in `law_findings`."""
    pairs = list(zip(groups.found, groups.stability.shares, strict=True))
    told = [pair for pair in pairs if abs(pair[0].share) >= OPTIONS.listed] or pairs[:1]
    return tuple(_of_laws(f, s, groups, robot, known) if f.laws else _of_names(f, s) for f, s in told)


def _of_names(found: FoundGroup, named_by: float) -> Finding:
    group = found.group
    text = f"{group.name[0].upper()}{group.name[1:]}: {_how_much(found, 'parameter')}"
    if found.told_apart:
        text += f"; told apart (95 %): {', '.join(found.told_apart)}."
    else:
        text += "; its members are not told apart."
    where = str(group.component)
    return Finding(
        group.physics, where, group.name, {}, found.probability, (), text,
        form=group.members[0][0].form_name, share=found.share, named_by=named_by,
    )  # fmt: skip


def _of_laws(found: FoundGroup, named_by: float, groups: Groups, robot: Robot, known: Collection[str]) -> Finding:
    form = found.laws[0].form
    seen = [q for channel in form.channels for q in (*channel.inputs, channel.amplitude) if q is not None]
    seen = [q for q in dict.fromkeys(seen) if q.kind not in ("rest", "overlap")]
    text = (
        f"{found.laws[0].subject} {FORMS[form.kind]} {', '.join(depends_on(tuple(seen), robot))}: "
        f"{_how_much(found, 'weight')}; {USUALLY[form.kind]}."
    )
    curve = _curve(found, groups, robot)
    physics = found.laws[0].physics_among(known)
    return Finding(
        physics, str(found.group.component), form.kind, {}, found.probability, (), text,
        form="" if physics == Law.physics else FREE, share=found.share, named_by=named_by,
        depends_on=tuple(dict.fromkeys(q.identifier(robot) for q in seen)),
        columns=() if curve is None else columns(curve.quantities, robot), curve=curve,
    )  # fmt: skip


def _how_much(found: FoundGroup, what: str) -> str:
    several = "s" * (round(found.determined) != 1)
    return (
        f"together {found.size:.2g} standard deviations of the readings RMS, {found.determined:.0f} {what}{several} "
        "determined"
    )


def _curve(found: FoundGroup, groups: Groups, robot: Robot) -> Curve | None:
    """The curve of the first law, or of all laws that are a change from the load of a reference.

    None where several loads move one axis, each by a factor of its own: that is no curve of one quantity.
    """
    fit, sight = groups.fit, groups.sight
    parts: dict[Effect, slice] = dict(zip(fit.chain.effects, fit.chain.slices, strict=True))
    first = found.laws[0]
    if len({channel.output for channel in first.form.channels}) < first.form.blocks:
        return None
    if first.form.channels[-1].gain < 0.0 and first.form.blocks == 1:
        return _of_changes([(law, parts[law]) for law in found.laws], robot, fit, sight)
    part = parts[first]
    seen = np.vstack([first.form.low[0], first.form.high[0]])
    return curve_of(
        first, robot, fit.values[: part.stop], np.asarray(fit.covariance[: part.stop, : part.stop]), part, seen
    )


def _of_changes(laws: list[tuple[Law, slice]], robot: Robot, fitted: Fit, sight: Sight) -> Curve:
    """Laws of the load, each input varied with the others at their medians; those of a guide at its median overlap."""
    form = laws[0][0].form
    inputs, before = (channel.inputs for channel in form.channels)
    seen, rest = (np.column_stack([sight.values(q)[sight.counts] for q in each]) for each in (inputs, before))
    known = np.where(np.isfinite(fitted.covariance), fitted.covariance, 0.0)
    output: list[str] = []
    varied: list[int] = []
    points, means, deviations = [], [], []
    for axis in dict.fromkeys(law.form.channels[0].output for law, _ in laws):
        for i in range(len(inputs)):
            line = np.repeat(np.median(seen, axis=0)[None], _POINTS, axis=0)
            line[:, i] = np.linspace(form.low[0, i], form.high[0, i], _POINTS)
            rows = np.zeros((_POINTS, len(fitted.values)))
            for law, part in laws:
                now, basis = law.form.channels[0], law.form.basis
                if now.output == axis:
                    size = 1.0 if now.amplitude is None else float(np.median(sight.values(now.amplitude)[sight.counts]))
                    change = basis.values(line) - basis.values(np.median(rest, axis=0)[None])
                    rows[:, part.start : part.start + basis.rank] += now.gain * size * change
            output += [robot.coordinates.deflection[axis]] * _POINTS
            varied += [i] * _POINTS
            points.append(line)
            means.append(rows @ fitted.values)
            deviations.append(np.sqrt(np.maximum(((rows @ known) * rows).sum(axis=1), 0.0)))
    return Curve(
        tuple(output), tuple(varied), np.concatenate(points), np.concatenate(means), np.concatenate(deviations),
        inputs, "law", "",
    )  # fmt: skip
