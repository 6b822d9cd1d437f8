"""A virtual laboratory: parallel robots with hidden physics, solved by an independent multibody engine.

It stands in for hardware and knows nothing of any model that is to be tested against it.
"""

from __future__ import annotations

from .errors import LaboratoryError
from .laboratory import Laboratory
from .robot import Robot

__all__ = ["Laboratory", "LaboratoryError", "Robot"]
