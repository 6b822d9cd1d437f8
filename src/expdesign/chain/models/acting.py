"""What a model file says of errors of the recorded loads that act at targets as well, beside its parameters.

They belong to the weights or to the direction of gravity, not to the machine: predictions of readings leave them out,
and a target has them where it carries the same weights or stands on the same base.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.chain.chain import Chain
from expdesign.chain.effect import Effect
from expdesign.chain.models.checked import AGAIN, covariance_of
from expdesign.chain.models.effect_entry import EffectSection, effect_entry, effect_of
from expdesign.chain.models.estimable import Estimable
from expdesign.chain.models.matrix_rows import MatrixRows, matrix_rows
from expdesign.io.schema import Section
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class ActingLoads:
    """Errors of loads, as effects that join a model at its targets.

    Attributes:
        effects: of the chain.
        values: their parameters, shape (d,).
        covariance: with the p parameters of the model, and then among themselves, shape (d, p + d).
    """

    effects: tuple[Effect, ...]
    values: FloatArray
    covariance: FloatArray

    def joined(self, known: Estimable) -> Estimable:
        """What is known of the parameters of a model and of these."""
        count, width = self.covariance.shape
        own = self.covariance[:, width - count :]
        whole = np.block([[known.generalised, self.covariance[:, : width - count].T], [self.covariance]])
        # No reading shows a direction that is not determined, so that these do not depend on it.
        directions = np.vstack([known.directions, np.zeros((count, known.directions.shape[1]))])
        return Estimable(whole, directions, np.concatenate([known.resolution, np.sqrt(np.diag(own))]))


class ActingSection(Section):
    """`load_errors` of a model file: effects, and rows of the covariance of all `parameters` and theirs."""

    effects: list[EffectSection]
    covariance: MatrixRows


def acting_entry(acting: ActingLoads | None, scale: FloatArray) -> dict[str, object]:
    """The key `load_errors` of a model file whose parameters stand in units of a scale (p,); nothing for None."""
    if acting is None:
        return {}
    joint = Chain(acting.effects[0].robot, acting.effects)
    parts = [slice(part.start - joint.base, part.stop - joint.base) for part in joint.slices]
    entries = [
        effect_entry(effect, acting.values[part].tolist()) for effect, part in zip(acting.effects, parts, strict=True)
    ]
    units = np.concatenate([scale, np.ones(len(acting.values))])
    return {"load_errors": {"effects": entries, "covariance": matrix_rows(acting.covariance * units)}}


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
    if not count or len(section.covariance) != count or any(len(row) != width for row in section.covariance):
        raise place.fault(
            f"{count} rows of {width} numbers are needed here", f"Order: `parameters`, then these. {AGAIN}"
        )
    if not np.isfinite(section.covariance).all():
        raise place.fault("finite numbers are needed here", AGAIN)
    rows = np.array(section.covariance) / np.concatenate([scale, np.ones(count)])
    found = ActingLoads(effects, np.array(values), rows)
    whole = found.joined(known).generalised
    covariance_of(whole.tolist(), width, place)
    return found
