"""Sparse regression over a library of terms, as PySINDy does it.

Sequentially thresholded least squares (S. L. Brunton, J. L. Proctor, J. N. Kutz, Proc. Natl. Acad. Sci. 113 (2016)
3932) with PySINDy's own `STLSQ`, beside its greedy `FROLS` (S. A. Billings, Nonlinear System Identification, 2013),
which its documentation advises for terms that are alike. As it says of custom libraries, the terms are what a person
who knows the machine would write down: products of force, length, pose, time and warming at each leg, symmetric
compliances of platform and base, moved and turned loads, a turned or scaled instrument, drift. What the base model
can do is projected out, columns are normalised, and threshold, penalty and optimiser are chosen by leaving out series
in groups. Each term belongs to a component, and to physics where it has a name: the components are ordered by what
they explain.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pysindy.optimizers import FROLS, STLSQ
from pysindy.optimizers.base import BaseOptimizer
from sklearn.model_selection import GroupKFold

from .question import Array, Question, Reply, main

Rows = NDArray[np.intp]
_THRESHOLDS = (1.0, 2.0, 3.0, 5.0, 8.0, 12.0)
"""Of normalised coefficients: root of the sum of squares of a term's contribution, in standard deviations."""
_PENALTIES = (1e-3, 1e-1)
_SIZES = (1, 2, 3, 5, 8)
_PITCHES = (1e-3, 2e-3, 4e-3, 5e-3, 8e-3)
_TIMES = (60.0, 300.0, 1200.0)
_STOPS = (0.05, 0.15, 0.4)
"""Thresholds of the stop operators, of the largest force."""
_MOST_LEVELS = 6
_RIDGE = 1e-2
"""Of the last least squares, on normalised coefficients: they are of the order of ten standard deviations."""


@dataclass(frozen=True)
class Term:
    """What one unit of a term adds to the readings (rows x n), where it belongs, and its name if it has one."""

    component: str
    physics: str
    change: Array


def terms(question: Question) -> Iterator[Term]:
    """The library, over all rows in the order of `Question`."""
    yield from _legs(question)
    yield from _structure(question)
    yield from _load(question)
    yield from _instrument(question)


def _history(question: Question) -> tuple[Array, Array, Array]:
    """Time in the series (s), warming (K) and first row of the series, for all rows in the order of `Question`."""
    each = question.everything
    first = pd.Series(np.arange(len(each))).groupby(each.series).transform("first").to_numpy()
    time = np.zeros(len(each)) if each.time is None else each.time - each.time[first]
    warming = np.zeros(len(each)) if each.temperature is None else each.temperature - each.temperature[first]
    return time[question.order], warming[question.order], first[question.order]


def _legs(question: Question) -> Iterator[Term]:
    pose, _, forces = question.maps_all()
    lengths = question.robot.actuator_coordinates(question.everything.configurations)[question.order]
    inputs = question.everything.configurations[question.order]
    inputs = inputs / np.maximum(np.abs(inputs).max(axis=0), 1e-12)
    time, warming, _ = _history(question)
    previous = pd.DataFrame(forces).groupby(question.everything.series[question.order]).shift(fill_value=0.0)
    largest = np.maximum(np.abs(forces).max(), 1e-9)
    for leg in range(forces.shape[1]):
        force, length = forces[:, leg] / largest, lengths[:, leg]
        scaled = (length - length.mean()) / max(float(np.ptp(length)), 1e-9)
        rising = np.sign(force - previous[leg].to_numpy() / largest)
        laws = {
            "leg_nonlinear_stiffness": [force * np.abs(force), np.abs(force), force**3, np.cbrt(force)],
            "leg_backlash": [np.sign(np.round(force, 9)), (force > 1e-9).astype(float)],
            "friction_hysteresis": [rising, *(_stop(force, question, width) for width in _STOPS)],
            "creep": [force * (1 - np.exp(-time / tau)) for tau in _TIMES],
            "thermal_drift": [warming, time],
            "encoder_periodic_error": [
                wave(2 * np.pi * length / pitch) for pitch in _PITCHES for wave in (np.sin, np.cos)
            ],
            "joint_position_error": [force * scaled],
            "passive_joint_compliance": [force * inputs[:, axis] for axis in range(inputs.shape[1])],
            "law": [force * scaled**2, force * scaled**3, force * warming, scaled, scaled**2],
        }
        for physics, found in laws.items():
            for law in found:
                yield Term(f"leg {leg + 1}", physics, pose[:, :, leg] * law[:, None])
        for other in range(leg):
            both = pose[:, :, leg] * forces[:, [other]] + pose[:, :, other] * forces[:, [leg]]
            yield Term(f"leg {leg + 1}", "leg_coupling", both / largest)
    whole = (warming, time) if warming.any() or time.any() else ()
    for law in whole:
        yield Term("all legs", "thermal_drift", pose.sum(axis=2) * law[:, None])


