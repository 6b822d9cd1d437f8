"""What `montecarlo` returns and its page: does the plan attain what the criteria predict?"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from expdesign.assurance.validation.repeated import Repeated
from expdesign.report import words
from expdesign.report.blocks import (
    Block,
    DataTable,
    Definitions,
    KeyFigure,
    KeyFigures,
    PageSection,
    Shown,
    framed,
    number_of,
)
from expdesign.report.glossary import words_section
from expdesign.report.montecarlo_figures import CAUSE_NAMES, agreement_figure, density_figure
from expdesign.report.next_steps import next_steps
from expdesign.report.page import Page
from expdesign.report.result import PAGE, FolderResult
from expdesign.report.said import Said

CRITERIA = {"duir": "DUIR (measurement noise)", "feir": "FEIR (load errors)", "total": "Total expected error"}


@dataclass(frozen=True, repr=False)
class MonteCarloResult(FolderResult):
    """Repetitions of a plan.

    Attributes:
        result: the samples and what is compared.
    """

    FILES: ClassVar = {"montecarlo.json": "record", **PAGE}
    result: Repeated

    @property
    def criteria(self) -> pd.DataFrame:
        """DUIR, FEIR and total as they came out (tolerances) and as predicted."""
        return _criteria(self.result, self.result.causes).set_index("criterion")

    @property
    def said(self) -> Said:
        found, predicted = self.result.criteria["total"]
        error = (
            f"In {self.result.samples} repetitions of experiment, identification and compensation the RMS error at the "
            f"targets is {words.with_error(float(found.value), float(found.standard_error))} tolerances; the criteria "
            f"predict {words.number(predicted, 4)}."
        )
        agreement = _agreement(self.result)
        return Said(agreement, [error, agreement], (), self.result.record, [_criteria_table(self.result)])

    def page(self) -> Page:
        result, said = self.result, self.said
        robot = result.problem.loaded.robot
        targets = range(len(result.problem.targets.configurations))
        densities: list[Block] = [density_figure(result, target) for target in targets]
        sections = (
            said.section("Result", _key_figures(result), *said.tables),
            PageSection("agreement", "Axis by axis", [agreement_figure(result), _deviation_table(result)]),
            PageSection("densities", "Densities", densities),
            PageSection("run", "How it was done", [Definitions(_settings(result))]),
            words_section("Repetition", "z", "Tolerance", "Mean error"),
            next_steps("run", config=result.problem.source),
        )
        return Page(
            title=f"Monte-Carlo of a calibration plan for {robot.name}",
            subtitle=(
                f"{robot.kind}, {words.count(len(result.plan), 'measurement')}, {result.samples} repetitions; "
                f"configuration {result.problem.source}"
            ),
            sections=sections,
        )


def _agreement(result: Repeated) -> str:
    """Whether what came out is what was predicted, to within the errors of the simulation."""
    scores = np.abs(result.scores())
    beyond, largest = int((scores > 3.0).sum()), words.number(float(scores.max()))
    if beyond == 0:
        return (
            f"The prediction holds: all {len(scores)} comparisons lie within three standard errors of the simulation "
            f"(largest {largest})."
        )
    differ = (
        f"{beyond} of {len(scores)} comparisons differ by more than three standard errors (largest {largest}); by "
        f"chance alone about {words.number(0.0027 * len(scores), 2)} do."
    )
    if result.truth:
        return (
            f"{differ} The criteria predict with the stiffness and the geometry of the configuration, and the true "
            f"robot ({result.truth}) has others; name that file as `robot` in the configuration for a prediction of "
            "this robot. Errors so large that they are not linear would show as well."
        )
    return (
        f"{differ} What the prediction leaves out (errors so large that they are not linear, or the change of geometry "
        "under load) shows in this simulation."
    )


def _key_figures(result: Repeated) -> KeyFigures:
    items = []
    for cause in result.drawn:
        found, predicted = result.criteria[cause]
        note = f"predicted {words.number(predicted, 4)}"
        items.append(KeyFigure(CRITERIA[cause], words.number(float(found.value), 4), "tolerances", note))
    items.append(KeyFigure("Repetitions", str(result.samples)))
    return KeyFigures(items)


def _criteria_table(result: Repeated) -> DataTable:
    caption = "RMS error at the targets in tolerances: simulated, and as the criteria predict it."
    shown: Shown = {
        "Criterion": lambda row: CRITERIA[row.criterion],
        "Simulated": lambda row: words.with_error(row.rms, row.standard_error),
        "Predicted": number_of("predicted", digits=4),
        "z": lambda row: _score(row.z),
    }
    return framed("criteria", caption, _criteria(result, result.drawn), shown)


def _criteria(result: Repeated, causes: Iterable[str]) -> pd.DataFrame:
    """RMS error at the targets for each cause as it came out (tolerances) and as predicted."""
    rows = []
    for cause in causes:
        found, predicted = result.criteria[cause]
        rows.append([cause, float(found.value), float(found.standard_error), predicted, result.criterion_score(cause)])
    return pd.DataFrame(rows, columns=["criterion", "rms", "standard_error", "predicted", "z"])


def _deviation_table(result: Repeated) -> DataTable:
    names = result.problem.loaded.robot.coordinates.deflection
    importance, bias = result.problem.targets.importance, result.bias
    rows = []
    for target, axis in np.ndindex(importance.shape):
        for cause in result.drawn:
            estimate, predicted = result.deviations[cause]
            found = (estimate.value, estimate.standard_error, predicted, result.deviation_score(cause))
            rows.append([target + 1, names[axis], cause, *(float(values[target, axis]) for values in found)])

    def mean_error(row: Any) -> str:
        place = row.target - 1, names.index(row.axis)
        if row.cause != "total":
            return ""
        return words.with_error(1e6 * float(bias.value[place]), 1e6 * float(bias.standard_error[place]))

    shown: Shown = {
        "Target, axis": lambda row: f"target {row.target}, {words.axis(row.axis)}",
        "Unit": lambda row: words.micro_unit(row.axis),
        "Cause": lambda row: CAUSE_NAMES[row.cause],
        "Simulated σ": lambda row: words.with_error(1e6 * row.std, 1e6 * row.standard_error),
        "Predicted σ": number_of("predicted", 1e6, digits=4),
        "z": lambda row: _score(row.z),
        "Mean error": mean_error,
        "Matters": lambda row: "yes" if importance[row.target - 1, names.index(row.axis)] > 0.0 else "no",
    }
    frame = pd.DataFrame(rows, columns=["target", "axis", "cause", "std", "standard_error", "predicted", "z"])
    caption = "Standard deviation of the attained pose (µm, µrad): simulated with its standard error, and predicted."
    return framed("deviations", caption, frame, shown, tall=True)


def _settings(result: Repeated) -> list[tuple[str, str]]:
    return [
        ("Robot", "the platform moves by A·c of the commanded pose, the mapping that identification uses"),
        ("Load errors", f"{result.distribution} with the standard deviations of the configuration"),
        ("True robot", result.truth or "that of the configuration"),
        ("Seed", str(result.seed)),
        (
            "Exactness",
            f"every command solves its fixed point; the largest remaining error is {words.number(result.residual, 2)} "
            "m or rad",
        ),
    ]


def _score(value: float) -> str:
    return words.UNDETERMINED if np.isnan(value) else f"{value:+.2f}".replace("-", "−")
