"""Plan, measure, identify, compensate, and look at what was attained: every criterion in the same closed loop.

    python -m research.benchmarks.closed_loop configs/closed-loop.yaml --out results/closed-loop

The robot that is measured and commanded is the virtual laboratory's (an independent mechanics engine, large
displacements), with true stiffnesses scattered about those of the robot file and with the noise and the load errors of
the configuration drawn anew in every repetition. All criteria meet the same robots and the same draws of noise and
load errors, so that their differences are those of their plans. The random plans are drawn anew every time.
"""

import argparse
import sys
import textwrap
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.assurance.validation.repeated import mean, root_mean_square
from expdesign.chain.chain import Chain
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.points import points_from_table
from expdesign.chain.recordings.reader import recordings_from_table
from expdesign.chain.recordings.recordings import LoadedPoints
from expdesign.chain.recordings.references import Sharing, with_references
from expdesign.estimation.compensation.compensate import compensate
from expdesign.estimation.identify import identify
from expdesign.io.output import csv_text, output_folder, write_file
from expdesign.io.table import Table, parse_table
from expdesign.io.yaml_reader import YamlDocument
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.plan import Plan, plan_frame
from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import read_problem
from expdesign.planning.sampling import starting_designs
from expdesign.planning.search import search_single
from expdesign.planning.synthetic import load_errors
from research.laboratory import Laboratory
from research.laboratory import Robot as LaboratoryRobot

BEST, RANDOM = "total", "random"
PAYLOAD = ("mass_kg", "com_x_m", "com_y_m", "com_z_m")
UNCOMPENSATED, UNIDENTIFIED = "no compensation", "compensation with the robot file's stiffness"


@dataclass(frozen=True)
class Loop:
    """What stays the same over all repetitions."""

    problem: DesignProblem
    targets: LoadedPoints
    bench: LaboratoryRobot
    scatter: float


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("config", type=Path)
    parser.add_argument("--out", type=Path, default=Path("results/closed-loop"))
    parser.add_argument("--repetitions", type=int, default=400)
    parser.add_argument("--scatter", type=float, default=0.1, help="relative scatter of the true stiffness (1 sigma)")
    parser.add_argument("--generations", type=int, default=None, help="of the search for each criterion's plan")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(arguments)
    loop = loop_of(read_problem(options.config), options.scatter)
    plans = plans_by_criterion(loop.problem, options.seed, options.generations)
    attained, predicted = run(loop, plans, options.repetitions, options.seed)
    table = summary(attained, predicted)
    command = (
        f"python -m research.benchmarks.closed_loop {options.config} --out {options.out} "
        f"--repetitions {options.repetitions} "
        f"--scatter {options.scatter:g} --seed {options.seed}"
    )
    if options.generations is not None:
        command += f" --generations {options.generations}"
    told = explanation(options.config, options.repetitions, options.scatter)
    with output_folder(options.out) as scratch:
        write_file(scratch / "attained.csv", csv_text(table))
        write_file(scratch / "repetitions.csv", csv_text(pd.DataFrame(attained).round(5)))
        write_file(scratch / "README.md", text_of(table, command, told))
        for name, plan in plans.items():
            write_file(scratch / f"plan-{name}.csv", csv_text(plan_frame(plan, loop.problem.loaded, False)))
    print(table.to_string(index=False))


def loop_of(problem: DesignProblem, scatter: float) -> Loop:
    """The loop of a configuration whose targets carry payloads."""
    robot = problem.loaded.robot
    columns: dict[str, list[float]] = {name: [] for name in (*robot.configuration, *PAYLOAD)}
    for target in problem.config["targets"]:
        values = [*target["pose"], target["payload"]["mass_kg"], *target["payload"]["com_m"]]
        for name, value in zip(columns, values, strict=True):
            columns[name].append(float(value))
    points = points_from_table(table_of(pd.DataFrame(columns)), robot)
    return Loop(problem, points, LaboratoryRobot.from_mapping(problem.config["robot"]), scatter)


def table_of(frame: pd.DataFrame) -> Table:
    """A frame as the table that a CSV file of it would give."""
    return parse_table(csv_text(frame), "closed loop")


