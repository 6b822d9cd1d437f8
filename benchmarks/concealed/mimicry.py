"""How much of an effect outside the library known physics would explain: a case whose misfit vanishes beside one or two
known effects would be no fair question.

The known effects are the laboratory's own elements, in small amounts; what they change is taken as linear.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from .experiments import Experiment
from .hidden import Sized, element
from .linear_model import Array, BaseFit

_BESIDE = 2  # known effects that may stand together


def remaining_misfit(experiment: Experiment, fit: BaseFit, noise_free: Callable[[Sized], Array], sized: Sized) -> float:
    """Least sum of squared whitened residuals beside the two known effects that explain most, chosen one by one."""
    clean = fit.residual(noise_free(Sized()))
    left = fit.residual(noise_free(sized))
    blocks = [
        np.column_stack([fit.residual(noise_free(each)) - clean for each in block]) for block in _known(experiment)
    ]
    for _ in range(_BESIDE):
        remainders = [_beside(left, block) for block in blocks]
        best = int(np.argmin([each @ each for each in remainders]))
        basis = np.linalg.qr(blocks.pop(best))[0]
        left = left - basis @ (basis.T @ left)
        blocks = [block - basis @ (basis.T @ block) for block in blocks]
    return float(left @ left)


def _beside(left: Array, block: Array) -> Array:
    solution = np.linalg.lstsq(block, left, rcond=1e-9)[0]
    return np.asarray(left - block @ solution)


def _known(experiment: Experiment) -> Iterator[list[Sized]]:
    robot = experiment.machine.robot
    planar, legs = robot.planar, [f"leg {leg + 1}" for leg in range(robot.legs)]
    softest = float((1.0 / experiment.machine.true_stiffness).max())
    force = float(np.abs(experiment.forces).max())

    def one(physics: str, **parameters: object) -> Sized:
        return Sized((element(physics, **parameters),))

    turns = ("z",) if planar else ("x", "y", "z")
    tilts = ("z",) if planar else ("x", "y")
    yield [one("load_direction_tilt", **{f"tilt_{axis}_rad": 1e-3}) for axis in tilts]
    yield [one("instrument_misalignment", **{f"rot_{axis}_rad": 1e-3}) for axis in turns]
    yield [one("instrument_scale", **{f"scale_{axis}": 1e-3}) for axis in ("x", "y") + (() if planar else ("z",))]
    if not planar:
        yield [one("payload_com_offset", **{f"com_d{axis}_m": 1e-3}) for axis in turns]
        lever = 0.6 * experiment.machine.reach
        for physics in ("platform_compliance", "base_compliance"):
            compliances = 1e-6 * softest * (np.ones(6) + 1e4 * np.eye(6)) / np.array([1, 1, 1] + [lever**2] * 3)
            yield [one(physics, stiffness=1.0 / compliance) for compliance in compliances]
    for leg in legs:
        yield [one("leg_backlash", component=leg, gap_m=1e-6)]
        yield [one("leg_nonlinear_stiffness", component=leg, law="bilinear", relative_change=0.02)]
        yield [one("leg_nonlinear_stiffness", component=leg, law="cubic", cubic_per_m2=0.02 / (softest * force) ** 2)]
