"""A plan for a robot as diagnosis found it, beside the plan for the robot that its file describes.

    python -m benchmarks.found_robot configs/hexapod-h1.yaml --out results/found-robot

A hexapod whose legs differ from its file and whose base yields is measured in the virtual laboratory and diagnosed.
Two plans are then searched with the same settings: for the robot file, and for the diagnosed model. Both are repeated
with the diagnosed physics in the plant, noise and load errors drawn anew: measured, identified and compensated with the
model that each plan was made for; and once more the plan of the robot file, identified with the diagnosed model, which
shows what the plan alone is worth.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import yaml

from expdesign.app.api.diagnose import diagnose
from expdesign.app.api.inputs import document_of
from expdesign.arrays import FloatArray
from expdesign.assurance.validation.comparison import Estimate, root_mean_square
from expdesign.assurance.validation.compensation import ExactCompensation
from expdesign.assurance.validation.repeated import Repeated, repeat
from expdesign.chain.instrument.deflection_noise import series_by_pose
from expdesign.chain.models.model_file import model_text
from expdesign.io.output import csv_text, output_folder, write_file
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from expdesign.planning.search import search
from expdesign.planning.start import starting_designs
from virtual_laboratory import Laboratory
from virtual_laboratory import Robot as LaboratoryRobot
from virtual_laboratory.elements.base_compliance import BaseCompliance

BASE_STIFFNESS = (4e7, 3e7, 6e7, 3e6, 2e6, 4e6)
"""N/m and N·m/rad of the bushing under the base."""
SCATTER = 0.1
RECORDED = 40


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("config", type=Path)
    parser.add_argument("--out", type=Path, default=Path("results/found-robot"))
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--population", type=int, default=60)
    parser.add_argument("--generations", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    document = document_of(options.config, "configuration")
    settings = {"population": options.population, "generations": options.generations}

    def problem_with(robot: object) -> DesignProblem:
        content = dict(document.content)
        content["robot"] = robot
        content["optimiser"] = {**content.get("optimiser", {}), **settings}
        return problem_from_document(replace(document, content=content))

    robot_file = document.folder / document.content["robot"]
    bare = problem_with(document.content["robot"])
    diagnosed = diagnose(robot_file, recordings(bare, options.seed))
    with output_folder(options.out) as scratch:
        text = model_text(diagnosed.model, options.out)
        write_file(scratch / "model.yaml", text)
        found = problem_with(yaml.safe_load(text))
        plans = {"robot file": recommended(bare), "diagnosed model": recommended(found)}
        for name, plan in plans.items():
            frame = plan_frame(plan, bare.loaded, bare.space.tilts)
            write_file(scratch / f"plan-{name.replace(' ', '-')}.csv", csv_text(frame))
        result = repeat(found, plans["diagnosed model"], options.samples, options.seed)
        rows = []
        for plan_name, model_name, used in (
            ("robot file", "robot file", bare),
            ("robot file", "diagnosed model", found),
            ("diagnosed model", "diagnosed model", found),
        ):
            estimate = rms(found, attained_errors(used, found, plans[plan_name], options.samples, options.seed))
            row = {"plan for": plan_name, "identified with": model_name, "rms": estimate.value[0]}
            rows.append(
                row | {"standard error": estimate.standard_error[0], "predicted": predicted(used, plans[plan_name])}
            )
        table = pd.DataFrame(rows)
        write_file(scratch / "attained.csv", csv_text(table.round(6)))
        command = f"python -m benchmarks.found_robot {options.config} --out {options.out} --samples {options.samples}"
        command += f" --population {options.population} --generations {options.generations} --seed {options.seed}"
        write_file(scratch / "README.md", readme(command, diagnosed.effects, result, table))
    print(table.to_string(index=False))


def recordings(problem: DesignProblem, seed: int) -> pd.DataFrame:
    """Recordings of random measurements of the robot with scattered legs on a base that yields."""
    generator = np.random.default_rng(seed)
    designs = starting_designs(problem, RECORDED, generator).reshape(-1, problem.space.decisions)[:RECORDED]
    configurations, loads = problem.space.decode(designs)
    frame = plan_frame(Plan(configurations, loads, np.arange(1, RECORDED + 1)), problem.loaded, problem.space.tilts)
    stiffness = problem.loaded.robot.stiffness * (1.0 + SCATTER * generator.standard_normal(6))
    deviations = problem.noise.deviations_at(problem.loaded.robot.jacobians(configurations).pose)[0]
    bench = Laboratory(
        LaboratoryRobot.from_mapping(problem.config["robot"]),
        true_stiffness=stiffness,
        elements=[BaseCompliance(BASE_STIFFNESS)],
        noise_std=deviations,
        seed=seed,
    )
    return bench.measure(frame)


def recommended(problem: DesignProblem) -> Plan:
    """The design of least total error of the front."""
    front = search(problem)
    configurations, loads = problem.space.decode(front.decisions[front.recommended])
    return Plan(configurations, loads, series_by_pose(configurations))


def attained_errors(used: DesignProblem, plant: DesignProblem, plan: Plan, samples: int, seed: int) -> FloatArray:
    """Attained minus wanted poses (s, t, n): identified and compensated with one model, measured and moved by another.

    Args:
        used: the model with which readings are turned into stiffnesses and commands.
        plant: the robot as it is.
        plan: what is measured.
        samples: repetitions.
        seed: of noise and load errors.
    """
    loaded, noise = plant.loaded, plant.noise
    added = loaded.drawn_errors(plan.configurations, plan.loads, samples, np.random.default_rng([seed, 1]))
    readings = loaded.deflections(plan.configurations, plan.loads, added)
    pose_map = loaded.robot.jacobians(plan.configurations).pose
    drawn = noise.drawn(plan.series, samples, np.random.default_rng([seed, 2]), pose_map)
    readings[..., noise.axes] += drawn
    assessment = used.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    gain = assessment.gain[0].transpose(0, 2, 1).reshape(-1, assessment.parameters)
    own = used.loaded.deflections(plan.configurations, plan.loads, np.zeros((len(plan), readings.shape[-1])))
    known = used.loaded.robot.compliance
    estimates = known + (readings - own).reshape(samples, -1) @ gain
    errors = []
    for index, target in enumerate(used.targets.configurations):
        model, parameters = used.target_loads[index]
        wrench = used.target_wrenches[index]
        commands = ExactCompensation(model, target, wrench, known, parameters).attained(estimates).commands
        moved = plant.target_loads[index][0].deflections(commands, parameters, np.zeros_like(commands))
        errors.append(commands + moved - target)
    return np.stack(errors, axis=1)


def rms(problem: DesignProblem, errors: FloatArray) -> Estimate:
    """RMS of the errors in tolerances over the targets, with its standard error, shape (1,)."""
    targets = problem.targets
    squares = (errors**2 * targets.importance).sum(axis=-1) @ targets.weights / targets.weights.sum()
    return root_mean_square(np.sqrt(squares)[:, None])


def predicted(problem: DesignProblem, plan: Plan) -> float:
    """`total` of a plan as the model with which it is identified predicts it."""
    from expdesign.planning.criteria.accuracy import Total  # noqa: PLC0415

    return float(Total().values(problem.assess(plan.configurations[None], plan.loads[None], plan.series[None]))[0])


def readme(command: str, effects: pd.DataFrame, result: Repeated, table: pd.DataFrame) -> str:
    found = "; ".join(
        f"{row.physics} at {row.component} (probability {row.probability:.3f})" for row in effects.itertuples()
    )
    scores = result.scores()
    total, expected = result.criterion("total")
    return (
        "# A plan for a robot as it was found\n\n"
        f"    {command}\n\n"
        f"{(__doc__ or '').split(chr(10) * 2, 2)[2].strip()}\n\n"
        f"Found by the diagnosis: {found}.\n\n"
        f"The plan for the diagnosed model, {result.samples} repetitions with that physics in the plant: error "
        f"{float(total.value):.4f} ± {float(total.standard_error):.4f} tolerances (RMS, one standard error), predicted "
        f"{expected:.4f}, z = {result.criterion_score('total'):+.2f}; of {len(scores)} compared standard deviations "
        f"the largest z is {np.abs(scores).max():.2f}, and {int((np.abs(scores) > 3).sum())} are beyond three.\n\n"
        "Error attained in tolerances (RMS over targets and repetitions), and what the model in use predicted:\n\n"
        + "| plan for | identified with | attained | standard error | predicted |\n|---|---|---|---|---|\n"
        + "".join(
            f"| {row[0]} | {row[1]} | {row[2]:.4f} | {row[3]:.4f} | {row[4]:.4f} |\n"
            for row in table.itertuples(index=False, name=None)
        )
    )


if __name__ == "__main__":
    main()
