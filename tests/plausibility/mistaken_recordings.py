"""Mistakes in recordings of deflections, each with what has to be said of it: frames, rows, loads, single numbers."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd

from tests.oracle import Array
from tests.plausibility.mistakes import ANGULAR, LINEAR, Frame, swapped, times

_H, _L, _A, _B, _R = "hexapod-h1", "hexapod-120kg", "ur5", "bipod", "rubin-camera"
_DEVIATIONS = ("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad")
WORDS = "xyz"


def columns(*axes: str) -> Array:
    """The axes of a frame in those of the base: `columns("y", "-x", "z")`."""
    turn = np.zeros((len(axes), len(axes)))
    for column, axis in enumerate(axes):
        turn[WORDS.index(axis[-1]), column] = -1.0 if axis.startswith("-") else 1.0
    return turn


def read_in(turn: Array) -> Frame:
    """Readings along the axes of a turned frame, as its instrument would show them."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        frame[list(LINEAR)] = frame[list(LINEAR)].to_numpy() @ turn
        frame[list(ANGULAR)] = frame[list(ANGULAR)].to_numpy() @ turn * np.linalg.det(turn)
        return frame

    return change


def loads_in(turn: Array, *triples: Sequence[str]) -> Frame:
    """Vectors in columns of threes along the axes of a turned frame."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        for triple in triples:
            frame[list(triple)] = frame[list(triple)].to_numpy() @ turn
        return frame

    return change


def shifted(names: Sequence[str], rows: int) -> Frame:
    """Columns that stand some rows late; what falls out at the end comes in at the beginning."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        frame[list(names)] = np.roll(frame[list(names)].to_numpy(), rows, axis=0)
        return frame.iloc[max(rows, 0) : len(frame) + min(rows, 0)]

    return change


def cell(row: int, name: str, act: Callable[[float], float]) -> Frame:
    """One cell changed."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame = frame.copy()
        frame.loc[frame.index[row], name] = act(float(frame[name].iloc[row]))
        return frame

    return change


def copied(source: Sequence[int], noise: float = 0.0, *, readings_only: bool = False) -> Frame:
    """Rows once more at the end, under new numbers; or their readings alone, under the commands of the last rows."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        names = [*LINEAR, *ANGULAR]
        again = frame.iloc[list(source)].copy()
        again[names] *= 1.0 + noise * np.random.default_rng(0).standard_normal((len(again), len(names)))
        if readings_only:
            frame = frame.copy()
            frame.loc[frame.index[-len(again) :], names] = again[names].to_numpy()
            return frame
        for name in ("sequence", "series"):
            again[name] = frame[name].max() + 1 + np.arange(len(again))
        return pd.concat([frame, again])

    return change


def rounded(name: str, step: float) -> Frame:
    return lambda frame: frame.assign(**{name: np.round(frame[name] / step) * step})


def constant(name: str, value: float) -> Frame:
    return lambda frame: frame.assign(**{name: value})


def standing(row: int) -> Frame:
    """The readings of the row before once more."""

    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame, names = frame.copy(), [*LINEAR, *ANGULAR]
        frame.loc[frame.index[row], names] = frame.loc[frame.index[row - 1], names]
        return frame

    return change


def exchanged(first: int, second: int) -> Frame:
    def change(frame: pd.DataFrame) -> pd.DataFrame:
        frame, names = frame.copy(), [*LINEAR, *ANGULAR]
        values = frame[names].to_numpy(copy=True)
        values[[first, second]] = values[[second, first]]
        frame[names] = values
        return frame

    return change


_CENTRE = ("com_x_m", "com_y_m", "com_z_m")
_READINGS = (*LINEAR, *ANGULAR, *_DEVIATIONS)
_POSE = ("x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad")

