"""Laws as curves with their 95 % bands, drawn as SVG inside a page."""

import numpy as np

from expdesign.arrays import BoolArray
from expdesign.chain.ports.curve import Curve

_WIDTH, _HEIGHT, _LEFT, _BOTTOM = 280, 180, 58, 34
_MOST = 12
"""Panels of one law."""


def drawn(curve: Curve, columns: tuple[str, ...]) -> str:
    """A figure with one panel for every output and every input that is varied."""
    panels: list[str] = []
    outputs, varied = np.array(curve.output), np.array(curve.varied)
    for output in dict.fromkeys(curve.output):
        for i, column in enumerate(columns):
            chosen: BoolArray = (outputs == output) & (varied == i)
            if chosen.any() and len(panels) < _MOST:
                panels.append(_panel(curve, chosen, i, column, output))
    caption = "Law with its 95 % band; other inputs at their medians."
    return f"<figure>{''.join(panels)}<figcaption>{caption}</figcaption></figure>"


def _panel(curve: Curve, chosen: BoolArray, varied: int, column: str, output: str) -> str:
    order = np.argsort(curve.inputs[chosen, varied], kind="stable")
    x = curve.inputs[chosen, varied][order]
    mean, low, high = (values[chosen][order] for values in (curve.mean, curve.low, curve.high))
    left, right = float(x[0]), float(x[-1])
    bottom, top = float(low.min()), float(high.max())

    def place(a: float, b: float) -> str:
        across = _LEFT + (_WIDTH - _LEFT - 8) * (a - left) / max(right - left, 1e-300)
        up = 8 + (_HEIGHT - _BOTTOM - 8) * (top - b) / max(top - bottom, 1e-300)
        return f"{across:.1f},{up:.1f}"

    band = " ".join([*map(place, x, high), *map(place, x[::-1], low[::-1])])
    line = " ".join(map(place, x, mean))
    text = 'font-size="10" font-family="sans-serif" fill="#444"'
    return (
        f'<svg width="{_WIDTH}" height="{_HEIGHT}" role="img" aria-label="{output} over {column}">'
        f'<polygon points="{band}" fill="#cfe0f3"/><polyline points="{line}" fill="none" stroke="#1f5a9e"/>'
        f'<path d="M{_LEFT},8 V{_HEIGHT - _BOTTOM} H{_WIDTH - 8}" fill="none" stroke="#444"/>'
        f'<text x="{_LEFT - 4}" y="15" text-anchor="end" {text}>{top:.2g}</text>'
        f'<text x="{_LEFT - 4}" y="{_HEIGHT - _BOTTOM}" text-anchor="end" {text}>{bottom:.2g}</text>'
        f'<text x="{_LEFT}" y="{_HEIGHT - _BOTTOM + 13}" {text}>{left:.3g}</text>'
        f'<text x="{_WIDTH - 8}" y="{_HEIGHT - _BOTTOM + 13}" text-anchor="end" {text}>{right:.3g}</text>'
        f'<text x="{(_LEFT + _WIDTH) / 2}" y="{_HEIGHT - 6}" text-anchor="middle" {text}>{column}</text>'
        f'<text x="12" y="{_HEIGHT / 2}" transform="rotate(-90 12 {_HEIGHT / 2})" text-anchor="middle" {text}>'
        f"{output}</text></svg>"
    )