def plans_by_criterion(problem: DesignProblem, seed: int, generations: int | None) -> dict[str, Plan]:
    """The best plan that is found by every known criterion alone."""
    plans = {}
    for name, criterion in known_criteria().items():
        best = search_single(problem, criterion, seed=seed, generations=generations)
        print(f"{name}: {best.criteria[name][0]:.6g} after {best.evaluations} designs", file=sys.stderr, flush=True)
        plans[name] = plan_of_decisions(problem, best.decisions[0])
    return plans


def plan_of_decisions(problem: DesignProblem, decisions: FloatArray) -> Plan:
    configurations, loads = problem.space.decode(decisions)
    return Plan(configurations, loads, np.arange(1, len(decisions) + 1))


def run(
    loop: Loop, plans: dict[str, Plan], repetitions: int, seed: int
) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
    """Attained error of every plan in every repetition, and the criterion `total` that predicts it, in tolerances."""
    problem = loop.problem
    decisions = starting_designs(problem, repetitions, np.random.default_rng([seed, 7]))
    names = [*plans, RANDOM]
    attained = {name: np.full(repetitions, np.nan) for name in (*names, UNIDENTIFIED, UNCOMPENSATED)}
    predicted = {name: np.full(repetitions, np.nan) for name in names}
    for repetition in range(repetitions):
        stiffness, draw = drawn_robot(loop, seed, repetition)
        here = plans | {RANDOM: plan_of_decisions(problem, decisions[repetition])}
        for name, plan in here.items():
            attained[name][repetition] = attained_with(loop, plan, stiffness, draw)
            predicted[name][repetition] = expected(problem, plan)
        attained[UNIDENTIFIED][repetition] = error_of(loop, stiffness, nominal_model(problem))
        attained[UNCOMPENSATED][repetition] = error_of(loop, stiffness, None)
        if repetition % 20 == 19:
            print(f"{repetition + 1} of {repetitions} repetitions", file=sys.stderr, flush=True)
    return attained, predicted


def drawn_robot(loop: Loop, seed: int, repetition: int) -> tuple[FloatArray, int]:
    """True stiffness (n_p,) in one repetition, and the seed of its noise and load errors; the same for all plans."""
    generator = np.random.default_rng([seed, 11, repetition])
    nominal = loop.problem.loaded.robot.stiffness
    stiffness = nominal * np.exp(loop.scatter * generator.standard_normal(len(nominal)))
    return stiffness, int(generator.integers(2**31))


def expected(problem: DesignProblem, plan: Plan) -> float:
    """The criterion `total` of a plan."""
    assessment = problem.assess(plan.configurations[None], plan.loads[None], plan.series[None])
    return float(known_criteria()["total"].values(assessment)[0])


def attained_with(loop: Loop, plan: Plan, stiffness: FloatArray, draw: int) -> float:
    """Error at the targets after one experiment with a plan, in tolerances."""
    problem = loop.problem
    robot, noise = problem.loaded.robot, problem.noise
    coordinates = robot.coordinates
    assumed = plan_frame(plan, problem.loaded, False)
    rotation = robot.jacobians(plan.configurations).rotation
    actual = problem.loaded.load.wrenches(rotation, plan.loads) + load_errors(problem.loaded, plan, draw)
    applied = assumed[["sequence", "series", *robot.configuration]].copy()
    applied[list(coordinates.wrench)] = actual
    names = [coordinates.deflection[axis] for axis in noise.axes]
    deviations = dict(zip(names, np.sqrt(np.diag(noise.covariance)).tolist(), strict=True))
    laboratory = Laboratory(
        loop.bench, true_stiffness=stiffness, noise_std=deviations, shared_reference=noise.shared_reference, seed=draw
    )
    measured = laboratory.measure(applied)
    kept = [name for name in measured.columns if name in (*coordinates.deflection, *coordinates.deviation)]
    recordings = recordings_from_table(table_of(pd.concat([assumed, measured[kept]], axis=1)), robot)
    result = identify(
        robot,
        with_references(recordings, Sharing(configured=noise.shared_reference))[0],
        load_errors=problem.load_errors,
        estimator=problem.estimator,
    )
    document = YamlDocument("closed loop", Path(), problem.config["robot"])
    return error_of(loop, stiffness, Model.from_fit(result.fit, document, "closed loop"))