OF_PAYLOADS: dict[str, tuple[str, Frame, str]] = {
    "instrument turned about z": (_H, read_in(columns("y", "-x", "z")), "its x is the base's y, its y the base's −x"),
    "instrument turned about x": (_L, read_in(columns("x", "z", "-y")), "its x is the base's x, its y the base's z"),
    "instrument upside down": (_R, read_in(columns("x", "-y", "-z")), "its x is the base's x, its y the base's −y"),
    "axes in a cycle, of an arm": (_A, read_in(columns("y", "z", "x")), "its x is the base's y, its y the base's z"),
    "instrument with a left-handed frame": (_H, read_in(columns("x", "-y", "z")), "left-handed"),
    "left-handed frame of an arm": (_A, read_in(columns("y", "x", "z")), "left-handed.*its x is the base's y"),
    "centre of mass in a turned frame": (_H, loads_in(columns("z", "x", "y"), _CENTRE), "its x is the platform's z"),
    "centre of mass upside down": (_L, loads_in(columns("x", "-y", "-z"), _CENTRE), "its x is the platform's x, its y"),
    "x and y of the pose swapped": (_H, swapped("x_m", "y_m"), "x_m and y_m swapped"),
    "rx and ry of the pose swapped": (_H, swapped("rx_rad", "ry_rad"), "rx_rad and ry_rad swapped"),
    "x and z of the pose swapped": (_L, swapped("x_m", "z_m"), "x_m and z_m swapped"),
    "q2 and q3 swapped": (_A, swapped("q2_rad", "q3_rad"), "q2_rad and q3_rad swapped"),
    "sign of ry of the pose": (_H, times(-1.0, "ry_rad"), "ry_rad have the wrong sign"),
    "sign of q3": (_A, times(-1.0, "q3_rad"), "q3_rad have the wrong sign"),
    "readings a row late": (_H, shifted(_READINGS, 1), "readings stand one row too late"),
    "readings a row early": (_A, shifted(_READINGS, -1), "readings stand one row too early"),
    "load a row late": (_H, shifted(("mass_kg", *_CENTRE), 1), "loads stand one row too late"),
    "load a row early, of an arm": (_A, shifted(("mass_kg", *_CENTRE), -1), "loads stand one row too early"),
    "commands a row late": (_H, shifted(_POSE, 1), "commands stand one row too late"),
    "a reading ten times too large": (_H, cell(4, "dz_m", lambda v: 10 * v), "dz_m = .* row 6 10 times too large"),
    "a reading ten times too small": (_L, cell(1, "dz_m", lambda v: v / 10), "dz_m = .* row 3 10 times too small"),
    "a reading 100 times too large": (_A, cell(2, "dy_m", lambda v: 100 * v), "dy_m .* row 4 100 times too large"),
    "a rotation ten times too large": (_H, cell(1, "drx_rad", lambda v: 10 * v), "drx_rad .* row 3 10 times too large"),
    "sign of a single reading": (_H, cell(0, "dz_m", lambda v: -v), "dz_m = .* row 2 of the wrong sign"),
    "a mass ten times too small": (_H, cell(5, "mass_kg", lambda v: v / 10), "load of row 7 10 times too small"),
    "a mass ten times too large": (_L, cell(5, "mass_kg", lambda v: v * 10), "load of row 7 10 times too large"),
    "one mass in g": (_A, cell(5, "mass_kg", lambda v: v * 1000), "load of row 7 1000 times too large"),
    "an unloaded reading as a loaded row": (
        _H,
        lambda frame: frame.assign(
            **{name: np.where(np.arange(len(frame)) == 6, 1e-3, 1.0) * frame[name] for name in (*LINEAR, *ANGULAR)}
        ),
        "row 8 recorded without its load",
    ),
    "readings of two rows exchanged": (_H, exchanged(2, 9), "readings of rows 4 and 11 exchanged"),
    "rows copied": (_H, copied([3, 4]), "copied|agree with those of rows 5 to 6"),
    "rows copied and touched up": (_H, copied([0, 1, 2], 1e-5), "agree with those of rows 2 to 4"),
    "readings copied to other loads": (_L, copied([0, 1, 2], readings_only=True), "agree with those of rows 2 to 4"),
    "an instrument that stands still": (_H, standing(5), "stand still"),
    "dz rounded to 10 µm": (_H, rounded("dz_m", 1e-5), "dz_m is rounded to 1e-05"),
    "a rotation rounded to 10 µrad": (_L, rounded("drx_rad", 1e-5), "drx_rad is rounded to 1e-05"),
    "a column of zeros": (_H, constant("dz_m", 0.0), "dz_m is 0 in every row"),
    "a column that stands still": (_L, constant("dx_m", 1.2e-5), "dx_m is 1.2e-05 in every row"),
    "deviations ten times too large": (_H, times(10.0, *_DEVIATIONS), "scatter 1?[0-9].* times less"),
    "one deviation ten times too large": (_H, times(10.0, "sz_m"), "dz_m scatter .* times less"),
    "deviations ten times too small": (_H, times(0.1, *_DEVIATIONS), "10 times too small"),
    "deviations of an arm in mm": (_A, times(1e3, "sx_m", "sy_m", "sz_m"), "times less|no instrument|cannot be"),
    "a deviation without its reading": (_H, lambda frame: frame.drop(columns="dx_m"), "sx_m .*without its reading"),
    "weights in N": (_H, times(9.80665, "mass_kg"), "in N in the column mass_kg"),
    "masses in lb": (_H, times(1.0 / 0.45359237, "mass_kg"), "lb"),
    "readings ten times too large": (
        _H, times(10.0, *LINEAR, *ANGULAR), "readings ten times too large"),
    "readings ten times too small": (_A, times(0.1, *LINEAR, *ANGULAR), "readings ten times too small"),
    "rotations in arc minutes": (_H, times(180.0 * 60.0 / np.pi, *ANGULAR), "cannot be a deflection|arcmin"),
}  # fmt: skip
"""Into recordings with 12 rows and payloads: the configuration, the mistake, and what the message says."""

_FORCE, _MOMENT = ("fx_N", "fy_N", "fz_N"), ("mx_Nm", "my_Nm", "mz_Nm")

OF_WRENCHES: dict[str, tuple[str, Frame, str]] = {
    "forces in kgf": (_H, times(1.0 / 9.80665, *_FORCE, *_MOMENT), "kgf"),
    "forces in kgf, moments in N·m": (_L, times(1.0 / 9.80665, *_FORCE), "kgf|times"),
    "wrench in a turned frame": (_H, loads_in(columns("y", "-x", "z"), _FORCE, _MOMENT), "its x is the base's y"),
    "fx and fy swapped": (_H, swapped("fx_N", "fy_N"), "fx_N and fy_N swapped"),
    "signs of an arm's wrench": (_A, times(-1.0, *_FORCE, *_MOMENT), "loads, have the wrong sign"),
    "moments in N·mm": (_H, times(1e3, *_MOMENT), "N·mm"),
    "one force without its sign": (_A, cell(6, "fz_N", lambda v: -v), "fz_N = .* in row 8 of the wrong sign"),
}
"""The same for recordings with wrenches in place of payloads."""
