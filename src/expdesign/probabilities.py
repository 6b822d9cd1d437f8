"""How probabilities are written: no figures beyond what a model of a measurement can vouch for."""

SMALLEST = 1e-6
"""Probabilities below it, and above 1 − it, are written as such: no noise is normal so far out in its tails."""


def probability_text(value: float, digits: int = 3) -> str:
    """A probability with `digits` significant digits; `below 1e-6` and `above 0.999999` beyond."""
    if value < SMALLEST:
        return f"below {SMALLEST:.0e}".replace("e-0", "e-")
    if value > 1.0 - SMALLEST:
        return f"above {1.0 - SMALLEST:.6f}"
    if value < 1e-3:
        return f"{value:.{digits - 1}e}".replace("e-0", "e-")
    # The nines of a probability near 1 are what it says.
    text = f"{value:.{digits}g}"
    return text if float(text) < 1.0 else f"{value:.6f}".rstrip("0")


def p_text(value: float) -> str:
    """`p = 0.178`, `p below 1e-6` or `p above 0.999999`."""
    text = probability_text(value)
    return f"p {text}" if text[0].isalpha() else f"p = {text}"
