"""Declared errors of the recorded loads: what they do to the readings, and the model's term of each (theory.md 5.6).

A scale that is off by 20 g, or a centre of mass by a millimetre, moves all readings under those weights together. Such
errors are declared by a configuration (`experiment.load_error`) or by the recordings' own columns (`error_mass_kg` …).
They are terms of the fit with a normal prior (`gaussian.py`): errors that rows share as nuisance parameters, errors
that every row has for itself in its covariance. Their columns are D(ĉ)·L with the present compliance.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.recordings.load_errors import error_columns
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.errors import InputError
from expdesign.estimation.whitening import LoadColumns
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.mechanics.loads.errors.source import CentreOfMassError, LoadErrorSource, MassError, WrenchError
from expdesign.mechanics.loads.load import Payload, Wrench
from expdesign.mechanics.robots.robot import Robot

Estimator = Literal["generalised", "weighted"]
"""Whether least squares weigh the declared load errors as well as the noise, or the noise alone (theory.md 3, 5.6)."""

_AGREE = 1e-6
"""Relative difference of two declarations of one error below which they are the same."""


@dataclass(frozen=True)
class LoadEffect:
    """One source of load error, of one set of weights, and what it does to the readings.

    Attributes:
        source: `mass`, `com`, `direction` or `wrench`.
        unit: of its components.
        deviation: declared standard deviations, shape (d,).
        shared: whether rows share it; else every row has its own.
        weight: name of the weights it belongs to; empty for those of all rows.
        moved: change of the readings (m, rad) per standard deviation, shape (N, k, d).
    """

    source: str
    unit: str
    deviation: FloatArray
    shared: bool
    weight: str
    moved: FloatArray

    @property
    def name(self) -> str:
        """Unique among the effects of one fit."""
        return f"{self.source} of {self.weight}" if self.weight else self.source


@dataclass(frozen=True)
class DeclaredLoadErrors:
    """The load errors of a configuration, of recordings, or of both.

    Attributes:
        loaded: the robot under the load of the configuration, with its sources of load error; None without one.
        source: the configuration.
        stated: sources of the configuration that the recordings state as well, in the same size.
    """

    loaded: LoadedRobot | None
    source: str
    stated: frozenset[str] = frozenset()

    def effects(self, chain: Chain, values: FloatArray, recorded: Recordings) -> tuple[LoadEffect, ...]:
        """What every source does to the readings of a chain at parameters (p,).

        Raises:
            InputError: the errors are of another kind of load than was recorded.
        """
        rotation = chain.robot.jacobians(recorded.configurations).rotation
        found = []
        if self.loaded is not None:
            wrenches = self.loaded.load_errors(rotation, self._loads(recorded))
            for source, changes in zip(self.loaded.sources, wrenches, strict=True):
                if source.source not in self.stated:
                    moved = _readings(chain, values, recorded, changes)
                    found.append(LoadEffect(source.source, source.unit, source.deviation, source.shared, "", moved))
        for source, changes, weight in _stated(chain.robot, recorded, rotation):
            moved = _readings(chain, values, recorded, changes)
            found.append(LoadEffect(source.source, source.unit, source.deviation, True, weight, moved))
        return tuple(found)

    def _loads(self, recorded: Recordings) -> FloatArray:
        """Parameters of the recorded loads, of the kind that the errors are of, shape (N, p)."""
        assert self.loaded is not None
        if not self.loaded.load.has_mass:
            return recorded.wrenches
        if recorded.payload is None:
            what = "the load errors of the configuration are those of a payload, and the recordings have wrenches"
            remedy = "Record mass_kg and the centre of mass, or use a configuration with `kind: wrench`."
            raise InputError(what, where=recorded.source, remedy=remedy)
        return np.concatenate([recorded.payload, recorded.gravity], axis=1)


def declared_load_errors(
    robot: Robot, recordings: Recordings, configured: DeclaredLoadErrors | None
) -> DeclaredLoadErrors | None:
    """The errors that the configuration and the recordings declare; None where neither does.

    Raises:
        InputError: both declare one error, and not in the same size or scope.
    """
    if recordings.errors is None:
        return configured
    if configured is None or configured.loaded is None:
        return DeclaredLoadErrors(None, recordings.source)
    own = {source.source: source for source in configured.loaded.sources}
    same = set()
    for source, _, weight in _stated(robot, recordings, robot.jacobians(recordings.configurations).rotation):
        other = own.get(source.source)
        if other is None:
            continue
        if not other.shared or not np.allclose(other.deviation, source.deviation, rtol=_AGREE, atol=0.0):
            column = next(c for c in error_columns(robot.coordinates) if c in _columns_of(source, robot))
            what = (
                f"the {source.source} error is {_listed(source.deviation)} {source.unit}"
                f"{f' of weight `{weight}`' if weight else ''} in the column {column}, and {_listed(other.deviation)}"
                f"{'' if other.shared else ' in every row by itself'} in {configured.source}, experiment.load_error"
            )
            where = f"{recordings.source}, column {column}"
            raise InputError(what, where=where, remedy="State one of them, or the same in both.")
        same.add(source.source)
    return replace(configured, stated=frozenset(same))


def _listed(deviation: FloatArray) -> str:
    return ", ".join(f"{value:g}" for value in deviation)


def _columns_of(source: LoadErrorSource, robot: Robot) -> tuple[str, ...]:
    """Columns of recordings that declare a source."""
    names, centres = error_columns(robot.coordinates), len(robot.coordinates.centre_of_mass)
    return {"mass": names[:1], "com": names[1 : 1 + centres]}.get(source.source, names[1 + centres :])


def _stated(robot: Robot, recorded: Recordings, rotation: FloatArray) -> list[tuple[LoadErrorSource, FloatArray, str]]:
    """Sources that the recordings declare, their wrenches per standard deviation (N, n, d), and the weights' names."""
    if recorded.errors is None:
        return []
    loaded = (recorded.wrenches != 0.0).any(axis=1)
    labels = np.full(len(recorded), "") if recorded.weight is None else recorded.weight
    found: list[tuple[LoadErrorSource, FloatArray, str]] = []
    names, centres = error_columns(robot.coordinates), len(robot.coordinates.centre_of_mass)
    ends = (0, 1, 1 + centres, len(names))
    classes: tuple[type[MassError | CentreOfMassError | WrenchError], ...] = (MassError, CentreOfMassError, WrenchError)
    kinds = zip(classes, map(slice, ends[:-1], ends[1:]), strict=True)
    for kind, part in kinds:
        if np.isnan(recorded.errors[:, part]).all():
            continue
        for label in np.unique(labels[loaded]).tolist():
            rows = loaded & (labels == label)
            deviation = np.nan_to_num(recorded.errors[np.flatnonzero(rows)[0], part])
            source = kind(deviation, True)
            load = Payload(robot.coordinates) if recorded.payload is not None else Wrench(robot.coordinates)
            parameters = recorded.wrenches
            if recorded.payload is not None:
                parameters = np.concatenate([recorded.payload, recorded.gravity], axis=1)
            wrenches = LoadedRobot(robot, load, (source,)).load_errors(rotation, parameters)[0]
            found.append((source, np.where(rows[:, None, None], wrenches, 0.0), str(label)))
    return found


