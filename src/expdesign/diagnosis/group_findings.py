"""Groups of effects and laws that are there, as findings."""

from collections.abc import Collection

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.effect import Effect
from expdesign.chain.ports.curve import Curve, curve_of
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.naming import FREE, LAW, physics_of
from expdesign.chain.ports.sight import Sight
from expdesign.chain.ports.words import FORMS, columns, depends_on, identifier, usually
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.groups import FoundGroup, Groups
from expdesign.diagnosis.law_findings import LawFinding
from expdesign.diagnosis.options import OPTIONS
from expdesign.estimation.fit import Fit
from expdesign.mechanics.robots.robot import Robot

_POINTS = 31


def group_findings(groups: Groups, robot: Robot, known: Collection[str]) -> tuple[Finding, ...]:
    """One finding per group that takes away enough to be one, the largest first; `known` as in `law_findings`."""
    pairs = list(zip(groups.found, groups.stability.shares, strict=True))
    told = [pair for pair in pairs if pair[0].share >= OPTIONS.listed] or pairs[:1]
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


def _of_laws(found: FoundGroup, named_by: float, groups: Groups, robot: Robot, known: Collection[str]) -> LawFinding:
    form = found.laws[0].form
    seen = [q for channel in form.channels for q in (*channel.inputs, channel.amplitude) if q is not None]
    seen = [q for q in dict.fromkeys(seen) if q.kind not in ("rest", "overlap")]
    text = (
        f"{found.laws[0].subject} {FORMS[form.kind]} {', '.join(depends_on(tuple(seen), robot))}: "
        f"{_how_much(found, 'weight')}; {usually(form.kind)}."
    )
    curve = _curve(found, groups, robot)
    physics = physics_of(found.laws[0], known)
    return LawFinding(
        physics, str(found.group.component), form.kind, {}, found.probability, (), text,
        form="" if physics == LAW else FREE, share=found.share, named_by=named_by,
        depends_on=tuple(dict.fromkeys(identifier(q, robot) for q in seen)),
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
    return curve_of(first, robot, fit.values[: part.stop], _up_to(fit, part.stop), part, seen)


def _up_to(fit: Fit, stop: int) -> FloatArray:
    covariance: FloatArray = fit.covariance[:stop, :stop]
    return covariance


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
