"""The one exception of the virtual laboratory."""

from __future__ import annotations


class LaboratoryError(ValueError):
    """Input that cannot be used, or an equilibrium that cannot be found; the message says which."""