def _readings(chain: Chain, values: FloatArray, recorded: Recordings, changes: FloatArray) -> FloatArray:
    """Changes of the readings (N, k, d) by changes of the loads (N, n, d), halved between their two signs."""
    moved = np.empty((len(recorded), len(recorded.axes), changes.shape[-1]))
    for component in range(changes.shape[-1]):
        ends = []
        for sign in (0.5, -0.5):
            change = sign * changes[..., component]
            loads = replace(recorded, wrenches=recorded.wrenches + change, absolute=recorded.absolute + change)
            ends.append(chain.predict(row_data(loads, chain.robot), values))
        moved[..., component] = (ends[0] - ends[1])[:, recorded.axes]
    return moved


def shared_parts(effects: Sequence[LoadEffect]) -> list[slice]:
    """Where each effect stands among the columns of the shared ones; nothing of an effect that rows do not share."""
    ends = np.cumsum([len(effect.deviation) * effect.shared for effect in effects]).tolist()
    return [slice(end - len(e.deviation) * e.shared, end) for e, end in zip(effects, ends, strict=True)]


def load_columns(effects: Sequence[LoadEffect], scales: FloatArray) -> LoadColumns:
    """The columns of all effects, their standard deviations multiplied by `scales`, one of every effect."""
    shape = (*effects[0].moved.shape[:2], 0)
    shared = [scale * e.moved for e, scale in zip(effects, scales, strict=True) if e.shared]
    own = [scale * e.moved for e, scale in zip(effects, scales, strict=True) if not e.shared]
    return LoadColumns(
        np.concatenate([np.empty(shape), *shared], axis=2), np.concatenate([np.empty(shape), *own], axis=2)
    )
