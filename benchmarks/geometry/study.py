"""Experiments repeated: coverage of intervals, error on held-out poses against the Cramér-Rao bound, and what is gained
by identifying geometry and stiffness from the same rows; and what remains after compensation.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.geometry.experiment import (
    ERRORS,
    NOISE,
    Plan,
    cramer_rao,
    drawn_machine,
    empty_recordings,
    held_out_plan,
    measured,
    paired_plan,
    robot,
)
from benchmarks.geometry.machine import Array

from expdesign.app.api.inputs import table_of
from expdesign.chain.models.model_file import Model
from expdesign.chain.recordings.reader import points_from_table
from expdesign.chain.recordings.recordings import LoadedPoints, Recordings
from expdesign.estimation.compensation.compensate import compensate
from expdesign.estimation.compensation.prediction import predict
from expdesign.estimation.identify import Identification, identify
from expdesign.io.yaml_reader import YamlDocument
from expdesign.mechanics.elastostatics.maps import observation_matrix
from expdesign.mechanics.robots.hexapod import Hexapod

COMMANDS = 20
HELD_OUT = 30


def model_of(result: Identification) -> Model:
    """The identified model, without a file."""
    fit = result.fit
    return Model.from_fit(fit, YamlDocument("simulated", Path(), {}), "simulated")


def points_of(hexapod: Hexapod, plan: Plan) -> LoadedPoints:
    """Points at which poses are predicted."""
    return points_from_table(table_of(plan.table(), "held out"), hexapod)


def repeated(experiments: int, seed: int) -> dict[str, Any]:
    """Machine and noise drawn anew `experiments` times, all measured by one plan."""
    hexapod = robot()
    plan, held_out = paired_plan(COMMANDS, seed), held_out_plan(HELD_OUT, seed)
    empty, points = empty_recordings(hexapod, plan), points_of(hexapod, held_out)
    bound = np.einsum("nii->ni", cramer_rao(hexapod, plan, held_out))
    inside, predicted_inside = np.zeros(48), 0.0
    together, apart, doubted = [], [], 0
    for number in range(experiments):
        random = np.random.default_rng([seed, 3, number])
        machine, errors = drawn_machine(hexapod, random)
        recordings = measured(empty, machine.poses(plan.commands, plan.wrenches), random)
        truth = machine.poses(held_out.commands, held_out.wrenches)
        result = identify(hexapod, recordings, calibration="both")
        inside += _inside(result, hexapod, errors)
        doubted += (result.goodness.p_value or 0.0) < 0.05
        prediction = predict(model_of(result), points)
        left = prediction.deflections - truth
        predicted_inside += float((np.abs(left) <= 1.959964 * prediction.deviations).mean())
        together.append(left)
        apart.append(predict(_one_after_the_other(hexapod, recordings), points).deflections - truth)
    best = float(np.sqrt((bound / NOISE**2).mean()))
    whitened = np.sqrt((np.array(together) ** 2 / NOISE**2).mean(axis=(1, 2)))
    sequential = np.sqrt((np.array(apart) ** 2 / NOISE**2).mean(axis=(1, 2)))
    mean = float(np.sqrt((whitened**2).mean()))
    return {
        "experiments": experiments,
        "seed": seed,
        "rows": 2 * COMMANDS,
        "held_out": HELD_OUT,
        "coverage": {
            "geometry": float(inside[:42].sum() / experiments / 42),
            "compliance": float(inside[42:].sum() / experiments / 6),
            "least": float(inside.min() / experiments),
            "most": float(inside.max() / experiments),
            "held_out_poses": predicted_inside / experiments,
        },
        "chi2_below_5_percent": doubted / experiments,
        "error": _scales(np.array(together)),
        "bound": _scales(np.sqrt(bound)[None]),
        "ratio_to_bound": mean / best,
        "ratio_standard_error": float((whitened**2).std() / (2.0 * mean * best) / np.sqrt(experiments)),
        "one_after_the_other": _scales(np.array(apart)),
        "gain": float(np.sqrt((sequential**2).mean())) / mean,
    }


def _scales(errors: Array) -> dict[str, float]:
    """RMS along and about the axes, in µm and µrad."""
    return {
        "um": 1e6 * float(np.sqrt((errors[..., :3] ** 2).mean())),
        "urad": 1e6 * float(np.sqrt((errors[..., 3:] ** 2).mean())),
    }


def _inside(result: Identification, hexapod: Hexapod, errors: Array) -> Array:
    """Which of the 48 true values lie in their 95 % intervals, shape (48,)."""
    assert result.geometry is not None
    geometry, compliance = result.geometry, result.compliance
    true = hexapod.compliance * (1.0 + errors[42:])
    of_geometry = (geometry.low <= errors[:42]) & (errors[:42] <= geometry.high)
    of_compliance = (compliance.low <= true) & (true <= compliance.high)
    return np.concatenate([of_geometry, of_compliance]).astype(float)


def _one_after_the_other(hexapod: Hexapod, recordings: Recordings) -> Model:
    """The geometry from the rows without load, then the stiffness from the differences of the rows of each command.

    The differences are fitted with the nominal geometry, as a laboratory does that identifies stiffness on its own.
    """
    geometry = model_of(identify(hexapod, recordings, calibration="geometric"))
    loaded = np.flatnonzero(np.any(recordings.wrenches != 0.0, axis=1))
    differences = recordings.deflections[loaded] - recordings.deflections[loaded - 1]
    jacobians = hexapod.jacobians(recordings.configurations[loaded])
    regressor = observation_matrix(jacobians, recordings.wrenches[loaded]) * hexapod.compliance
    weighted = (regressor / NOISE[:, None]).reshape(-1, 6)
    values = geometry.values.copy()
    values[:6] = np.linalg.lstsq(weighted, (differences / NOISE).ravel(), rcond=None)[0]
    return replace(geometry, values=values)


def compensated(machines: int, seed: int) -> dict[str, Any]:
    """Errors of 0.5 mm in joints and 0.25 mm in lengths: the pose under load before and after compensation."""
    hexapod = robot()
    plan, targets = paired_plan(COMMANDS, seed), held_out_plan(HELD_OUT, seed)
    empty, points = empty_recordings(hexapod, plan), points_of(hexapod, targets)
    before, after, stated = [], [], []
    for number in range(machines):
        random = np.random.default_rng([seed, 4, number])
        machine, _ = drawn_machine(hexapod, random, scale=2.5)
        recordings = measured(empty, machine.poses(plan.commands, plan.wrenches), random)
        found = compensate(model_of(identify(hexapod, recordings)), points)
        before.append(machine.poses(targets.commands, targets.wrenches) - targets.commands)
        after.append(machine.poses(found.commands, targets.wrenches) - targets.commands)
        stated.append(found.deviations)
    return {
        "machines": machines,
        "joints_mm": 1e3 * 2.5 * float(ERRORS[0]),
        "before": _scales(np.array(before)),
        "after": _scales(np.array(after)),
        "stated": _scales(np.array(stated)),
    }
