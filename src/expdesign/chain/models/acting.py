"""What a model file says of errors of the recorded loads that act at targets as well, beside its parameters.

They belong to the weights or to the direction of gravity, not to the machine: a target has them where it carries the
same weights or stands on the same base. Recordings have estimated those that rows share; what every loading has for
itself is drawn anew at a target.
"""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from expdesign.arrays import FloatArray
from expdesign.chain.effect import Effect
from expdesign.chain.models.checked import AGAIN, covariance_of
from expdesign.chain.models.effect_entry import EffectSection, effect_entry, effect_of
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.models.matrix_rows import MatrixRows, matrix_rows
from expdesign.coordinates import Coordinates
from expdesign.io.schema import Positive, Section
from expdesign.mechanics.robots.robot import Robot


def own_names(coordinates: Coordinates) -> tuple[str, ...]:
    """Errors that a loading can have for itself: mass (kg), centre of mass (m), tilt of gravity (rad)."""
    return ("mass_kg", *coordinates.centre_of_mass, *coordinates.tilt)


@dataclass(frozen=True)
class ActingLoads:
    """Errors of loads, as effects that join a model at its targets.

    Attributes:
        effects: of the chain.
        values: their parameters, shape (d,).
        covariance: with the p parameters of the model, and then among themselves, shape (d, p + d).
        own: standard deviations of what every loading has for itself, in the order of `own_names`, shape (o,).
    """

    effects: tuple[Effect, ...]
    values: FloatArray
    covariance: FloatArray
    own: FloatArray

    def joined(self, known: Estimable) -> Estimable:
        """What is known of the parameters of a model and of these."""
        count, width = self.covariance.shape
        own = self.covariance[:, width - count :]
        whole = np.block([[known.generalised, self.covariance[:, : width - count].T], [self.covariance]])
        # No reading shows a direction that is not determined, so that these do not depend on it.
        directions = np.vstack([known.directions, np.zeros((count, known.directions.shape[1]))])
        return Estimable(whole, directions, np.concatenate([known.resolution, np.sqrt(np.diag(own))]))


class ActingSection(Section):
    """`load_errors` of a model file.

    Effects, rows of the covariance of all `parameters` and theirs, standard deviations of what every loading has anew.
    """

    effects: list[EffectSection] = Field(default=[])
    covariance: MatrixRows = Field(default=[])
    every_loading: dict[str, Positive] = Field(default={})


def acting_entry(acting: ActingLoads | None, scale: FloatArray, coordinates: Coordinates) -> dict[str, object]:
    """The key `load_errors` of a model file whose parameters stand in units of a scale (p,); nothing for None."""
    if acting is None:
        return {}
    found: dict[str, object] = {}
    if acting.effects:
        ends = np.cumsum([len(effect.parameters) for effect in acting.effects])
        parts = zip(acting.effects, np.split(acting.values, ends[:-1]), strict=True)
        units = np.concatenate([scale, np.ones(len(acting.values))])
        found["effects"] = [effect_entry(effect, values.tolist()) for effect, values in parts]
        found["covariance"] = matrix_rows(acting.covariance * units)
    if acting.own.any():
        names = own_names(coordinates)
        found["every_loading"] = {name: float(own) for name, own in zip(names, acting.own, strict=True) if own}
    return {"load_errors": found}


def acting_of(section: ActingSection | None, robot: Robot, known: Estimable, scale: FloatArray) -> ActingLoads | None:
    """What the section says beside what is known of the parameters, which stand in units of a scale (p,).

    Raises:
        InputError: an effect is not known, or the covariance does not fit the parameters or is none.
    """
    if section is None:
        return None
    effects = tuple(effect_of(entry, robot) for entry in section.effects)
    values = [entry.parameters[p.name] for entry, e in zip(section.effects, effects, strict=True) for p in e.parameters]
    count, width = len(values), len(scale) + len(values)
    place = section.where("covariance")
    if len(section.covariance) != count or any(len(row) != width for row in section.covariance):
        raise place.fault(
            f"{count} rows of {width} numbers are needed here", f"Order: `parameters`, then these. {AGAIN}"
        )
    if not np.isfinite(section.covariance).all():
        raise place.fault("finite numbers are needed here", AGAIN)
    names = own_names(robot.coordinates)
    for name in section.every_loading:
        if name not in names:
            raise section.where("every_loading").fault(f"unknown key `{name}`", f"Known: {', '.join(names)}.")
    own = np.array([section.every_loading.get(name, 0.0) for name in names])
    rows = np.array(section.covariance).reshape(count, width) / np.concatenate([scale, np.ones(count)])
    found = ActingLoads(effects, np.array(values), rows, own)
    whole = found.joined(known).generalised
    covariance_of(whole.tolist(), width, place)
    return found
