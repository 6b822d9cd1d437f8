"""What a decision on acceptance says: in `run.json`, `evaluate --json` and `identification.json`, and in words."""

from typing import Any

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.assurance.acceptance.budget import DRAWING, OWN_PAYLOAD, UncertaintyBudget
from expdesign.assurance.acceptance.decision import Basis, Decision
from expdesign.chain.models.drawn import RESTS_ON_IT
from expdesign.probabilities import SMALLEST, probability_text

DECISION_RULE = (
    "an axis passes where its expanded uncertainty U does not exceed its tolerance T: guarded acceptance with a guard "
    "band of U (JCGM 106:2012, 8.3; ISO 14253-1), the estimated error after compensation being 0; with recordings the "
    "robot passes only where the probability that any axis at any target is beyond T, by physics that they may hide "
    "as well, is within what the coverage leaves"
)


def acceptance_record(decision: Decision) -> dict[str, Any]:
    """What `run.json`, `evaluate --json` and `identification.json` say under `acceptance`."""
    budget = decision.budget
    return {
        "coverage": budget.coverage.level,
        "coverage_factor": budget.coverage.factor,
        "decision_rule": DECISION_RULE,
        "verdict": decision.verdict,
        "passes": decision.robot_passes if decision.decided else None,
        **_whole(decision),
        "check_readings": decision.check_readings or None,
        "repetitions_until_it_passes": decision.repetitions_needed,
        "measurements_until_it_passes": None
        if decision.repetitions_needed is None
        else decision.repetitions_needed * budget.measurements,
        "targets": [
            {
                "passes": bool(decision.axis_passes[target].all()) if decision.decided else None,
                "axes": [_axis(decision, target, int(axis)) for axis in np.flatnonzero(budget.matters[target])],
            }
            for target in range(len(budget.tolerance))
        ],
    }


def _whole(decision: Decision) -> dict[str, float | None]:
    """The probability that any axis is beyond its tolerance; nothing of a plan."""
    if decision.basis is Basis.PLAN:
        return {}
    whole, hidden = decision.robot_risk, float(decision.hidden_robot_risk.sum())
    known = bool(np.isfinite(whole))
    return {
        "probability_of_any_beyond_tolerance": whole if known else None,
        "probability_of_any_by_hidden_physics": hidden if known and decision.left_out is not None else None,
    }


def _axis(decision: Decision, target: int, axis: int) -> dict[str, Any]:
    budget = decision.budget

    def at(values: FloatArray) -> float | None:
        value = float(values[target, axis])
        return value if np.isfinite(value) else None

    repetitions = at(decision.repetitions)
    return {
        "axis": budget.axes[axis],
        "tolerance": at(budget.tolerance),
        "budget": {name: at(deviation) for name, deviation in _merged(budget).items()},
        "standard_uncertainty": at(budget.standard),
        "degrees_of_freedom": at(budget.degrees),
        "coverage_factor": at(budget.factor),
        "expanded_uncertainty": at(budget.expanded),
        "verdict": decision.axis_verdict(target, axis),
        "passes": bool(decision.axis_passes[target, axis]) if decision.decided else None,
        "probability_beyond_tolerance": at(decision.axis_risk),
        "probability_by_hidden_physics": None
        if decision.left_out is None
        else at(decision.hidden_axis_risk.sum(axis=0)),
        "repetitions_until_it_passes": None if repetitions is None else int(repetitions),
    }


def _merged(budget: UncertaintyBudget) -> dict[str, FloatArray]:
    """Deviations by name; of several with one name (a source that is named twice), the root of the squares."""
    lines: dict[str, FloatArray] = {}
    for one in budget.contributions:
        lines[one.name] = np.hypot(lines[one.name], one.deviation) if one.name in lines else one.deviation
    return lines


def sentences(decision: Decision) -> list[str]:
    """What the decision says, in words."""
    if not decision.decided:
        return [f"Acceptance is not decided: {decision.cause}; {decision.remedy}."]
    budget = decision.budget
    level = f"{100.0 * budget.coverage.level:.4g} %"
    ratio = np.where(budget.matters, budget.expanded / budget.tolerance, -np.inf)
    texts = [_verdict_sentence(decision)]
    if np.isnan(ratio).any():
        texts.append("The measurements do not determine every one of these axes.")
    if np.isfinite(ratio).any():
        target, axis = np.unravel_index(int(np.nanargmax(ratio)), ratio.shape)
        worst = (
            f"The worst is {budget.axes[axis].rsplit('_', 1)[0]} at target {target + 1}: U is "
            f"{ratio[target, axis]:.3g} times its tolerance (k = {budget.factor[target, axis]:.3g}, coverage {level})"
        )
        if decision.basis is Basis.PLAN:
            risk = probability_text(float(decision.axis_risk[target, axis]), 2)
            texts.append(f"{worst}; the probability of an error beyond the tolerance is {risk}.")
        else:
            texts += [f"{worst}.", *_risk_sentence(decision)]
    texts += [*_repetitions(decision), *_by_drawing(budget)]
    texts += beside_the_plan(budget) if decision.basis is Basis.PLAN else []
    if decision.basis is Basis.PLAN and decision.robot_passes and decision.check_readings is not None:
        texts.append(_check_readings(decision.check_readings))
    return texts


def beside_the_plan(budget: UncertaintyBudget) -> list[str]:
    """What U contains and the criteria of a plan do not."""
    if budget.of(OWN_PAYLOAD) is None:
        return []
    return [
        "U contains what is not known of the load at the targets themselves; DUIR, FEIR and total do not, since no "
        "plan changes it."
    ]


