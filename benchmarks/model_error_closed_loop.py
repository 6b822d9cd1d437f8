"""Is a plan that bounds MEIR worth it? Machines that hide physics, from the plan to the error at the targets.

    python -m benchmarks.model_error_closed_loop configs/closed-loop-model-error.yaml --out results/model-error/hexapod
    python -m benchmarks.model_error_closed_loop configs/closed-loop-model-error-arm.yaml --out results/model-error/arm

Every machine is another one: its stiffness is scattered, and it hides one effect whose kind goes round the list, whose
component is drawn, and whose parameters are normal with the prior sizes of MEIR. It is not the program's model but an
independent mechanics engine. Each plan is measured, the recordings are diagnosed, the robot is compensated with what
was found, and the error at the targets is that of the engine. All plans have as many measurements. Plans meet the same
machines; the random plans are drawn anew for each. Trials are kept as they come, so that a run can go on later.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from benchmarks.model_error.arm import ArmFactory
from benchmarks.model_error.hexapod import HexapodFactory
from benchmarks.model_error.machine import Factory
from benchmarks.model_error.prior import Prior
from benchmarks.model_error.tables import readme
from benchmarks.model_error.trial import Outcome, by_hand, outcome, plan_of_decisions, targets_of

from expdesign.assurance.model_error.planned import meir_of_problem
from expdesign.io.output import csv_text
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.search import search
from expdesign.planning.start import starting_designs

MORE = 0.05
"""Part of the least total error that the plan with MEIR bounded may cost."""
UNSOUGHT = frozenset({"joint_position_error", "passive_joint_stiffness"})
"""Physics of the unloaded robot, which geometric calibration has dealt with: the diagnosis is not offered it."""
BY_HAND = {
    "hexapod": [  # x, y, z, rx, ry, rz, mass, centre of mass: the middle, four tilts towards the load, high and turned
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0],
        [-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, -1.0, 0.0],
        [0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 1.0],
        [0.0, -1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, -1.0],
        [0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
    ],
    "serial": [  # six joints, mass, centre of mass (two): every joint at its middle and towards both ends
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0],
        [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0],
        [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0],
        [1.0, 1.0, 0.0, 0.0, -1.0, -1.0, 1.0, 1.0, 1.0],
        [-1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0],
        [0.0, 0.0, 1.0, -1.0, 0.0, 0.0, -1.0, -1.0, -1.0],
    ],
}
TOTAL, BOUNDED, HAND, RANDOM = "total", "total, MEIR bounded", "by hand", "random"


@dataclass(frozen=True)
class Setting:
    """What stays the same over all machines."""

    problem: DesignProblem
    factory: Factory
    plans: dict[str, Plan]
    scatter: float
    seed: int


def setting_of(config: Path, scatter: float, factor: float, seed: int) -> Setting:
    """The plans to compare, and machines of the class."""
    problem = read_problem(config)
    meir = meir_of_problem(problem)
    assert meir is not None, "MEIR has to be an objective"
    prior = Prior(meir, factor)
    kind = problem.loaded.robot.kind
    factory: Factory = HexapodFactory(problem, prior) if kind == "hexapod" else ArmFactory(problem, prior)
    front = search(problem)
    total, hidden = front.criteria["total"], front.criteria["meir"]
    affordable = np.flatnonzero(total <= (1.0 + MORE) * total.min())
    best, bounded = int(np.argmin(total)), int(affordable[np.argmin(hidden[affordable])])
    plans = {
        TOTAL: plan_of_decisions(problem, front.decisions[best]),
        BOUNDED: plan_of_decisions(problem, front.decisions[bounded]),
        HAND: by_hand(problem, np.array(BY_HAND[kind])),
    }
    return Setting(problem, factory, plans, scatter, seed)


def trials(setting: Setting, number: int, physics: str) -> list[tuple[str, Outcome, tuple[str, ...]]]:
    """All plans on one machine."""
    problem = setting.problem
    generator = np.random.default_rng([setting.seed, number])
    stiffness = problem.loaded.robot.stiffness
    true = stiffness * np.exp(setting.scatter * generator.standard_normal(len(stiffness)))
    machine = setting.factory.machine(physics, true, generator)
    drawn = starting_designs(problem, 1, generator).reshape(-1, problem.space.measurements, problem.space.decisions)
    plans = setting.plans | {RANDOM: plan_of_decisions(problem, drawn[0])}
    draw = int(generator.integers(2**31))
    targets = targets_of(problem)
    return [
        (name, outcome(problem, targets, machine, plan, draw, UNSOUGHT), machine.concealed.components)
        for name, plan in plans.items()
    ]


def criteria_of(setting: Setting) -> pd.DataFrame:
    """Total error and MEIR that each plan promises."""
    problem, meir = setting.problem, meir_of_problem(setting.problem)
    assert meir is not None
    rows = []
    for name, plan in setting.plans.items():
        assessment = problem.assess(plan.configurations[None], plan.loads[None])
        total = next(c for c in problem.objectives if c.name == "total").values(assessment)
        rows.append([name, float(total[0]), float(meir.values(assessment)[0])])
    return pd.DataFrame(rows, columns=["plan", "total", "meir"])


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("config", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--machines", type=int, default=200, help="that hide physics")
    parser.add_argument("--healthy", type=int, default=100, help="that hide none")
    parser.add_argument("--scatter", type=float, default=0.1, help="relative scatter of the true stiffness (1 sigma)")
    parser.add_argument("--factor", type=float, default=1.0, help="by which effects are larger than MEIR assumes")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=float("inf"), help="after which no further machine is begun")
    options = parser.parse_args()
    setting = setting_of(options.config, options.scatter, options.factor, options.seed)
    options.out.mkdir(parents=True, exist_ok=True)
    for name, plan in setting.plans.items():
        file = f"plan-{name.replace(', ', '-').replace(' ', '-').lower()}.csv"
        (options.out / file).write_text(csv_text(plan_frame(plan, setting.problem.loaded, False)), encoding="utf-8")
    criteria_of(setting).to_csv(options.out / "criteria.csv", index=False)
    kept = options.out / "trials.csv"
    known = set(pd.read_csv(kept)["machine"]) if kept.exists() else set()
    kinds = setting.factory.kinds
    # Machines with and without physics alternate, so that what an interruption leaves is of both.
    planned = [(i, kinds[i % len(kinds)]) for i in range(options.machines)]
    healthy = [(10_000 + i, "") for i in range(options.healthy)]
    share = options.healthy / max(options.machines, 1)
    order = sorted([(i / 1.0, *each) for i, each in enumerate(planned)]
                   + [(i / max(share, 1e-9) + 0.5, *each) for i, each in enumerate(healthy)])  # fmt: skip
    began = time.monotonic()
    for _, number, physics in order:
        if number in known:
            continue
        if time.monotonic() - began > options.seconds:
            break
        rows = [
            [number, physics, " ".join(components), name, *astuple(found)]
            for name, found, components in trials(setting, number, physics)
        ]
        names = ["machine", "physics", "component", "plan", *Outcome.__dataclass_fields__]
        pd.DataFrame(rows, columns=names).round(5).to_csv(kept, mode="a", index=False, header=not kept.exists())
    command = (
        f"python -m benchmarks.model_error_closed_loop {options.config} --out {options.out} --machines "
        f"{options.machines} --healthy {options.healthy} --scatter {options.scatter:g} --factor {options.factor:g} "
        f"--seed {options.seed}"
    )
    text = readme(options.out, command, setting.factory.place, MORE, UNSOUGHT)
    (options.out / "README.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
