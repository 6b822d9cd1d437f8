"""What commands say of the points of a table before they use them: columns without a meaning, and robot limits.

Apart from `recorded.py`, so that commands which read no recordings need not load what these take.
"""

import difflib
import logging
import re
from collections.abc import Sequence

from expdesign.assurance.plausibility.finding import Implausibility, say
from expdesign.chain.recordings.columns import COLUMNS, SPELT
from expdesign.chain.recordings.recordings import SESSION, STATION, LoadedPoints, Recordings
from expdesign.coordinates import SPATIAL
from expdesign.mechanics.robots.robot import Robot

_LOG = logging.getLogger(__name__)
_SHOWN = 20
"""Columns that are named in one message."""
_OF_THE_SHEET = ("do", "plan_row", "remarks")
"""Columns that the laboratory sheet has for people; recordings made from it keep them."""
_OF_POINTS = re.compile(
    r"(target|tolerance|controller|U|correction|corrected|reading|error)_.*|leg\d+_m|s[xyz]_m|sr[xyz]_rad|beyond_calibration|"
    r"same_as|kind|points|reference_points|session"
)
"""Columns of points, plans and sheets that one command writes and another keeps or uses."""


def say_unknown_columns(points: LoadedPoints) -> None:
    """Log on level INFO (which commands show) the columns without a meaning, in recordings those that only a diagnosis
    uses apart.
    """
    recorded = isinstance(points, Recordings)
    unknown = [str(name) for name in points.extra.columns if name not in _OF_THE_SHEET]
    if not recorded:
        unknown = [name for name in unknown if not _OF_POINTS.fullmatch(name)]
    if points.markers:
        unknown = [name for name in unknown if name not in (STATION, SESSION)]
    spatial = [name for name in unknown if name in SPATIAL.pose or name in SPATIAL.deflection]
    if spatial and points.configurations.shape[1] < len(SPATIAL.pose):
        what = f"the columns {', '.join(spatial)} are of a robot in space, and this one moves in a plane"
        likely = "Is the robot file that of the robot that was measured?"
        say([Implausibility(what, likely)], points.source)
        unknown = [name for name in unknown if name not in SPELT]
    if not recorded:  # of an arm, poses of the tip that `compensate` found its commands for
        unknown = [name for name in unknown if name not in SPATIAL.pose]
    compared = points.further if recorded else {}
    kept, used = ([name for name in unknown if (name in compared) is there] for there in (False, True))
    _say_columns(points.source, "kept but not used", kept)
    _say_columns(points.source, "which `diagnose` alone uses (do residuals vary with them?)", used)


def _say_columns(source: str, what: str, names: Sequence[str]) -> None:
    if names:
        listed = ", ".join(_with_near(name) for name in names[:_SHOWN])
        listed += f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
        _LOG.info("%s: columns without a meaning here, %s: %s", source, what, listed)


def _with_near(name: str) -> str:
    """A column with the known one it resembles, in another unit (`dx_mm`), misspelt (`dxm`), numbered (`mass2`)."""
    near = [] if name in SPELT else difflib.get_close_matches(name, SPELT, n=1, cutoff=0.8)
    other = near[0] if near else COLUMNS.hint(name) or COLUMNS.hint(name.rstrip("N0123456789"))
    return f"{name} (is `{other}` meant?)" if other and other != name else name


def say_limits(points: LoadedPoints, robot: Robot) -> None:
    """Say which points are beyond the robot's limits: recorded rows may be, where a file states them too narrow."""
    rows, beyond = robot.beyond_limits(points.configurations)
    if rows.size:
        say([Implausibility(f"a point is {beyond}", "Can the robot stand there?")], points.where(int(rows[0])))