def _stop(force: Array, question: Question, width: float) -> Array:
    """Prandtl's stop operator of the force, relaxed at the start of each series."""
    series, found = question.everything.series[question.order], np.zeros(len(force))
    last: dict[int, tuple[float, float]] = {}
    for row, (number, now) in enumerate(zip(series, force, strict=True)):
        before, state = last.get(int(number), (0.0, 0.0))
        found[row] = np.clip(state + now - before, -width, width)
        last[int(number)] = (float(now), float(found[row]))
    return found


def _structure(question: Question) -> Iterator[Term]:
    """Every entry of a symmetric compliance of the platform's mount and of the base."""
    configurations = question.everything.configurations
    rates = question.robot.pose_rates(configurations)[question.order]
    wrench = question.everything.wrenches[question.order]
    size = wrench.shape[1]
    turn = np.tile(np.eye(size), (len(wrench), 1, 1))
    carry = turn.copy()
    if size == 6:
        rotation = question.robot.jacobians(configurations).rotation[question.order]
        x, y, z = question.robot.position(configurations)[question.order].T
        turn[:, :3, :3] = turn[:, 3:, 3:] = rotation
        carry[:, 0, 4], carry[:, 0, 5], carry[:, 1, 5] = z, -y, x  # v + omega x p
        carry[:, 1, 3], carry[:, 2, 3], carry[:, 2, 4] = -z, y, -x
    for component, frame in (("platform", turn), ("base", carry)):
        local = np.einsum("rij,ri->rj", frame, wrench)
        for i in range(size):
            for j in range(i, size):
                twist = np.zeros_like(local)
                twist[:, i] += local[:, j]
                twist[:, j] += local[:, i]
                yield Term(component, f"{component}_compliance", np.einsum("rij,rjk,rk->ri", rates, frame, twist))


def _load(question: Question) -> Iterator[Term]:
    """A moved centre of mass, another mass, a turned load, and a force from the surroundings that varies with place."""
    pose, forward, _ = question.maps_all()
    compliance = np.einsum("rij,j,rkj->rik", pose, 1.0 / question.robot.stiffness, forward)
    wrench = question.everything.wrenches[question.order]
    size, force = wrench.shape[1], wrench[:, :3]

    def under(wrenches: Array) -> Array:
        return np.einsum("rij,rj->ri", compliance, wrenches)

    strength = np.linalg.norm(wrench[:, : min(size, 3)], axis=1, keepdims=True)
    yield Term("payload", "payload_mass_error", under(wrench / np.maximum(strength, 1e-9)))
    levels = np.unique(np.round(strength[: question.fitted], 6))
    if len(levels) <= _MOST_LEVELS:  # single weights may be wrong
        for level in levels[levels > 0]:
            yield Term("payload", "payload_mass_error", under(wrench * np.isclose(strength, level, atol=1e-5)))
    if size == 2:
        yield Term("payload", "load_direction_tilt", under(np.column_stack([-wrench[:, 1], wrench[:, 0]])))
    else:
        for axis in np.eye(3):
            turned = np.hstack([np.cross(axis, force), np.cross(axis, wrench[:, 3:])])
            yield Term("payload", "load_direction_tilt", under(turned))
            rotation = question.robot.jacobians(question.everything.configurations).rotation[question.order]
            moment = np.cross(rotation @ axis, force)
            yield Term("payload", "payload_com_offset", under(np.hstack([np.zeros_like(force), moment])))
    place = question.robot.position(question.everything.configurations)[question.order]
    away = place - place.mean(axis=0)
    loaded = np.ones(len(wrench))
    for direction in np.eye(size)[: min(size, 3)]:
        for factor in (loaded, *away.T):
            yield Term("environment", "law", under(direction * factor[:, None]))


