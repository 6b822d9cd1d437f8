"""`simulate`: recordings of a plan as the model gives them, with noise and load errors.

Physics that the robot has and its base model lacks is named by a text such as `leg_backlash at leg 4, 5 um`. After the
identifier and the component follow, separated by commas and in any order: a form (`short`), the value of the parameter
where there is one (`5 um`), or values by name (`creep_ratio 0.05, tau_s 600 s`). What is not named has its usual size.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd

from expdesign.app.api.arguments import Seed, named_arguments
from expdesign.app.api.configuration import Config, plan_of, problem_of
from expdesign.app.api.inputs import TableInput, TruthInput, purpose_of, truth_of
from expdesign.arrays import FloatArray
from expdesign.assurance.model_error.physics import sizes_at_targets
from expdesign.chain.chain import Chain
from expdesign.chain.component import component_from_text
from expdesign.chain.effect import Effect, Parameter
from expdesign.chain.models.effect_entry import effect_classes, effects_of
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.columns import REFERENCE
from expdesign.chain.recordings.recordings import DEFLECTIONS, POSES, measured_names
from expdesign.chain.recordings.references import reference_names
from expdesign.errors import InputError
from expdesign.estimation.compensation.prediction import require_history
from expdesign.estimation.compensation.target_loads import checked_targets
from expdesign.io.nearest import nearest
from expdesign.io.units import NUMBER, QUANTITY, quantities, quantity, require_dimension
from expdesign.mechanics.robots.robot import Robot
from expdesign.mechanics.robots.robot_file import require_same_robot
from expdesign.planning.problem import DesignProblem
from expdesign.planning.synthetic import simulated_readings, truth
from expdesign.report.recording_texts import SimulationResult
from expdesign.report.result import filled


@named_arguments
def simulate(
    config: Config,
    plan: TableInput,
    *,
    model: TruthInput | None = None,
    conceal: str | Sequence[str] = (),
    seed: Seed = 1,
    noise: bool = True,
    load_errors: bool = True,
    other_robot: bool = False,
) -> SimulationResult:
    """Simulate the recordings of a plan, or check measurements at commands that `compensate` wrote.

    The errors of the weights and of gravity follow from the seed, the same in both. A check measurement has those of
    the weights only where `same_as` says `experiment`, and those of a payload of its own as far as the table states
    them.

    Args:
        config: run configuration (YAML).
        plan: plan (CSV), of any number of rows.
        model: model or robot file (YAML) to simulate; the configuration's robot if left out.
        conceal: true physics that the base model lacks, e.g. 'leg_backlash at leg 4, 5 um'; `expdesign physics` lists
            what a robot can have.
        seed: seed of the noise and the load errors.
        noise: whether to add the configuration's noise.
        load_errors: whether to draw the configuration's load errors.
        other_robot: accept a model whose geometry differs from that of the configuration's robot.

    Raises:
        InputError: a file is missing or wrong, or the seed is negative.

    Example:
        >>> recordings = xd.simulate("configs/bipod.yaml", "plan.csv", seed=1)
        >>> recordings.frame.columns[6:].tolist()
        ['dx_m', 'dy_m', 'sx_m', 'sy_m']

    Command:
        expdesign simulate configs/hexapod-h1.yaml plan.csv --out recordings.csv --seed 3
    """
    purpose = purpose_of("simulate", config, plan)
    problem = problem_of(config)
    read = plan_of(plan, problem, within=False)
    given, complete, points = read.plan, read.complete, read.points
    identified = None if model is None else truth_of(model)
    if identified is not None:
        own = problem.loaded.robot
        require_same_robot(identified.chain.robot, identified.source, own, problem.source, confirmed=other_robot)
    if conceal:
        identified = with_concealed(
            truth(problem, identified), [conceal] if isinstance(conceal, str) else conceal, problem
        )
        require_history(identified, complete)
    referenced = problem.loaded.regressor.referenced
    targets = checked_targets(complete, problem.loaded.robot)
    readings = simulated_readings(
        problem, given, points, identified, seed, noise=noise, errors=load_errors, targets=targets
    )
    frame = complete.frame.drop(columns=[REFERENCE if referenced else "kind"], errors="ignore")
    if not referenced:
        frame["kind"] = "pose"
    elif problem.noise.shared_reference:  # the unloaded readings that rows have in common
        frame[REFERENCE] = reference_names(given.series)
    text = _with_readings(frame, readings, problem, given.configurations)
    return SimulationResult(text, seed, noise, purpose=purpose)


def _with_readings(
    frame: pd.DataFrame, readings: FloatArray, problem: DesignProblem, configurations: FloatArray
) -> pd.DataFrame:
    """The frame with the measured components and their standard deviations filled in; others are taken out."""
    coordinates, axes = problem.loaded.robot.coordinates, problem.noise.axes
    names = coordinates.deflection if problem.loaded.regressor.referenced else measured_names(coordinates)
    spread = problem.noise.deviations_at(problem.loaded.robot.jacobians(configurations).pose)
    frame = frame.drop(columns=[*names, *coordinates.deviation], errors="ignore")
    frame = filled(frame, (names[axis] for axis in axes), readings[:, axes])
    return filled(frame, (coordinates.deviation[axis] for axis in axes), spread)


WHERE = "argument `conceal`"


def with_concealed(model: Model, texts: Sequence[str], problem: DesignProblem) -> Model:
    """A model with further physics.

    Args:
        model: the robot without it.
        texts: what is added, in words.
        problem: whose robot and targets usual sizes may be multiples of.

    Raises:
        InputError: a text names no physics, place, form or parameter of this robot, or one place twice.
    """
    chain = model.chain
    effects, values = list(chain.effects), [model.values]
    for text in texts:
        effect, parameters = _concealed(text, problem, chain.robot)
        if any(effect.slot == other.slot for other in effects):
            what = f"`{effect.physics}` at `{effect.component}` is there already"
            raise InputError(what, where=WHERE, remedy="Name each place once.")
        effects.append(effect)
        values.append(parameters)
    joined = np.concatenate(values)
    covariance = np.zeros((len(joined), len(joined)))  # it is what really deflects, and therefore exact
    longer = Chain(chain.robot, tuple(effects), reading=chain.reading)
    return Model(longer, joined, covariance, model.robot, model.folder, model.source)


def _concealed(text: str, problem: DesignProblem, robot: Robot) -> tuple[Effect, FloatArray]:
    """The effect that a text names, and its parameters (p,)."""
    head, *parts = (part.strip() for part in text.split(","))
    physics, at, place = (word.strip() for word in head.partition(" at "))
    if not at:
        remedy = "Write e.g. `leg_backlash at leg 4, 5 um`; `expdesign physics ROBOT` lists what can be there."
        raise InputError(f"`{head}` names no place", where=WHERE, remedy=remedy)
    readings = DEFLECTIONS if problem.loaded.regressor.referenced else POSES
    parts = [part for part in parts if part]
    effects = _at(physics, place, parts, robot)
    if not any(readings in type(effect).measurands for effect in effects):
        what = f"`{physics}` at `{place}` does not show in {readings.name}, which this configuration measures"
        raise InputError(what, where=WHERE, remedy="`expdesign physics ROBOT` says what shows in which readings.")
    effects = [effect for effect in effects if readings in type(effect).measurands]
    meant = ((effect, _texts(effect, parts)) for effect in effects)
    effect, texts = next(((effect, texts) for effect, texts in meant if texts is not None), (None, {}))
    if effect is None:
        forms = ", ".join(dict.fromkeys(f"`{effect.variant}`" for effect in effects if str(effect.variant)))
        names = ", ".join(dict.fromkeys(f"`{each.name}`" for effect in effects for each in effect.parameters))
        what = f"`{physics}` at `{place}` cannot be `{', '.join(parts)}`"
        remedy = (f"Forms: {forms}. " if forms else "") + f"Parameters: {names}."
        raise InputError(what, where=WHERE, remedy=remedy)
    return effect, np.array([_value(parameter, effect, texts, problem) for parameter in effect.parameters])


def _at(physics: str, place: str, parts: list[str], robot: Robot) -> list[Effect]:
    """The effects of a physics at a component: in forms that parts of a text name (`98 newton`), and in all listed."""
    known = effect_classes()
    named = [cls for cls in known if physics in (cls.physics, cls.identifier)]
    if not named:
        remedy = nearest(physics, sorted({cls.physics for cls in known if cls.components(robot)}))
        raise InputError(f"unknown physics `{physics}`", where=WHERE, remedy=remedy)
    try:
        component = component_from_text(place)
    except ValueError:
        component = None
    found = [effect for cls in named for effect in effects_of(cls, robot) if effect.component == component]
    if not found:
        places = ", ".join(dict.fromkeys(str(each) for cls in named for each in cls.components(robot)))
        remedy = f"It can be at {places}." if places else f"A {robot.kind} does not have it."
        what = f"`{robot.name}` has no `{place}` at which `{physics}` could be"
        raise InputError(what, where=WHERE, remedy=remedy)
    forms = {str(effect.variant) for effect in found}
    others = [part for part in parts if part not in forms]
    for cls, part in product(dict.fromkeys(type(effect) for effect in found), others):
        with contextlib.suppress(ValueError):
            found.insert(0, cls.from_text(robot, place, part))
    return found


def _texts(effect: Effect, parts: list[str]) -> dict[str, str] | None:
    """The texts of values by the names of parameters, as an effect understands what stands after its place.

    A part is the effect's form, the name of a parameter with its value, or the value of the only one; None where it is
    none of these.
    """
    names = {parameter.name for parameter in effect.parameters}
    single = [parameter.name for parameter in effect.parameters if not parameter.shape]
    found: dict[str, str] = {}
    for part in parts:
        first, _, rest = part.replace("=", " ", 1).partition(" ")
        if part == str(effect.variant):
            continue
        if first in names:
            found[first] = rest.strip()
        elif len(single) == 1 and (NUMBER.fullmatch(part) or QUANTITY.fullmatch(part)):
            found.setdefault(single[0], part)
        else:
            return None
    return found


def _value(parameter: Parameter, effect: Effect, texts: dict[str, str], problem: DesignProblem) -> float:
    """The value of a parameter in its own unit: as named, or its usual one."""
    text = texts.get(parameter.name)
    if text is None and parameter.shape:
        return parameter.neutral
    if text is None:
        return sizes_at_targets(problem).of(effect.size(parameter), effect, parameter)
    where = f"{WHERE}, {parameter.name}"
    if NUMBER.fullmatch(text):
        value = float(text)
    else:
        value, unit = quantity(text, where)
        base = parameter.name.rpartition("_")[0]
        own = {"m": "length", "rad": "angle", "N": "force", "Nm": "moment", "s": "time"}
        dimension = own.get(parameter.name.rpartition("_")[2])
        known = quantities(base) if dimension is None or "_per_" in parameter.name else (dimension,)
        if not known:
            raise InputError(f"`{text}` has a unit", where=where, remedy="Write a plain number, in SI units.")
        require_dimension(unit, known, parameter.name, where)  # type: ignore[arg-type]
    if not parameter.low <= value <= parameter.high:
        remedy = f"It is from {parameter.low:g} to {parameter.high:g}."
        raise InputError(f"{value:g} is not possible", where=where, remedy=remedy)
    return value
