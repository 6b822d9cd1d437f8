"""The recordings, who they are by, and where they are looked for."""

import os
from dataclasses import dataclass
from pathlib import Path

VARIABLE = "EXPDESIGN_RECORDINGS"
"""Environment variable that names the folder of the recordings."""
DEFAULT = Path(__file__).resolve().parents[2].parent / "shared" / "recordings"
"""`../shared/recordings`, seen from the project's root."""


@dataclass(frozen=True)
class Case:
    """One file to be diagnosed.

    Attributes:
        folder: of the set.
        file: without `.csv`.
        robot: robot file.
        others: files of the same set, under other conditions, on which the model is tested as it is.
        target: held-out RMS that was set as the target, in standard deviations.
        known: best held-out RMS that is known of any model, this program's earlier states included; None where none is.
    """

    folder: str
    file: str
    robot: str = "robot.yaml"
    others: tuple[str, ...] = ()
    target: float | None = None
    known: float | None = None

    @property
    def name(self) -> str:
        """Name of the page."""
        known = "" if self.robot == "robot.yaml" else "-" + self.robot.removeprefix("robot_").removesuffix(".yaml")
        return f"{self.folder}-{self.file}{known}"


_CONDITIONS = ("flat", "pallet", "orthogonal_wood", "wood_left_track")


def _but(condition: str, ending: str = "") -> tuple[str, ...]:
    return tuple(f"{other}{ending}" for other in _CONDITIONS if other != condition)


def _each(of: str, ending: str, targets: tuple[float, ...], known: tuple[float, ...]) -> tuple[Case, ...]:
    """One set under every condition."""
    return tuple(
        Case(of, f"{c}{ending}", others=_but(c, ending), target=target, known=best)
        for c, target, best in zip(_CONDITIONS, targets, known, strict=True)
    )


CASES = (
    *_each("jaibot-tilt", "", (1.0, 1.4, 1.4, 6.5), (1.19, 1.42, 1.27, 6.2)),
    *_each("jaibot-column", "", (6.5,) * 4, (5.3, 6.4, 5.2, 4.8)),
    Case("tiago-forceplate", "recordings", others=("recordings_after_stop",), target=38.0, known=40.0),
    *_each("jaibot-prism", "_by_station", (1.0, 1.0, 1.0, 1.15), (0.88, 0.93, 0.80, 1.05)),
    Case("jaibot-prism", "flat"),
    Case("jaibot-prism", "flat", "robot_marker_known.yaml", target=5.0, known=4.5),
)
"""Best known: the prototype of laws at ports (prisms, columns, mobile base), the program before (tilts)."""

_HILTI = """Source: *Construction Robot Stationing Datasets*, copyright Hilti (Hilti-Research on GitHub),
https://github.com/Hilti-Research/construction_robot_stationing_datasets, commit f26546d2, used under
[CC BY-NC-SA 3.0](https://creativecommons.org/licenses/by-nc-sa/3.0/); rows were re-arranged and quantities computed.
**This page is derived from those data and is under the same licence (CC BY-NC-SA 3.0: attribution, non-commercial use,
share alike), not under the licence of the project.** The licensors do not endorse it. It holds no recordings."""

NOTICES = {"jaibot-tilt": _HILTI, "jaibot-column": _HILTI, "jaibot-prism": _HILTI}
"""What a page of each set says of source and licence; others take it from the set's README (`notice`)."""


def folder() -> Path:
    """Where the recordings are, whether they are there or not."""
    return Path(os.environ.get(VARIABLE, str(DEFAULT)))