def _instrument(question: Question) -> Iterator[Term]:
    deflection = _all_components(question)
    inputs = question.everything.configurations[question.order]
    inputs = inputs / np.maximum(np.abs(inputs).max(axis=0), 1e-12)
    size = deflection.shape[1]
    time, warming, _ = _history(question)
    for axis in range(size):
        alone = deflection * (np.arange(size) == axis)
        yield Term("instrument", "instrument_scale" if axis < 3 else "law", alone)
        for column in inputs.T:
            yield Term("instrument", "law", alone * column[:, None])
        for law in (warming, time):
            yield Term("environment", "thermal_drift", np.outer(law, np.arange(size) == axis))
    if size == 2:
        yield Term("instrument", "instrument_misalignment", np.column_stack([deflection[:, 1], -deflection[:, 0]]))
        return
    for axis3 in np.eye(3):
        turned = np.hstack([np.cross(deflection[:, :3], axis3), np.cross(deflection[:, 3:], axis3)])
        yield Term("instrument", "instrument_misalignment", turned)


def _all_components(question: Question) -> Array:
    """Deflections by the robot file's stiffness, of the components that are not measured as well."""
    pose, _, forces = question.maps_all()
    return np.asarray(np.einsum("rij,rj->ri", pose, forces / question.robot.stiffness))


class Library:
    """Whitened terms as columns, freed of what the base model can do."""

    def __init__(self, question: Question) -> None:
        axes, count = question.recordings.axes, question.fitted
        every = list(terms(question))
        columns = np.stack([term.change[:, axes] / question.std_all for term in every], axis=2)
        seen = columns[:count].reshape(-1, len(every))
        kept = np.isfinite(seen).all(axis=0) & (np.linalg.norm(seen, axis=0) > 1e-9)
        kept[kept] = _first_of_alike(seen[:, kept])
        self.terms = [term for term, good in zip(every, kept, strict=True) if good]
        self.columns = columns[:, :, kept] / np.linalg.norm(seen[:, kept], axis=0)
        self.base = question.base_all() / question.std_all[:, :, None]
        self.targets = question.recordings.deflections / question.std

    def selected(self, rows: Rows, optimiser: BaseOptimizer) -> list[int]:
        """Terms that the optimiser keeps on some recordings."""
        base, columns = _flat(self.base[rows]), _flat(self.columns[rows])
        basis = np.linalg.qr(base)[0]
        freed = columns - basis @ (basis.T @ columns)
        norms = np.maximum(np.linalg.norm(freed, axis=0), 1e-9)
        usable = norms > 0.02  # else the base model can do it as well
        targets = self.targets[rows].ravel()
        targets = targets - basis @ (basis.T @ targets)
        optimiser.fit(freed[:, usable] / norms[usable], targets[:, None])
        return [int(index) for index in np.flatnonzero(usable)[np.flatnonzero(optimiser.coef_[0])]]

    def coefficients(self, rows: Rows, chosen: list[int]) -> Array:
        """Least squares of base model and chosen terms together, the latter with a small ridge."""
        left = np.hstack([_flat(self.base[rows]), _flat(self.columns[rows][:, :, chosen])])
        ridge = np.sqrt(_RIDGE) * np.eye(left.shape[1])[self.base.shape[2] :]
        targets = np.concatenate([self.targets[rows].ravel(), np.zeros(len(chosen))])
        return np.asarray(np.linalg.lstsq(np.vstack([left, ridge]), targets, rcond=1e-12)[0])

    def predicted(self, chosen: list[int], coefficients: Array) -> Array:
        """Whitened readings of all rows (rows x components)."""
        return np.concatenate([self.base, self.columns[:, :, chosen]], axis=2) @ coefficients


