"""`compare`: criteria across designs, over one or more configurations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Annotated

from expdesign.app.api.arguments import Seed, Within
from expdesign.app.api.callbacks import Callback, shows_progress, silent
from expdesign.app.api.configuration import Config, plan_of, problem_of
from expdesign.app.api.inputs import TableInput, purpose_of
from expdesign.app.parallel import Executors, each_of
from expdesign.assurance.comparison.comparable import require_comparable
from expdesign.assurance.comparison.contenders import Contender, drawn, optimised
from expdesign.assurance.comparison.correlation import rank_correlations
from expdesign.assurance.comparison.judgement import judge
from expdesign.assurance.model_error.meir import Meir
from expdesign.errors import ArgumentError, InputError
from expdesign.planning.criteria.criterion import known_criteria
from expdesign.planning.optimality.certificate import Certificate
from expdesign.planning.plan import without_validation
from expdesign.planning.problem import DesignProblem
from expdesign.report.comparison_report import ComparisonResult

SAMPLES, RANDOM = 4000, 40
"""Repetitions and random designs where nothing is said."""
Samples = Annotated[int, Within("a number of repetitions", "Use at least 2.", 2)]
Drawn = Annotated[int, Within("a number of designs", "Use at least 0.", 0)]
Generations = Annotated[int | None, Within("a number of generations", "Use at least 1.", 1)]


@shows_progress("comparing")
def compare(
    *configs: Config,
    plans: Mapping[str, TableInput] | None = None,
    separate: bool = False,
    samples: Samples = SAMPLES,
    random: Drawn = RANDOM,
    generations: Generations = None,
    seed: Seed = 1,
    executors: Executors | None = None,
    callback: Callback | None = None,
    progress: bool = False,
) -> ComparisonResult:
    """Compare the designs of every criterion, random ones and given plans by the accuracy that they attain.

    Args:
        configs: run configurations (YAML) of the same targets, tolerances and noise.
        plans: further plans by their names, judged under every configuration.
        separate: accept other targets, tolerances or noise; nothing is overlaid then.
        samples: repetitions of experiment, identification and compensation per design.
        random: random designs per configuration.
        generations: generations of the search for each criterion; the configuration's if left out.
        seed: seed of the searches, the random designs and the experiments.
        executors: makes the executor that does searches and repetitions, e.g. `ProcessPoolExecutor`; one
            after another in this process if left out. The results are the same.
        callback: called with the stage, the steps done, the steps in all and a note (`Callback`).
        progress: whether progress is shown on standard error.

    Raises:
        InputError: a file is wrong, or the configurations are not comparable.
        NotIdentifiableError: no design identifies what the targets need.
        WorkersError: the workers are gone.

    Command:
        expdesign compare configs/hexapod-h1.yaml --plan mine=plan.csv --out results/compare
    """
    _require_settings(configs, plans or {})
    problems = [problem_of(config) for config in configs]
    names = _names(problems)
    if not separate:
        require_comparable(problems)
    settings = {
        "Repetitions of the experiment": str(samples),
        "Random designs": str(random),
        "Generations of each search": str(generations or "as configured"),
        "Seed": str(seed),
    }
    given = [_given(problem, plans or {}) for problem in problems]
    total = sum(2 * len(problem.criteria) + random + len(plans or {}) + 2 for problem in problems)
    done, judgements, bounds = count(1), [], []
    for problem, name, own in zip(problems, names, given, strict=True):

        def at(text: str, name: str = name) -> None:
            (callback or silent)("comparing", next(done), total, f"{name}: {text}")

        each = each_of(problem, executors)
        contenders = [*optimised(problem, seed, generations, at, each), *own]
        contenders += drawn(problem, random, seed) if random else []
        judgements.append(judge(problem, contenders, samples, seed, at, each))
        bounds.append(Certificate(problem, 1.0).bound())
        at("lower bound")
    correlations = tuple(rank_correlations(judgement, seed) for judgement in judgements)
    return ComparisonResult(
        tuple(names),
        tuple(judgements),
        correlations,
        tuple(bounds),
        not separate,
        settings,
        purpose=purpose_of("compare", *configs),
    )


def _require_settings(configs: Sequence[Config], plans: Mapping[str, TableInput]) -> None:
    """Raise where nothing is compared, or a plan has the name of a criterion."""
    if not configs:
        raise InputError("no configuration is given", remedy="Name at least one.")
    for name in plans:
        if name in (*known_criteria(), Meir.name) or not name.strip():
            what = f"`{name}` is the name of a criterion" if name.strip() else "the plan has no name"
            raise ArgumentError(what, argument="plans", remedy="Give the plan another name.")


def _names(problems: list[DesignProblem]) -> list[str]:
    """Short names of configurations: those of their files, with the folder where they would be the same."""
    names = [Path(problem.source).stem for problem in problems]
    if len(set(names)) < len(names):
        names = [str(Path(problem.source).with_suffix("")) for problem in problems]
    if len(set(names)) < len(names):
        raise InputError("a configuration is given twice", remedy="Name each once.")
    return names


def _given(problem: DesignProblem, plans: Mapping[str, TableInput]) -> list[Contender]:
    found = []
    for name, plan in plans.items():
        read = plan_of(plan, problem, name)
        found.append(Contender(name, "given", without_validation(read.plan, read.table)))
    return found
