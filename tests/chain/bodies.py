"""A body on a support, and rows on which every effect of a support shows."""

import numpy as np
import pandas as pd

from expdesign.chain.recordings.recordings import Recordings
from expdesign.coordinates import SPATIAL
from expdesign.mechanics.robots.body import Body
from tests.identification.experiments import read
from tests.oracle import Array

BODY = Body(home=np.array([0.5, -0.2, 0.3]), name="machine on its feet")
DEVIATIONS = (2e-6, 2e-6, 2e-6, 1e-5, 1e-5, 1e-5)
ALL_AXES = tuple(range(6))


def rows(count: int = 60, *, seed: int = 0, axes: tuple[int, ...] = ALL_AXES, lifting: bool = False) -> pd.DataFrame:
    """Changes of load from a loaded reference, which is the first row; one series, unless the body `lifting` moves."""
    generator = np.random.default_rng(seed)
    changes = generator.uniform(-1.0, 1.0, (count, 6)) * [40.0, 40.0, 40.0, 150.0, 150.0, 150.0]
    changes[0] = 0.0
    reference = np.array([1.0, -3.0, -420.0, -20.0, 30.0, 5.0])
    lift = np.sort(np.resize([0.0, 0.8, 1.5], count)) if lifting else np.zeros(count)
    columns: dict[str, Array] = {
        "sequence": np.arange(1, count + 1),
        "series": np.ones(count, dtype=int),
        "time_s": np.cumsum(generator.uniform(5.0, 12.0, count)) - 5.0,
    }
    columns |= {name: lift if name == "z_m" else np.zeros(count) for name in SPATIAL.pose}
    columns |= {name: changes[:, i] for i, name in enumerate(SPATIAL.wrench)}
    columns |= {f"abs_{name}": changes[:, i] + reference[i] for i, name in enumerate(SPATIAL.wrench)}
    columns |= {SPATIAL.deflection[i]: np.zeros(count) for i in axes}
    columns |= {SPATIAL.deviation[i]: np.full(count, DEVIATIONS[i]) for i in axes}
    return pd.DataFrame(columns)


def recordings(**options: object) -> Recordings:
    """`rows` as the reader gives them."""
    return read(rows(**options), BODY)  # type: ignore[arg-type]
