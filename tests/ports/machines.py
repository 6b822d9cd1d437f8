"""Machines with physics that the library does not hold, for tests of laws at ports."""

from collections.abc import Callable

import casadi as ca
import numpy as np

from expdesign.chain.chain import Chain
from expdesign.chain.component import Component, Part
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.recordings.recordings import Recordings
from expdesign.chain.row import Row, row_data
from expdesign.mechanics.robots.robot import Robot
from tests.cases import ROBOTS, robot
from tests.chain.places import rows
from tests.identification.experiments import read

BIPOD = "bipod"
LEG_1 = Component(Part.LEG, 1)


class Foreign(Effect):
    """An elongation of leg 1 that is any function of a row and its force."""

    physics = "foreign"

    def __init__(self, robot: Robot, law: Callable[[Row, ca.SX], ca.SX]) -> None:
        self.law = law
        super().__init__(robot, LEG_1)

    def describe(self) -> tuple[Parameter, ...]:
        return ()

    @classmethod
    def components(cls, robot: Robot) -> list[Component]:
        return [LEG_1]

    def actuator(
        self, elongation: ca.SX, force: ca.SX, compliance: ca.SX, row: Row, state: ca.SX, theta: ca.SX
    ) -> tuple[ca.SX, ca.SX]:
        changed = ca.SX(elongation)
        changed[0] += compliance[0] * self.law(row, force[0])
        return changed, state


def lengths_of_leg_1(name: str = BIPOD, series: int = 24) -> tuple[float, float]:
    """Mean and standard deviation of the length of leg 1 over the poses of `recordings_of`."""
    here = robot(name)
    values = here.lengths(read(rows(name, "wrench", series=series), here).configurations)[:, 0]  # type: ignore[attr-defined]
    return float(values.mean()), float(values.std())


def softened(name: str = BIPOD, by: float = 0.4, series: int = 24) -> Callable[[Row, ca.SX], ca.SX]:
    """Leg 1 is softer near its middle length: by 40 % there, less a standard deviation away."""
    middle, spread = lengths_of_leg_1(name, series)
    return lambda row, force: by * ca.exp(-0.5 * ((row.lengths[0] - middle) / (0.7 * spread)) ** 2) * force


def recordings_of(
    law: Callable[[Row, ca.SX], ca.SX] | None, name: str = BIPOD, seed: int = 0, series: int = 24
) -> Recordings:
    """Recordings of free wrenches with the noise that they state."""
    here = robot(name)
    frame = rows(name, "wrench", series=series)
    frame = frame[[column for column in frame if not str(column).startswith("abs_")]]
    recordings = read(frame, here)
    chain = Chain(here, () if law is None else (Foreign(here, law),))
    exact = chain.predict(row_data(recordings, here), np.ones(chain.compliances))
    scatter = np.random.default_rng(seed).standard_normal(exact.shape) * np.array(ROBOTS[name].deviation)
    values = {**vars(recordings), "deflections": (exact + scatter)[:, recordings.axes]}
    return type(recordings)(**values)
