"""`montecarlo`: a plan carried out, identified and compensated many times, beside what the criteria predict."""

from copy import copy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from expdesign.api.evaluate import evaluate
from expdesign.api.inputs import Config, ModelInput, PathLike, TableInput, truth_of
from expdesign.design.problem import DesignProblem
from expdesign.elastostatics.measurements import LoadedRobot
from expdesign.errors import InputError
from expdesign.files.output import json_text, output_folder, write_file
from expdesign.instrument.drawn_errors import Distribution
from expdesign.report.page import Page
from expdesign.validation.plants import PLANTS
from expdesign.validation.repeated import Repeated, repeat

MOST_SAMPLES = 5_000_000
DISTRIBUTIONS: tuple[Distribution, ...] = ("normal", "uniform")


@dataclass(frozen=True)
class MonteCarlo:
    """Repetitions of a plan.

    Attributes:
        result: the samples and what is compared.
        remarks: what is doubtful about the plan, in words.
    """

    result: Repeated
    remarks: tuple[str, ...]

    @property
    def criteria(self) -> pd.DataFrame:
        """DUIR, FEIR and total as they came out (tolerances) and as predicted."""
        rows = {}
        for cause in self.result.causes:
            found, predicted = self.result.criterion(cause)
            numbers = (float(found.value), float(found.standard_error), predicted)
            rows[cause] = [*numbers, self.result.criterion_score(cause)]
        return pd.DataFrame.from_dict(rows, orient="index", columns=["rms", "standard_error", "predicted", "z"])

    @property
    def record(self) -> dict[str, Any]:
        """The content of `montecarlo.json`."""
        return self.result.record()

    def page(self) -> Page:
        """The report."""
        from expdesign.report.montecarlo_report import montecarlo_report  # noqa: PLC0415 (slow to import)

        return montecarlo_report(self.result)

    def save(self, folder: PathLike) -> Path:
        """Write the files of `expdesign montecarlo` into a folder and return the path of the report."""
        from expdesign.report.stored import PAGE, write_report  # noqa: PLC0415 (slow to import)

        with output_folder(Path(folder)) as scratch:
            write_file(scratch / "montecarlo.json", json_text(self.record))
            write_report(scratch, self.page())
        return Path(folder) / PAGE


def montecarlo(
    config: Config,
    plan: TableInput,
    *,
    samples: int = 100_000,
    seed: int = 1,
    plant: str = "explicit",
    distribution: str = "normal",
    truth: ModelInput | None = None,
) -> MonteCarlo:
    """Repeat a plan's experiment, identification and exact compensation, and compare with the criteria.

    Args:
        config: run configuration.
        plan: what is measured.
        samples: number of repetitions.
        seed: of all random numbers.
        plant: `explicit` (the linear mapping) or `equilibrium` (the exact equilibrium of a robot on legs).
        distribution: of the load errors, `normal` or `uniform` with the same standard deviations.
        truth: robot file or model without further effects that is really measured and commanded; the configuration's
            robot if left out. Its stiffness and, for the explicit plant, its geometry may differ.

    Raises:
        InputError: a file or an argument is wrong.
        SingularConfigurationError: the robot is singular in a row.
        NotIdentifiableError: the plan does not identify what the targets need.
        ConvergenceError: a repetition has no compensation.
    """
    if plant not in PLANTS:
        raise InputError(f"there is no plant `{plant}`", where="--plant", remedy=f"Known: {', '.join(PLANTS)}.")
    chosen = next((known for known in DISTRIBUTIONS if known == distribution), None)
    if chosen is None:
        remedy = f"Known: {', '.join(DISTRIBUTIONS)}."
        raise InputError(f"there is no distribution `{distribution}`", where="--distribution", remedy=remedy)
    if not 100 <= samples <= MOST_SAMPLES:
        what = f"{samples} repetitions are not from 100 to {MOST_SAMPLES}"
        raise InputError(what, where="--samples", remedy="Use e.g. 100000.")
    if seed < 0:
        raise InputError(f"{seed} is not a seed", where="--seed", remedy="Use a whole number of at least 0.")
    judged = evaluate(config, plan)
    real = None if truth is None else _truth(judged.problem, truth, plant)
    result = repeat(judged.problem, judged.plan, samples, seed, plant=PLANTS[plant], distribution=chosen, truth=real)
    return MonteCarlo(result, judged.remarks)


def _truth(problem: DesignProblem, truth: ModelInput, plant: str) -> LoadedRobot:
    """The robot that is measured, under the loads of the configuration."""
    model = truth_of(truth)
    robot, own = model.chain.robot, problem.loaded.robot
    if plant != "explicit":
        remedy = "Use `--plant explicit`, or a configuration of the true robot."
        raise InputError("another robot as the truth needs the explicit plant", where="--truth", remedy=remedy)
    if model.chain.effects:
        remedy = "Simulate single experiments of it with `expdesign simulate --truth`."
        raise InputError("the truth has effects beyond the base model", where=model.source, remedy=remedy)
    if robot.configuration != own.configuration or robot.kind != own.kind:
        what = f"the truth is a {robot.kind}, and the configuration is of a {own.kind}"
        raise InputError(what, where=model.source, remedy="Give a robot of the same kind.")
    real = copy(robot)
    real.stiffness = 1.0 / model.compliance
    loaded = problem.loaded
    return LoadedRobot(real, loaded.load, loaded.sources, loaded.geometric_stiffness, loaded.regressor)
