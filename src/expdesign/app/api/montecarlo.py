"""`montecarlo`: a plan carried out, identified and compensated many times, beside what the criteria predict."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from typing import Annotated

from expdesign.app.api.arguments import Seed, Within
from expdesign.app.api.callbacks import Callback, shows_progress, silent
from expdesign.app.api.configuration import Config
from expdesign.app.api.evaluate import evaluate
from expdesign.app.api.inputs import TableInput, TruthInput, purpose_of, truth_of
from expdesign.app.parallel import Executors, each_of
from expdesign.assurance.validation.repeated import Drawn, repeat
from expdesign.assurance.validation.simulation import Repetitions, VirtualExperiment
from expdesign.chain.models.model_file import Model
from expdesign.errors import InputError
from expdesign.mechanics.elastostatics.measurements import Distribution, LoadedRobot
from expdesign.mechanics.robots.robot_file import require_same_robot
from expdesign.planning.plan import Plan
from expdesign.planning.problem import DesignProblem
from expdesign.report.montecarlo_report import MonteCarloResult

MOST_SAMPLES = 5_000_000
"""Repetitions at most, whose samples are all kept in memory."""
Repeatedly = Annotated[
    int, Within(f"a number of repetitions from 100 to {MOST_SAMPLES}", "Use e.g. 100000.", 100, MOST_SAMPLES)
]
Common = tuple[Plan, int, Distribution]
"""What all batches share: plan, seed and distribution."""


@shows_progress("repeating")
def montecarlo(
    config: Config,
    plan: TableInput,
    *,
    samples: Repeatedly = 100_000,
    seed: Seed = 1,
    distribution: Distribution = "normal",
    truth: TruthInput | None = None,
    other_robot: bool = False,
    executors: Executors | None = None,
    callback: Callback | None = None,
    progress: bool = False,
) -> MonteCarloResult:
    """Repeat experiment, identification and exact compensation, and compare with DUIR, FEIR and total.

    Args:
        config: run configuration (YAML).
        plan: plan (CSV), of any number of rows.
        samples: number of repetitions.
        seed: seed of all random numbers.
        distribution: how load errors are drawn: `normal`, or `uniform` with the same standard deviations.
        truth: robot or model file (YAML) of the true robot, without further effects; its stiffness and geometry may
            differ. The configuration's robot if left out.
        other_robot: accept a truth whose geometry differs by more than 2 % of the robot's size.
        executors: makes the executor that does batches of repetitions, e.g. `ProcessPoolExecutor`; one after another
            in this process if left out. The results are the same.
        callback: called with the stage, the steps done, the steps in all and a note (`Callback`).
        progress: whether progress is shown on standard error.

    Raises:
        InputError: a file or an argument is wrong.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the plan does not identify what the targets need.
        ConvergenceError: a repetition has no compensation.
        WorkersError: the workers are gone.

    Example:
        >>> xd.montecarlo("configs/bipod.yaml", "plan.csv", samples=2000).summary.splitlines()[-1]
        'The prediction holds: all 9 comparisons lie within three standard errors of the simulation (largest 1.13).'

    Command:
        expdesign montecarlo configs/hexapod-h1.yaml results/mine/plan.csv --out results/mine-montecarlo
    """
    judged = evaluate(config, plan)
    if judged.unidentified is not None:
        raise judged.unidentified
    model = None if truth is None else truth_of(truth)
    if model is not None:
        own = judged.problem.loaded.robot
        require_same_robot(model.chain.robot, model.source, own, judged.problem.source, confirmed=other_robot)
    real = None if model is None else _truth(judged.problem, model)
    common, report = (judged.plan, seed, distribution), callback or silent

    def done(batches: list[Drawn]) -> list[Repetitions]:
        found: dict[int, Repetitions] = {}
        report("repeating", 0, len(batches), "")
        for index, batch in each_of(judged.problem, executors)(_batch, [(drawn, common, model) for drawn in batches]):
            found[index] = batch
            report("repeating", len(found), len(batches), "")
        return [found[index] for index in range(len(batches))]

    result = repeat(
        judged.problem,
        judged.plan,
        samples,
        seed,
        distribution=distribution,
        truth=real,
        elsewhere=done,
    )
    result = result if model is None else replace(result, truth=model.source)
    return MonteCarloResult(result, purpose=purpose_of("montecarlo", config, plan))


def _batch(problem: DesignProblem, drawn: Drawn, common: Common, truth: Model | None) -> Repetitions:
    """One batch, in a worker."""
    (size, noise, load_errors), (plan, seed, distribution) = drawn, common
    real = None if truth is None else _truth(problem, truth)
    experiment = VirtualExperiment(problem, plan, distribution=distribution, truth=real)
    return experiment.batch(size, seed, noise, load_errors)


def _truth(problem: DesignProblem, model: Model) -> LoadedRobot:
    """The robot that is measured, under the loads of the configuration."""
    robot = model.chain.robot
    if model.chain.effects:
        remedy = "Simulate single experiments of it with `simulate`."
        raise InputError("the truth has effects beyond the base model", where=model.source, remedy=remedy)
    real = copy(robot)
    real.stiffness = 1.0 / model.compliance
    loaded = problem.loaded
    physics = None if problem.found is None else problem.found.of(real).physics
    return LoadedRobot(real, loaded.load, loaded.sources, loaded.regressor, physics)