def _exceeds(budget: UncertaintyBudget, name: str) -> bool:
    """Whether a contribution exceeds a tolerance by itself."""
    part = budget.of(name)
    return part is not None and bool((budget.matters & (budget.factor * part.deviation > budget.tolerance)).any())


def _by_drawing(budget: UncertaintyBudget) -> list[str]:
    """What the drawing says more of than the readings: of the tip, which U contains, and of the base's frame."""
    texts, drawn = [], budget.of(DRAWING)
    if drawn is not None and (sizes := _most(budget, drawn.deviation, budget.standard / np.sqrt(2.0))):
        text = RESTS_ON_IT.format(sizes)
        texts.append(f"{text[0].upper()}{text[1:]}.")
    if budget.base is not None and (sizes := _most(budget, budget.base, budget.standard)):
        texts.append(
            "U is in the base's frame as drawn. No reading shows where that frame is, and U does not contain it (one "
            f"standard deviation, as this arm is made): {sizes}. State the pose of the `instrument`."
        )
    return texts


def _most(budget: UncertaintyBudget, deviations: FloatArray, than: FloatArray) -> str:
    """The largest deviations (t, n) along axes on which some are larger than others; empty for none."""
    sizes = np.where(budget.matters, deviations, 0.0).max(axis=0)
    resting = np.argwhere(budget.matters & (deviations > than))[:, 1].tolist()
    return ", ".join(
        f"{axis.rsplit('_', 1)[0]} {1e3 * size:.2g} {'mrad' if axis.endswith('_rad') else 'mm'}"
        for number, (axis, size) in enumerate(zip(budget.axes, sizes, strict=True))
        if number in resting
    )


def _verdict_sentence(decision: Decision) -> str:
    matters, exceeding = int(decision.budget.matters.sum()), int((~decision.u_within_tolerance).sum())
    within = f"U is within the tolerance on all {matters} axes that have one"
    some = f"all {matters}" if exceeding == matters else f"{exceeding} of the {matters}"
    exceeds = f"U exceeds the tolerance on {some} axes that have one"
    if decision.basis is Basis.PLAN:
        return f"The robot is {'not ' if exceeding else ''}expected to pass: {exceeds if exceeding else within}."
    if decision.robot_passes:
        return f"The robot passes: {within}."
    if exceeding:
        return f"Not proven: {exceeds}."
    left = probability_text(decision.risk_left, 2)
    return f"Not proven: {within}, but an error beyond any tolerance is likelier than the coverage leaves ({left})."


def _risk_sentence(decision: Decision) -> list[str]:
    """The probability of an error beyond any tolerance, and how much of it physics has that is not in the model."""
    whole = decision.robot_risk
    if np.isnan(whole):
        return []
    text = f"The probability that any axis is beyond its tolerance is {probability_text(whole, 2)}"
    target, axis = np.unravel_index(int(np.nanargmax(decision.axis_risk)), decision.axis_risk.shape)
    if whole >= SMALLEST:
        alone = probability_text(float(decision.axis_risk[target, axis]), 2)
        text += f", of {decision.budget.axes[axis].rsplit('_', 1)[0]} at target {target + 1} alone {alone}"
    if decision.left_out is None:
        return [f"{text}, if the model is right: what these recordings may hide is not counted."]
    parts: dict[str, float] = {}
    for phrase, part in zip(decision.left_out.phrases, decision.hidden_robot_risk, strict=True):
        parts[phrase] = parts.get(phrase, 0.0) + float(part)
    hidden = "physics that these recordings may hide"
    if sum(parts.values()) < SMALLEST:
        return [f"{text}, including {hidden}."]
    share = probability_text(sum(parts.values()), 2)
    return [f"{text}; {hidden} contributes {share}, foremost {max(parts, key=lambda phrase: parts[phrase])}."]


def _repetitions(decision: Decision) -> list[str]:
    """What would make a robot pass that does not."""
    if decision.robot_passes:
        return []
    if decision.u_within_tolerance.all():
        if decision.robot_risk - decision.hidden_robot_risk.sum() > decision.risk_left:
            return ["Every axis passes by itself, not all of them together: repeat the plan, or measure more."]
        return [
            "Record what would show that physics (`expdesign run` with the objective `meir` plans it), or prove "
            "conformity by check readings with `expdesign verify`."
        ]
    times = decision.repetitions_needed
    if times is None:
        budget = decision.budget
        if np.isnan(budget.expanded[budget.matters]).any():
            return ["No number of repetitions helps: they determine no further axis."]
        if _exceeds(budget, DRAWING):
            return ["No number of repetitions helps: no reading of these markers shows that part of the tip's pose."]
        if _exceeds(budget, OWN_PAYLOAD):
            return [
                "No number of repetitions helps: what is not known of the load at a target itself exceeds the "
                "tolerance. Know that load better: its mass, its centre of mass, the direction of gravity."
            ]
        return [
            "No number of repetitions helps: what readings of this plan cannot tell from the stiffness, such as an "
            "error of the load that all of them share, exceeds the tolerance by itself. Know the load better, or "
            "measure otherwise."
        ]
    return [
        f"All measurements of the plan taken {times} times, everything set up anew each time "
        f"({times * decision.budget.measurements} measurements in all), would bring U within all tolerances; a plan "
        "that is optimised for as many measurements needs no more."
    ]


def _check_readings(count: int) -> str:
    if count == 0:
        return "No number of check readings with this instrument lets `expdesign verify` prove conformity."
    return (
        f"To prove conformity, `expdesign verify` will need {count} independent check reading"
        f"{'' if count == 1 else 's'} of every target with this instrument."
    )
