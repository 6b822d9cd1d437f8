"""Small recordings of random experiments, as a diagnosis sees them."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from expdesign.chain.chain import Chain
from expdesign.chain.component import component_from_text
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import row_data
from expdesign.estimation.fit import Data, Fit, fit
from tests.cases import robot
from tests.chain.kinds import KINDS
from tests.chain.places import rows
from tests.fitting import data_of
from tests.identification.experiments import read
from tests.oracle import Array


def effect(name: str, physics: str, component: str, variant: str = "") -> Effect:
    """An effect of the library by its name."""
    where = component_from_text(component)
    kind = next(kind for kind in KINDS if kind.physics == physics and where in kind.components(robot(name)))
    return kind.from_text(robot(name), component, variant)


@cache
def _exact(name: str, effects: tuple[Effect, ...], parameters: tuple[float, ...], series: int) -> Recordings:
    """What the chain says of free wrenches, or of payloads for effects of a payload."""
    load = "payload" if any(str(e.component) == "payload" for e in effects) else "wrench"
    here, frame = robot(name), rows(name, load, series=series)
    frame = frame[[column for column in frame if not str(column).startswith("abs_")]]
    recordings = read(frame, here)
    chain = Chain(here, effects)
    values = np.concatenate([np.ones(chain.compliances), parameters])
    return replace(recordings, deflections=chain.predict(row_data(recordings, here), values))


def simulated(
    name: str,
    *effects: Effect,
    parameters: Sequence[float] = (),
    seed: int = 0,
    noise: float = 1.0,
    series: int = 6,
) -> Recordings:
    """Recordings of a robot of the table, with `noise` times the noise that they state."""
    exact = _exact(name, effects, tuple(parameters), series)
    scatter = np.random.default_rng(seed).standard_normal(exact.deflections.shape)
    return replace(exact, deflections=exact.deflections + noise * np.array(exact.deviations) * scatter)


def sample_of(name: str, recordings: Recordings, counts: Array | None = None) -> Data:
    """All rows, or some."""
    return replace(data_of(recordings, robot(name)), marked=counts)


def base_fit(name: str, sample: Data) -> Fit:
    """The base model's fit."""
    return fit(Chain(robot(name)), sample)
