"""What is said of stiffnesses: no estimate outside its own interval, no stiffness of what may be rigid."""

import numpy as np
import pandas as pd
import pytest

from expdesign.report.stiffness import stiffness_table
from tests.cases import robot


@pytest.mark.parametrize(
    ("estimate", "low", "high", "said"),
    [
        (2e7, 1.9e7, 2.1e7, "leg 1 20.00 19.00 21.00"),
        (3e12, 1.9e7, np.inf, "leg 1 not determined 19.00 ∞"),
        (-9.6e6, 2.2e7, np.inf, "leg 1 not determined 22.00 ∞"),
        (-9.6e6, np.inf, np.inf, "leg 1 not determined ∞ ∞"),
    ],
)
def test_a_compliance_that_may_be_zero_has_a_least_stiffness_alone(
    estimate: float, low: float, high: float, said: str
) -> None:
    hexapod = robot("H1")
    frame = pd.DataFrame({"actuator": hexapod.actuators, "stiffness": estimate, "low": low, "high": high})
    assert " ".join(stiffness_table(frame, hexapod, "").lines[1].split()) == said
