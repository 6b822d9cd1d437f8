"""Concealed physics of single legs: play, friction, creep, temperature, nonlinear springs, screws."""

from __future__ import annotations

import numpy as np

from .case import UnsuitableError
from .experiments import Experiment, Wishes
from .hidden import Hidden, Recipe, Sized, element, leg_or_all, numbers_of, pick_leg


def _backlash(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg = f"leg {pick_leg(experiment, rng, reversals=True) + 1}"
    rest = str(rng.choice(["middle", "short", "long"]))

    def of_size(size: float) -> Sized:
        return Sized((element("leg_backlash", component=leg, gap_m=size, rest=rest),))

    return Hidden("leg_backlash", (leg,), 1e-7, 8e-5, of_size)


def _friction(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    legs = numbers_of(component, experiment.machine.robot.legs)
    parameters: dict[str, float] = {}
    if rng.random() < 0.5:
        stiffness = float(experiment.machine.true_stiffness[list(legs)].mean())
        parameters = {"contact_N_per_m": stiffness * rng.uniform(2, 10), "sliders": int(rng.integers(1, 4))}
    largest = float(np.abs(experiment.forces[:, list(legs)]).max())

    def of_size(size: float) -> Sized:
        return Sized((element("friction_hysteresis", component=component, friction_N=size, **parameters),))

    return Hidden("friction_hysteresis", (component,), 1e-3 * largest, 0.4 * largest, of_size)


def _creep(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng)
    rows = experiment.rows
    spans = rows.groupby("series")["time_s"].agg(np.ptp)
    tau = float(f"{spans.median() / rng.uniform(1.0, 4.0):.4g}")
    applied = 0.0 if rng.random() < 0.5 else round(float(rng.uniform(0.0, 0.6)), 2)

    def of_size(size: float) -> Sized:
        return Sized((element("creep", component=component, creep_ratio=size, tau_s=tau, applied=applied),))

    return Hidden("creep", (component,), 2e-3, 1.0, of_size)


def _thermal(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    component = leg_or_all(experiment, rng, every=0.4)
    sign = rng.choice([-1.0, 1.0])
    if "temperature_degC" in experiment.rows and rng.random() < 0.75:
        return Hidden(
            "thermal_drift",
            (component,),
            1e-7,
            1e-4,
            lambda size: Sized((element("thermal_drift", component=component, alpha_per_K=sign * size),)),
        )
    spans = experiment.rows.groupby("series")["time_s"].agg(np.ptp)
    strain = 3e-4 / float(spans.median())
    return Hidden(
        "thermal_drift",
        (component,),
        1e-4 * strain,
        strain,
        lambda size: Sized((element("thermal_drift", component=component, rate_per_s=sign * size),)),
    )


def _nonlinear(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    law = str(rng.choice(["hertz", "cubic", "bilinear"]))
    component = leg_or_all(experiment, rng, reversals=law == "bilinear")
    legs = list(numbers_of(component, experiment.machine.robot.legs))
    largest = float(np.abs(experiment.forces[:, legs]).max())
    stretch = largest / float(experiment.machine.true_stiffness[legs].min())
    sign = rng.choice([-1.0, 1.0])
    physics = "leg_nonlinear_stiffness"
    if law == "hertz":
        preload = 0.0 if rng.random() < 0.5 else 0.2 * largest * rng.random()
        low, high = 1e-3 * stretch / largest ** (2 / 3), 2.0 * stretch / largest ** (2 / 3)

        def of_size(size: float) -> Sized:
            return Sized((element(physics, component=component, law=law, contact_m_per_N23=size, preload_N=preload),))
    elif law == "cubic":
        low, high = 1e-3 / stretch**2, (1.5 if sign > 0 else 0.12) / stretch**2

        def of_size(size: float) -> Sized:
            return Sized((element(physics, component=component, law=law, cubic_per_m2=sign * size),))
    else:
        low, high = 2e-3, 0.6

        def of_size(size: float) -> Sized:
            return Sized((element(physics, component=component, law=law, relative_change=sign * size),))

    return Hidden(physics, (component,), low, high, of_size)


def _encoder(experiment: Experiment, rng: np.random.Generator) -> Hidden:
    leg = f"leg {rng.integers(experiment.machine.robot.legs) + 1}"
    pitch, phase = float(rng.choice([1.0, 1.25, 2.0, 2.5, 4.0, 5.0])) * 1e-3, float(rng.uniform(0, 2 * np.pi))
    if experiment.rows.loc[experiment.fitted, "series"].nunique() < 12:
        raise UnsuitableError("a period needs at least 12 commands")

    def of_size(size: float) -> Sized:
        entry = element("encoder_periodic_error", component=leg, amplitude_m=size, pitch_m=pitch, phase_rad=phase)
        return Sized((entry,))

    return Hidden("encoder_periodic_error", (leg,), 5e-8, 5e-5, of_size)


RECIPES = (
    Recipe("leg_backlash", lambda rng: Wishes(reversals=True), _backlash),
    Recipe("friction_hysteresis", lambda rng: Wishes(path="stairs"), _friction),
    Recipe("creep", lambda rng: Wishes(path="hold", time=True), _creep),
    Recipe("thermal_drift", lambda rng: Wishes(time=True, temperature=rng.random() < 0.8), _thermal),
    Recipe("leg_nonlinear_stiffness", lambda rng: Wishes(reversals=rng.random() < 0.7), _nonlinear),
    Recipe("encoder_periodic_error", lambda rng: Wishes(series=15), _encoder),
)
