"""Every effect at every place, and rows on which all of them show."""

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import pandas as pd

from expdesign.chain.chain import Chain
from expdesign.chain.component import Component
from expdesign.chain.declaration import Variant
from expdesign.chain.effect import Effect
from expdesign.chain.recordings.recordings import Recordings
from expdesign.mechanics.robots.robot import Robot
from tests.cases import ROBOTS, robot
from tests.chain import bodies
from tests.chain.arm_rows import arm_rows, six_axis
from tests.chain.kinds import KINDS
from tests.identification.experiments import read
from tests.oracle import Array

PAYLOAD, WRENCH = "payload", "wrench"


def rows(name: str, load: str = PAYLOAD, seed: int = 0, series: int = 4, loads: int = 4) -> pd.DataFrame:
    """Series of loads under which nothing stands still: time, temperature of every leg, loads that come and go.

    Payloads are three weights at any place; wrenches are free and change a robot that was loaded before, under gravity
    that is not the robot's own.
    """
    generator = np.random.default_rng(seed)
    case, here = ROBOTS[name], robot(name)
    count = series * loads
    poses = np.repeat(case.poses(generator, series), loads, axis=0)
    columns: dict[str, Array] = {
        "sequence": np.arange(1, count + 1),
        "series": np.repeat(np.arange(1, series + 1), loads),
        "time_s": np.cumsum(generator.uniform(20.0, 80.0, count)),
    }
    columns |= {column: poses[:, i] for i, column in enumerate(here.configuration)}
    if load == PAYLOAD:
        columns["mass_kg"] = case.mass * generator.permuted(np.resize([0.3, 1.0, 0.6], count))
        columns["mass_kg"][::loads] = 0.0
        for axis in here.coordinates.centre_of_mass:
            columns[axis] = case.lever * generator.uniform(-2.0, 2.0, count)
    else:
        wrenches, before = case.wrenches(generator, count), case.wrenches(generator, count)
        columns |= {column: wrenches[:, i] for i, column in enumerate(here.coordinates.wrench)}
        whole = wrenches + 0.5 * before
        columns |= {f"abs_{column}": whole[:, i] for i, column in enumerate(here.coordinates.wrench)}
        columns |= {
            column: here.gravity[i] + generator.uniform(-2.0, 2.0, count)
            for i, column in enumerate(here.coordinates.gravity)
        }
    columns |= {f"leg{i + 1}_degC": 20.0 + generator.uniform(-3.0, 3.0, count) for i in range(len(here.stiffness))}
    columns |= {column: np.full(count, 0.0) for column in here.coordinates.deflection}
    columns |= {
        column: np.full(count, deviation)
        for column, deviation in zip(here.coordinates.deviation, case.deviation, strict=True)
    }
    return pd.DataFrame(columns)


ARM, SUPPORTED = "arm", "body"
"""Machines beside the robots of the table: the six-axis arm of the configurations, and a body that lifts."""


def machine(name: str) -> Robot:
    """A robot of the table, the arm, or the body."""
    return {ARM: six_axis, SUPPORTED: lambda: bodies.BODY}.get(name, lambda: robot(name))()


@cache
def recordings(name: str, load: str = PAYLOAD) -> Recordings:
    """The rows as the reader gives them, made once."""
    if name == ARM:
        return read(arm_rows(six_axis(), series=5, loads=3, sideways=True), six_axis())
    return bodies.recordings(lifting=True) if name == SUPPORTED else read(rows(name, load), robot(name))


@dataclass(frozen=True)
class Place:
    """One effect at one place of a robot of the table."""

    name: str
    kind: type[Effect]
    component: Component
    variant: Variant

    @property
    def robot(self) -> Robot:
        return machine(self.name)

    def effect(self) -> Effect:
        return self.kind(self.robot, self.component, self.variant)

    @cached_property
    def chain(self) -> Chain:
        """The base model with this effect alone."""
        return Chain(self.robot, (self.effect(),))

    def __str__(self) -> str:
        return f"{self.name}: {self.effect().key}"


@cache
def places(name: str) -> list[Place]:
    """Everything that the library offers for payloads on a robot."""
    here, points = machine(name), recordings(name)
    return [Place(name, kind, component, variant) for kind in KINDS for component, variant in kind.places(here, points)]


def one_of_each(name: str, ends: tuple[int, ...] = (0, -1)) -> list[Place]:
    """The first and the last place of every physics and variant, or one of them."""
    found: dict[tuple[str, str], list[Place]] = {}
    for place in places(name):
        # `force of leg 2` and `99.8 newton` are the same variant as at other legs and loads.
        form = " ".join(word for word in str(place.variant).split() if not word[0].isdigit())
        found.setdefault((place.kind.physics, form), []).append(place)
    return [place for same in found.values() for place in dict.fromkeys(same[end] for end in ends)]


ON_LEGS = [*one_of_each("irregular", (-1,)), *one_of_each("bipod-unequal", (0,))]
"""On the last leg of one robot, and on the first of the other."""
BEYOND_LEGS = [place for name in (ARM, SUPPORTED) for place in one_of_each(name)]


def away_from_neutral(chain: Chain, seed: int = 1) -> Array:
    """Parameters (p,) some way from neutral, within their bounds, compliances a little off."""
    generator = np.random.default_rng(seed)
    shift = chain.scales() * generator.uniform(0.2, 0.8, len(chain.parameters))
    values = chain.start() + shift
    values[: chain.compliances] = generator.uniform(0.8, 1.25, chain.compliances)
    low, high = chain.bounds()
    values = np.where(values < high, values, chain.start() - shift)
    assert ((values > low) & (values < high)).all()
    return values
