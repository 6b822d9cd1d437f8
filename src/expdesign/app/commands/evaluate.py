"""`expdesign evaluate`: every criterion of one given plan."""

from rich.console import Console
from rich.table import Table

import expdesign as xd
from expdesign.app.commands.console import note
from expdesign.app.commands.writing import Config, Json, PlanPath
from expdesign.assurance.acceptance.decision import sentences
from expdesign.io.output import json_text

GROUP = ("research", 4)
"""Where it stands in the list of commands."""


def command(
    config: Config,
    plan: PlanPath,
    json: Json = False,
) -> None:
    """Judge one plan by every criterion.

    Example: expdesign evaluate configs/hexapod-h1.yaml results/mine/plan.csv --json
    """
    result = xd.evaluate(config, plan)
    for remark in result.remarks:
        note(f"expdesign: {remark}")
    record = result.record
    if json:
        print(json_text(record), end="")
        return
    shown = Table("criterion", "value", "unit", "better")
    for name, criterion in result.problem.criteria.items():
        value = record[name]
        text = "not identifiable" if value is None else f"{value:.6g}"
        shown.add_row(criterion.title, text, criterion.unit, "larger" if criterion.maximise else "smaller")
    Console(soft_wrap=True).print(shown)
    for text in sentences(result.acceptance):
        print(text)
    if result.accuracy is not None:
        print(result.accuracy.sentence)
