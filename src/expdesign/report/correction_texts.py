"""Corrections of commands in words: a line for every target, and one for all of them."""

import numpy as np

from expdesign.arrays import FloatArray
from expdesign.estimation.compensation.corrections import Corrections

MOST_LINES = 20
"""Targets that are listed; of more the largest corrections are."""


def correction_lines(corrections: Corrections, sequence: list[int], translations: int) -> list[str]:
    """A table of the corrections, rows in the order of the targets.

    Args:
        corrections: of N targets.
        sequence: their numbers, N.
        translations: number of leading axes that are lengths.
    """
    count = len(sequence)
    chosen = np.arange(count)
    if count > MOST_LINES:
        chosen = np.sort(np.argsort(-corrections.translation, kind="stable")[:MOST_LINES])
    rows = [("target", "correction", "", "U (k = 2)", "", "beyond what was calibrated")]
    for row in chosen:
        length, angle = _parts(corrections.expanded[row], translations)
        rows.append(
            (
                str(sequence[row]),
                metres(float(corrections.translation[row])),
                radians(float(corrections.rotation[row])) if angle is not None else "",
                metres(length),
                "" if angle is None else radians(angle),
                "; ".join(map(str, corrections.beyond[row])) or "-",
            )
        )
    widths = [max(len(row[column]) for row in rows) for column in range(5)]
    lines = ["  ".join([*(cell.rjust(w) for cell, w in zip(row, widths, strict=False)), row[5]]) for row in rows]
    if count > MOST_LINES:
        lines.append(f"({count - MOST_LINES} smaller corrections are in the file)")
    return lines


def correction_summary(corrections: Corrections, translations: int) -> str:
    """The largest correction and the largest uncertainty."""
    length, angle = _parts(corrections.expanded, translations)
    size = [metres(float(corrections.translation.max()))]
    known = [metres(length)]
    if angle is not None:
        size.append(radians(float(corrections.rotation.max())))
        known.append(radians(angle))
    text = f"largest correction {', '.join(size)}; expected U {', '.join(known)}"
    outside = sum(bool(row) for row in corrections.beyond)
    if outside:
        text += f"; {outside} of {len(corrections.beyond)} targets beyond what was calibrated"
    return text


def metres(value: float) -> str:
    """A length in µm, in mm from 1 mm on."""
    return _scaled(value, "m")


def radians(value: float) -> str:
    """An angle in µrad, in mrad from 1 mrad on."""
    return _scaled(value, "rad")


def _scaled(value: float, unit: str) -> str:
    if not np.isfinite(value):
        return "not determined"
    return f"{value * 1e3:.3g} m{unit}" if value >= 1e-3 else f"{value * 1e6:.3g} u{unit}"


def _parts(expanded: FloatArray, translations: int) -> tuple[float, float | None]:
    """Largest U of lengths and of angles, None where there are none."""
    lengths, angles = expanded[..., :translations], expanded[..., translations:]
    return float(lengths.max()), float(angles.max()) if angles.shape[-1] else None
