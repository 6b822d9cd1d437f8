"""Hexapods in the virtual laboratory that hide one effect of the size that MEIR assumes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
from numpy.random import Generator

from expdesign.arrays import FloatArray
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.planning.problem import DesignProblem
from virtual_laboratory import Laboratory, Robot
from virtual_laboratory.elements import (
    BaseCompliance,
    Element,
    EncoderPeriodicError,
    FrictionHysteresis,
    InstrumentMisalignment,
    InstrumentScale,
    LegBacklash,
    LegCoupling,
    LegNonlinearStiffness,
    LoadDirectionTilt,
    PassiveJointCompliance,
    PayloadComOffset,
    PlatformCompliance,
)
from virtual_laboratory.loads import Load

from .machine import Concealed
from .prior import Prior, compliance

PAYLOAD = ["mass_kg", "com_x_m", "com_y_m", "com_z_m"]
_ALL = "all legs"
_RIGID = 1e9
_PITCHES = (1e-3, 1e-2)
"""m; pitches of screws, drawn between them with equal probability of their logarithm."""
_REFERENCE = 100.0
"""N; the force to which the sizes of springs that are not linear refer."""


@dataclass(frozen=True)
class OneWeight(Element):
    """One weight of the shelf is heavier than is written on it, wherever it is used."""

    identifier: ClassVar[str] = "payload_mass_error"
    weight_N: float
    relative: float

    def true_load(self, load: Load) -> Load:
        same = abs(float(np.linalg.norm(load.force)) - self.weight_N) < 0.01 * self.weight_N
        return load.scaled(1.0 + self.relative) if same else load


class HexapodFactory:
    """Hexapods as a design problem describes them."""

    kinds: tuple[str, ...] = (
        "payload_com_offset", "payload_mass_error", "load_direction_tilt", "platform_compliance", "base_compliance",
        "passive_joint_compliance", "leg_coupling", "leg_nonlinear_stiffness", "leg_backlash", "friction_hysteresis",
        "encoder_periodic_error", "instrument_misalignment", "instrument_scale",
    )  # fmt: skip
    place = "in the virtual laboratory"

    def __init__(self, problem: DesignProblem, prior: Prior) -> None:
        self.problem, self.prior = problem, prior
        self.robot = Robot.from_mapping(problem.config["robot"])

    def machine(self, physics: str, stiffness: FloatArray, generator: Generator) -> HexapodMachine:
        if not physics:
            return HexapodMachine(self.problem, self.robot, stiffness, [], Concealed())
        element, components = self._drawn(physics, stiffness, generator)
        return HexapodMachine(self.problem, self.robot, stiffness, [element], Concealed(physics, components))

    def _drawn(self, physics: str, stiffness: FloatArray, rng: Generator) -> tuple[Element, tuple[str, ...]]:
        if physics.startswith("leg_") or physics in ("passive_joint_compliance", "friction_hysteresis"):
            return self._in_a_leg(physics, stiffness, rng)
        if physics == "encoder_periodic_error":
            leg = self._leg(rng)
            amplitude = float(np.linalg.norm(self.prior.normal(physics, leg, "", rng)))
            pitch = float(np.exp(rng.uniform(*np.log(_PITCHES))))
            return EncoderPeriodicError(leg, amplitude, pitch, rng.uniform(0.0, 2.0 * np.pi)), (leg,)
        if physics in ("platform_compliance", "base_compliance"):
            component = physics.split("_", maxsplit=1)[0]
            sizes = self.prior.sizes(physics, component, "compliance_")[:6]
            kind = PlatformCompliance if component == "platform" else BaseCompliance
            return kind(np.linalg.inv(compliance(sizes, rng))), (component,)
        if physics.startswith("instrument_"):
            instrument = InstrumentMisalignment if physics == "instrument_misalignment" else InstrumentScale
            return instrument(*self.prior.normal(physics, "instrument", "", rng)), ("instrument",)
        return self._in_the_load(physics, rng), ("payload",)

    def _in_the_load(self, physics: str, rng: Generator) -> Element:
        if physics == "payload_com_offset":
            return PayloadComOffset(*self.prior.normal(physics, "payload", "com_", rng))
        if physics == "load_direction_tilt":
            return LoadDirectionTilt(*self.prior.normal(physics, "payload", "tilt_", rng))
        masses = np.array(self.problem.config["experiment"]["load"]["mass_kg"]["choices"])
        weight = float(rng.choice(masses) * np.linalg.norm(self.problem.loaded.robot.gravity))
        return OneWeight(weight, float(self.prior.normal(physics, "payload", "relative_", rng)[0]))

    def _in_a_leg(self, physics: str, stiffness: FloatArray, rng: Generator) -> tuple[Element, tuple[str, ...]]:
        leg = self._leg(rng)
        if physics == "leg_backlash":
            rest = str(rng.choice(["middle", "short", "long"]))
            return LegBacklash(leg, self.prior.positive(physics, leg, "gap", rng), rest), (leg,)
        if physics == "friction_hysteresis":
            where = _ALL if rng.random() < 1.0 / 7.0 else leg
            return FrictionHysteresis(where, self.prior.positive(physics, where, "friction", rng)), (where,)
        if physics == "passive_joint_compliance":
            matrix = compliance(self.prior.sizes(physics, leg, "compliance_")[:1].repeat(3), rng)
            end = str(rng.choice(["base", "platform"]))
            return PassiveJointCompliance(leg, np.linalg.inv(matrix), end, "frame"), (leg,)
        if physics == "leg_coupling":
            first, second = sorted(rng.choice(6, 2, replace=False) + 1)
            legs = (f"leg {first}", f"leg {second}")
            mount = np.full((6, 6), 0.0)
            mount[3:, 3:] = _RIGID * np.eye(3)
            mount[:3, :3] = np.linalg.inv(compliance(self.prior.sizes(physics, leg, "")[:1].repeat(3), rng))
            return LegCoupling([int(first), int(second)], mount), legs
        return self._nonlinear(leg, stiffness, rng), (leg,)

    def _nonlinear(self, leg: str, stiffness: FloatArray, rng: Generator) -> Element:
        physics = "leg_nonlinear_stiffness"
        if rng.random() < 0.5:
            beyond = self.prior.positive(physics, leg, "hertz", rng)
            return LegNonlinearStiffness(leg, "hertz", contact_m_per_N23=beyond / _REFERENCE ** (2.0 / 3.0))
        # ±a·|F| beside the linear spring: 2·a softer one way than the other.
        beyond = float(np.clip(self.prior.normal(physics, leg, "asymmetric", rng)[0], -2e-5, 2e-5))
        change = 1.0 / max(1.0 - 2.0 * beyond * stiffness[int(leg[4:]) - 1] / _REFERENCE, 0.2) - 1.0
        return LegNonlinearStiffness(leg, "bilinear", relative_change=change)

    def _leg(self, rng: Generator) -> str:
        return f"leg {rng.integers(6) + 1}"


class HexapodMachine:
    """One hexapod in the virtual laboratory."""

    def __init__(
        self,
        problem: DesignProblem,
        robot: Robot,
        stiffness: FloatArray,
        elements: list[Element],
        concealed: Concealed,
    ) -> None:
        self.problem, self.robot, self.stiffness, self.elements = problem, robot, stiffness, elements
        self.concealed = concealed

    def measured(self, rows: pd.DataFrame, seed: int) -> pd.DataFrame:
        noise, coordinates = self.problem.noise, self.problem.loaded.robot.coordinates
        names = [coordinates.deflection[axis] for axis in noise.axes]
        deviations = dict(zip(names, np.sqrt(np.diag(noise.covariance)).tolist(), strict=True))
        laboratory = Laboratory(
            self.robot, true_stiffness=self.stiffness, elements=self.elements, noise_std=deviations, seed=seed
        )
        return laboratory.measure(rows)

    def errors(self, commands: FloatArray, targets: LoadedPoints) -> FloatArray:
        rows = pd.DataFrame(commands, columns=list(self.problem.loaded.robot.configuration))
        assert targets.payload is not None
        rows[PAYLOAD] = targets.payload
        laboratory = Laboratory(self.robot, true_stiffness=self.stiffness, elements=self.elements)
        attained: FloatArray = laboratory.attained(rows).to_numpy()
        return attained - targets.configurations
