"""The law as a curve: what was found over the range of its inputs, with its 95 % band."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from expdesign.arrays import FloatArray
from expdesign.chain.ports.law import Law
from expdesign.chain.ports.quantities import Quantity
from expdesign.mechanics.robots.robot import Robot

_NORMAL_95 = 1.959963984540054
_POINTS = 61


@dataclass(frozen=True)
class Curve:
    """A law over its inputs. Where it has several, each is varied with the others at their medians.

    Attributes:
        output: which component of the port's motion or wrench, shape (P,) of names.
        varied: index of the input that is varied, shape (P,).
        inputs: shape (P, d).
        mean, deviation: of the law, shape (P,).
        quantities: the inputs.
        meaning: what mean is: `compliance`, `elongation`, or `law`.
        unit: of mean.
    """

    output: tuple[str, ...]
    varied: tuple[int, ...]
    inputs: FloatArray
    mean: FloatArray
    deviation: FloatArray
    quantities: tuple[Quantity, ...]
    meaning: str
    unit: str

    @property
    def low(self) -> FloatArray:
        """Lower end of the 95 % band."""
        return self.mean - _NORMAL_95 * self.deviation

    @property
    def high(self) -> FloatArray:
        """Upper end of the 95 % band."""
        return self.mean + _NORMAL_95 * self.deviation

    def frame(self, names: list[str]) -> pd.DataFrame:
        """As a table with these names of the inputs."""
        columns: dict[str, object] = {"output": list(self.output), "varied": [names[i] for i in self.varied]}
        columns |= {name: self.inputs[:, i] for i, name in enumerate(names)}
        columns |= {"mean": self.mean, "low": self.low, "high": self.high}
        return pd.DataFrame(columns)


def curve_of(
    law: Law, robot: Robot, values: FloatArray, covariance: FloatArray, part: slice, seen: FloatArray
) -> Curve:
    """The curve of a law in a fitted model.

    What the springs do anyway is aliased with a law of an actuator's force or compliance, so that of these the
    whole is drawn: compliance (m/N) or elongation (m) of the actuator.

    Args:
        law: the link.
        robot: the robot.
        values: parameters of the model, compliances first.
        covariance: of all of them.
        part: parameters of the law.
        seen: inputs of its first channel in the fitted rows, shape (N, d).
    """
    form, whole = law.form, _whole(law)
    rank, inner = form.basis.rank, np.where(np.isfinite(covariance), covariance, 0.0)
    first: dict[int, int] = {}
    for index, channel in enumerate(form.channels):
        first.setdefault(channel.block, index)
    outputs, varied, points, slopes = [], [], [], []
    for block, index in first.items():
        channel = form.channels[index]
        grid, which = _grid(form.low[index], form.high[index], np.median(seen, axis=0))
        rows = np.zeros((len(grid), len(values)))
        start = part.start + block * rank
        rows[:, start : start + rank] = channel.gain * form.basis.values(grid)
        if whole is not None:
            factor = robot.compliance[channel.output]
            rows[:, channel.output] = factor if whole == "compliance" else factor * grid[:, 0]
        outputs += [law.port.outputs[channel.output]] * len(grid)
        varied += which
        points.append(grid + [quantity.counted_from for quantity in channel.inputs])
        slopes.append(rows)
    moved = np.concatenate(slopes)
    deviation = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", moved, inner, moved), 0.0))
    unit = {"compliance": "m/N", "elongation": "m", None: ""}[whole]
    quantities = form.channels[0].inputs
    mean: FloatArray = moved @ values
    found = np.concatenate(points), mean, deviation
    return Curve(tuple(outputs), tuple(varied), *found, quantities, whole or "law", unit)


def _whole(law: Law) -> str | None:
    """What of an actuator a law is a part of."""
    form = law.form
    if form.port != "actuators":
        return None
    if form.kind == "compliance" and form.channels[0].amplitude is not None:
        return "compliance"
    inputs = form.channels[0].inputs
    if form.kind == "force law" and len(inputs) == 1 and inputs[0].kind == "effort":
        return "elongation"
    return None


def _grid(low: FloatArray, high: FloatArray, middle: FloatArray) -> tuple[FloatArray, list[int]]:
    points, which = [], []
    for i in range(len(low)):
        count = _POINTS if len(low) == 1 else _POINTS // 2
        line = np.repeat(np.clip(middle, low, high)[None], count, axis=0)
        line[:, i] = np.linspace(low[i], high[i], count)
        points.append(line)
        which += [i] * count
    return np.concatenate(points), which