def nominal_model(problem: DesignProblem) -> Model:
    """The robot file taken for true."""
    chain = Chain(problem.loaded.robot)
    nothing = np.zeros((len(chain.parameters), len(chain.parameters)))
    return Model(chain, chain.start(), nothing, problem.config["robot"], Path(), "robot file")


def error_of(loop: Loop, stiffness: FloatArray, model: Model | None) -> float:
    """Attained minus wanted pose at the targets under load, weighted as in the criterion `total`, in tolerances."""
    targets = loop.problem.targets
    commands = loop.targets.configurations if model is None else compensate(model, loop.targets).commands
    rows = pd.DataFrame(commands, columns=list(loop.problem.loaded.robot.configuration))
    assert loop.targets.payload is not None
    rows[list(PAYLOAD)] = loop.targets.payload
    attained = Laboratory(loop.bench, true_stiffness=stiffness).attained(rows).to_numpy()
    squares = ((attained - loop.targets.configurations) ** 2 * targets.importance).sum(axis=1)
    if targets.aggregate == "max":
        return float(np.sqrt(squares.max()))
    return float(np.sqrt(squares @ targets.weights / targets.weights.sum()))


def summary(attained: dict[str, FloatArray], predicted: dict[str, FloatArray]) -> pd.DataFrame:
    """Mean and spread of the attained error, its difference from that of `total`, and its RMS beside the prediction."""
    rows = []
    reference = attained[BEST]
    for name, errors in attained.items():
        average, rms, difference = mean(errors), root_mean_square(errors), mean(errors - reference)
        expectation = predicted.get(name)
        rows.append(
            {
                "plan_by": name,
                "repetitions": len(errors),
                "mean": float(average.value),
                "spread": float(errors.std(ddof=1)),
                "standard_error": float(average.standard_error),
                "percentile_95": float(np.quantile(errors, 0.95)),
                "rms": float(rms.value),
                "rms_standard_error": float(rms.standard_error),
                "minus_best": float(difference.value),
                "minus_best_standard_error": float(difference.standard_error),
                "predicted_total": float("nan") if expectation is None else float(np.sqrt((expectation**2).mean())),
            }
        )
    return pd.DataFrame(rows).sort_values("mean", kind="stable", ignore_index=True)


def explanation(config: Path, count: int, scatter: float) -> str:
    """What was done, in one paragraph."""
    return (
        f"{count} repetitions of `{config}`; true stiffnesses scattered by {100 * scatter:g} % (1 σ), noise and load "
        f"errors drawn anew each time, the same for all plans; measured and commanded in the virtual laboratory. Error "
        "attained at the targets, in tolerances: √(mean over targets of Σ (error / tolerance)²). Its RMS is what the "
        "criterion `total` predicts. The random plans are drawn anew each time. The difference is to the plan by "
        "`total`, repetition by repetition. ± is one standard error."
    )


COLUMNS = ("plan by", "mean", "spread", "95 % below", "minus `total`", "RMS", "predicted RMS")


def cells(table: pd.DataFrame) -> list[list[str]]:
    """The table as it is shown."""
    return [
        [
            str(row.plan_by),
            f"{row.mean:.3f} ± {row.standard_error:.3f}",
            f"{row.spread:.3f}",
            f"{row.percentile_95:.3f}",
            "–" if row.plan_by == BEST else f"{row.minus_best:+.3f} ± {row.minus_best_standard_error:.3f}",
            f"{row.rms:.3f} ± {row.rms_standard_error:.3f}",
            "–" if np.isnan(predicted) else f"{predicted:.3f}",
        ]
        for row, predicted in zip(table.itertuples(), table["predicted_total"].astype(float), strict=True)
    ]


def text_of(table: pd.DataFrame, command: str, told: str) -> str:
    """The result as Markdown."""
    lines = [f"| {' | '.join(row)} |" for row in (COLUMNS, ("---",) * len(COLUMNS), *cells(table))]
    body = "\n".join(textwrap.wrap(told, 120))
    return (
        f"# Closed loop: plan, measure, identify, compensate\n\n```\n{command}\n```\n\n{body}\n\n"
        + "\n".join(lines)
        + "\n"
    )


if __name__ == "__main__":
    main(sys.argv[1:])
