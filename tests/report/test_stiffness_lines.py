"""What a terminal says of stiffnesses: no estimate outside its own interval, no stiffness of what may be rigid."""

import numpy as np
import pandas as pd
import pytest

from expdesign.report.stiffness import stiffness_lines
from tests.cases import robot


@pytest.mark.parametrize(
    ("estimate", "low", "high", "said"),
    [
        (2e7, 1.9e7, 2.1e7, "leg 1: 2e+07 N/m (95 %: 1.9e+07 to 2.1e+07)"),
        (3e12, 1.9e7, np.inf, "leg 1: stiffer than 1.9e+07 N/m (95 %): its compliance may be 0"),
        (-9.6e6, 2.2e7, np.inf, "leg 1: stiffer than 2.2e+07 N/m (95 %): its compliance may be 0"),
        (-9.6e6, np.inf, np.inf, "leg 1: no stiffness: its compliance came out negative"),
    ],
)
def test_a_compliance_that_may_be_zero_has_a_least_stiffness_alone(
    estimate: float, low: float, high: float, said: str
) -> None:
    hexapod = robot("H1")
    numbers = {"stiffness": estimate, "low": low, "high": high}
    lines = stiffness_lines(pd.DataFrame({"actuator": hexapod.actuators, **numbers}), hexapod)
    assert lines[0] == said
