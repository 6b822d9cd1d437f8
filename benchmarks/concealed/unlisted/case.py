"""What a case is to those who ask and judge, whoever made it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import pandas as pd


@dataclass(frozen=True)
class Case:
    """What a diagnosis may read (`robot`, `recordings`, further `files` by name), and what the judge alone knows.

    `later` are the held-out rows with the noise-free columns `true_*` and, where the judge's own base model does not
    know the robot, its predictions `base_*`.
    """

    robot: dict[str, Any]
    recordings: pd.DataFrame
    later: pd.DataFrame
    truth: dict[str, Any]
    files: dict[str, str] = field(default_factory=dict)
