"""Columns of recordings that have no meaning here, said where recordings are read."""

import difflib
import logging

from expdesign.chain.recordings.recordings import Recordings
from expdesign.coordinates import SPATIAL
from expdesign.io.tables_in_units import synonym

_LOG = logging.getLogger(__name__)
_OF_THE_SHEET = ("do", "plan_row", "remarks")
"""Columns that the laboratory sheet has for people; recordings made from it keep them."""


def say_unknown_columns(recordings: Recordings) -> None:
    """Log on level INFO (which commands show) the columns that are kept and not used."""
    unknown = [str(name) for name in recordings.extra.columns if name not in _OF_THE_SHEET]
    if unknown:
        names = ", ".join(_with_near(name) for name in unknown)
        _LOG.info("%s: columns without a meaning here, kept but not used: %s", recordings.source, names)


def _with_near(name: str) -> str:
    """A column with the known one that it resembles: `dx_mm` is in another unit, `dxm` a slip of the pen."""
    known = ["sequence", "series", "time_s", "split", "mass_kg"]
    known += [column for names in vars(SPATIAL).values() if isinstance(names, tuple) for column in names]
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.8)
    other = near[0] if near else synonym(name)
    return f"{name} (is `{other}` meant?)" if other else name
