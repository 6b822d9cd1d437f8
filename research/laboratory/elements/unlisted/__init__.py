"""Physics of machines for which no effect was written, one class each."""

from __future__ import annotations

from . import instrument, leg_curves, leg_memories, mounts, surroundings
from .law import Unlisted

UNLISTED: dict[str, type[Unlisted]] = {
    element.identifier: element
    for module in (instrument, leg_curves, leg_memories, mounts, surroundings)
    for element in vars(module).values()
    if isinstance(element, type) and issubclass(element, Unlisted) and hasattr(element, "identifier")
}
"""By identifier."""