def _first_of_alike(columns: Array) -> NDArray[np.bool_]:
    """Marks columns that are no multiple of one before them; orthogonalising optimisers fail on these."""
    unit = columns / np.linalg.norm(columns, axis=0)
    alike = np.abs(unit.T @ unit) > 1 - 1e-6
    return ~np.triu(alike, 1).any(axis=0)


def _flat(block: Array) -> Array:
    return block.reshape(block.shape[0] * block.shape[1], block.shape[2])


def optimisers() -> list[BaseOptimizer]:
    """PySINDy's, over the grid of their settings."""
    found: list[BaseOptimizer] = [FROLS(max_iter=size, alpha=1e-6) for size in _SIZES]
    return found + [STLSQ(threshold=t, alpha=a, max_iter=30) for t in _THRESHOLDS for a in _PENALTIES]


def solve(question: Question) -> Reply:
    """The terms whose left-out error is least."""
    warnings.simplefilter("ignore")
    base, mismatch = question.base_prediction(), question.mismatch()
    if not mismatch:
        return Reply(base, mismatch)
    library, count = Library(question), question.fitted
    rows = np.arange(count)
    folds = list(GroupKFold(min(4, len(np.unique(question.groups)))).split(rows, groups=question.groups))
    best, least = None, _left_out(library, None, folds)
    for optimiser in optimisers():
        error = _left_out(library, optimiser, folds)
        if error < least:
            best, least = optimiser, error
    if best is None:
        return Reply(base, mismatch)
    try:
        chosen = library.selected(rows, best)
    except ValueError:
        return Reply(base, mismatch)
    coefficients = library.coefficients(rows, chosen)
    own = coefficients[library.base.shape[2] :]
    predicted = library.predicted(chosen, coefficients) * question.std_all
    return Reply(predicted, mismatch, *_named(library, chosen, own, count))


def _left_out(library: Library, optimiser: BaseOptimizer | None, folds: list[tuple[Rows, Rows]]) -> float:
    """Sum of squares of left-out readings, of the base model alone without an optimiser.

    Infinite where the optimiser fails or keeps more than the data can bear.
    """
    error = 0.0
    for train, test in folds:
        try:
            chosen = [] if optimiser is None else library.selected(train, optimiser)
        except ValueError:  # PySINDy's optimisers do not take columns that have become dependent
            return np.inf
        if len(chosen) > library.targets[train].size // 3:
            return np.inf
        predicted = library.predicted(chosen, library.coefficients(train, chosen))[test]
        error += float(((library.targets[test] - predicted) ** 2).sum())
    return error


def _named(library: Library, chosen: list[int], own: Array, count: int) -> tuple[list[str], list[tuple[str, float]]]:
    """Components and physics, by the sum of squares of what their terms together contribute to the recordings."""
    places: dict[str, Array] = {}
    names: dict[str, Array] = {}
    for index, coefficient in zip(chosen, own, strict=True):
        term, part = library.terms[index], library.columns[:count, :, index] * coefficient
        places[term.component] = places.get(term.component, 0.0) + part
        if term.physics != "law":
            names[term.physics] = names.get(term.physics, 0.0) + part
    by_size = {name: float((part**2).sum()) for name, part in places.items()}
    named = sorted(names, key=lambda name: -float((names[name] ** 2).sum()))
    return sorted(by_size, key=lambda name: -by_size[name]), [(name, 1.0) for name in named]


if __name__ == "__main__":
    main(solve, __doc__)
