"""The machines of the closed loop do what the chain's effects of the same name do, by mechanics of their own."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from benchmarks.model_error.arm import ArmFactory, ArmMachine, Hidden
from benchmarks.model_error.hexapod import HexapodFactory, HexapodMachine
from benchmarks.model_error.machine import Concealed, Machine
from benchmarks.model_error.prior import Prior, compliance
from benchmarks.model_error.trial import plan_of_decisions
from tests.model_error.problems import CONFIGS

from expdesign.assurance.model_error.left_out import plan_points
from expdesign.assurance.model_error.meir import Meir
from expdesign.assurance.model_error.settings import Assumptions
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.effects.actuators.actuators import FrictionHysteresis
from expdesign.chain.effects.base.compliance import BaseCompliance
from expdesign.chain.effects.joints.off_axis_compliance import JointCompliance
from expdesign.chain.effects.joints.play import JointBacklash
from expdesign.chain.effects.legs.passive_joints import PassiveJointCompliance
from expdesign.chain.effects.platform.compliance import PlatformCompliance
from expdesign.chain.row import row_data
from expdesign.planning.plan import plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.start import starting_designs
from virtual_laboratory import Robot, elements

UPPER = np.triu_indices(6, 1)
RNG = np.random.default_rng(2)
SOFT = compliance(np.array([2e-8, 2e-8, 4e-9, 3e-7, 3e-7, 4e-7]), RNG)
YIELDING = compliance(np.array([8e-7, 2e-6, 4e-6, 3e-5, 4e-5, 3e-5]) / 10.0, RNG)


@cache
def problem(name: str) -> DesignProblem:
    return read_problem(CONFIGS / f"closed-loop-model-error{name}.yaml")


def machine(name: str, hidden: Any) -> Machine:
    case = problem(name)
    stiffness = case.loaded.robot.stiffness
    if name:
        return ArmMachine(case, stiffness, hidden or Hidden(), Concealed())
    elements = [] if hidden is None else [hidden]
    return HexapodMachine(case, Robot.from_mapping(case.config["robot"]), stiffness, elements, Concealed())


def gained(name: str, hidden: Any, effect: Effect, values: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """What an effect adds to the deflections: by the machine's mechanics, and by the chain."""
    case = problem(name)
    decisions = starting_designs(case, 1, RNG).reshape(-1, case.space.measurements, case.space.decisions)[0]
    plan = plan_of_decisions(case, decisions)
    rows = plan_frame(plan, case.loaded, False)
    names = list(case.loaded.robot.coordinates.deflection)
    found, without = (machine(name, each).measured(rows, 1)[names].to_numpy() for each in (hidden, None))
    data = row_data(plan_points(case.loaded, plan.configurations, plan.loads), case.loaded.robot)
    base = np.ones(len(case.loaded.robot.stiffness))
    chain = Chain(case.loaded.robot, (effect,))
    expected = chain.predict(data, np.concatenate([base, values])) - Chain(case.loaded.robot).predict(data, base)
    return found - without, expected


def entries(matrix: np.ndarray) -> list[float]:
    """Parameters of a full symmetric compliance."""
    return [*np.diag(matrix), *matrix[UPPER]]


def in_hexapod(kind: type[Effect], component: str, variant: str = "") -> Effect:
    return kind.from_text(problem("").loaded.robot, component, variant)


def in_arm(kind: type[Effect], component: str, variant: str = "") -> Effect:
    return kind.from_text(problem("-arm").loaded.robot, component, variant)


def cases() -> list[Any]:
    stiff = np.array(np.linalg.inv(SOFT).tolist())
    radial = np.diag([4e-8, 1e-8, 1e-13])
    return [
        pytest.param("", elements.PlatformCompliance(stiff), in_hexapod(PlatformCompliance, "platform", "full"),
                     entries(SOFT), id="soft platform"),
        pytest.param("", elements.BaseCompliance(stiff), in_hexapod(BaseCompliance, "base", "full"), entries(SOFT),
                     id="soft base"),
        pytest.param("", elements.PassiveJointCompliance("leg 2", np.linalg.inv(radial), "base", "frame"),
                     in_hexapod(PassiveJointCompliance, "leg 2", "base"), [4e-8, 1e-8, 0.0, 0.0, 0.0],
                     id="soft joint of a leg"),
        pytest.param("-arm", Hidden(tool=YIELDING), in_arm(PlatformCompliance, "platform", "full"), entries(YIELDING),
                     id="soft tool mount"),
        pytest.param("-arm", Hidden(base=YIELDING), in_arm(BaseCompliance, "base", "full"), entries(YIELDING),
                     id="soft pedestal"),
        pytest.param("-arm", Hidden(tilts={2: 5e-6}), in_arm(JointCompliance, "joint 3"), [5e-6], id="bearing"),
        pytest.param("-arm", _law("joint_backlash", 2e-4, 5), in_arm(JointBacklash, "joint 6", "middle"), [2e-4],
                     id="play"),
        pytest.param("-arm", _law("friction_hysteresis", 0.3, 4), in_arm(FrictionHysteresis, "joint 5", "rigid"), [0.3],
                     id="friction"),
    ]  # fmt: skip


class _Sized(Prior):
    """A prior whose draws have one magnitude."""

    def __init__(self, size: float) -> None:
        self.size = size

    def positive(self, physics: str, component: str, begin: str, generator: np.random.Generator) -> float:
        return self.size


def _law(physics: str, size: float, joint: int) -> Hidden:
    factory = ArmFactory(problem("-arm"), _Sized(size))
    spring = 1.0 / problem("-arm").loaded.robot.stiffness[joint]
    return Hidden(laws={joint: factory.law(physics, f"joint {joint + 1}", spring, np.random.default_rng(0))})


@pytest.mark.parametrize(("name", "hidden", "effect", "values"), cases())
def test_as_the_effect_of_the_chain(name: str, hidden: Any, effect: Effect, values: list[float]) -> None:
    found, expected = gained(name, hidden, effect, values)
    scale = np.abs(expected).max(axis=0)
    assert scale.max() > 0.0
    # The machines' displacements are large: what differs is the change of the lever arms, per mille of an effect.
    assert np.abs(found - expected).max(axis=0) == pytest.approx(np.zeros(6), abs=2e-2 * scale.max())


@pytest.mark.parametrize("name", ["", "-arm"])
def test_every_kind_can_be_drawn_and_measured(name: str) -> None:
    case = problem(name)
    kinds = ArmFactory.kinds if name else HexapodFactory.kinds
    impact = Meir(case, Assumptions(physics=frozenset(kinds)))
    factory = (ArmFactory if name else HexapodFactory)(case, Prior(impact))
    decisions = starting_designs(case, 1, RNG).reshape(-1, case.space.measurements, case.space.decisions)[0]
    rows = plan_frame(plan_of_decisions(case, decisions), case.loaded, False)
    names = list(case.loaded.robot.coordinates.deflection)
    none = factory.machine("", case.loaded.robot.stiffness, RNG).measured(rows, 1)[names].to_numpy()
    for physics in kinds:
        drawn = factory.machine(physics, case.loaded.robot.stiffness, np.random.default_rng(5))
        assert drawn.concealed.physics == physics
        found = drawn.measured(rows, 1)[names].to_numpy()
        assert np.isfinite(found).all()
        assert np.abs(found - none).max() < 0.05 or physics == "instrument_scale"
