"""What can be done next, with the commands: one table of steps, of which each page names those that follow from it."""

import shlex

from expdesign.report.blocks import HERE, NextSteps, PageSection

_STEPS = {
    "evaluate": (
        "Judge the plan once more, or one that you have changed. plan.csv beside this page holds the recommended "
        "design; the plan of any other design is downloaded above.",
        "expdesign evaluate {config} {plan}",
    ),
    "simulate": (
        "Rehearse: make recordings from the model with noise, and try the steps below on them.",
        "expdesign simulate {config} {plan} --out rehearsal.csv",
    ),
    "sheet": (
        "Make a sheet for the laboratory: the rows in an order that saves changes, with room for readings.",
        "expdesign sheet {config} {plan} --out sheet",
    ),
    "check": (
        "Measure. Fill in sheet/sheet.xlsx, or a copy of plan.csv with what was measured in the columns {columns} "
        "(those that the instrument gives), saved as recordings.csv. Check the file before leaving the laboratory.",
        "expdesign check {recordings} --robot {robot}",
    ),
    "identify": (
        "Identify the stiffness of the actuators, with confidence intervals, and see whether the targets are within "
        "their tolerances.",
        "expdesign identify {robot} {recordings} --targets {config} --out identified",
    ),
    "identify poses": (
        "Measure the poses of plan.csv against the commanded ones, and identify the {noun}.",
        "expdesign identify {robot} poses.csv --out identified",
    ),
    "diagnose": (
        "Find out which physics the model lacks.",
        "expdesign diagnose {robot} {recordings}{at_targets} --out diagnosed",
    ),
    "predict": (
        "Predict deflections: here at the recorded commands and loads, or at those of any other table.",
        "expdesign predict {model} {recordings} --out predicted.csv",
    ),
    "compensate": (
        "Find commands that reach the targets under load.",
        "expdesign compensate {model} {targets} --out commands.csv",
    ),
    "verify": (
        "Measure at these commands (fill in commands.csv, saved as check.csv), and certify what is attained.",
        "expdesign verify {model} check.csv --config {config} --out verified",
    ),
    "next": ("If the accuracy is not enough, measure on.", "expdesign next {config} {recordings} --out plan-next.csv"),
    "run": ("Look for a better plan.", "expdesign run {config} --out results/mine"),
}
_UNNAMED = {
    "robot": "ROBOT.yaml", "config": "CONFIG.yaml", "recordings": "recordings.csv", "targets": "targets.csv",
    "at_targets": "", "model": f"{HERE}model.yaml", "plan": f"{HERE}plan.csv",
}  # fmt: skip
"""What commands name where nothing is given; model and plan lie beside the page."""


def next_steps(*names: str, **given: str) -> PageSection:
    """The section with some steps; a name that is none of the table's is a sentence of its own.

    Args:
        names: of the steps, in order.
        given: paths by what they are in a command (`robot`, `config`), and words of the sentences (`columns`, `noun`);
            an empty path is one that nobody has named.
    """
    paths = {name: shlex.quote(text) for name, text in given.items() if text}
    if "config" in paths:
        paths |= {"targets": paths["config"], "at_targets": f" --targets {paths['config']}"}
    steps = []
    for name in names:
        sentence, command = _STEPS.get(name, (name, ""))
        steps.append((sentence.format(**given) if command else sentence, command.format(**_UNNAMED | paths)))
    return PageSection("next", "Next steps", [NextSteps(steps)])
