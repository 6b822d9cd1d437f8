"""Quantities as they stand in a run configuration: a number, `[low, high]` or `{choices: [...]}`, an axis of a grid."""

from typing import Annotated, Any

from pydantic import BeforeValidator, PlainSerializer, WithJsonSchema

from expdesign.io.schema import LARGEST, LARGEST_COUNT, decimal_commas, invalid, shortened
from expdesign.planning.variables import Choices, Interval, Quantity, fixed


def _is_number(value: Any) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool) or not abs(value) < float("inf"):
        return False
    if abs(value) > LARGEST:
        raise invalid(f"{shortened(value)} is beyond any quantity in SI units", remedy="Check the exponent.")
    return True


def _quantity(value: Any) -> Quantity:
    """A number, `[low, high]`, or `{choices: [...]}`."""
    return _chosen(value, "[low, high]")


def _chosen(value: Any, interval: str) -> Quantity:
    remedy = f"Write a number, `{interval}` or `{{choices: [...]}}`, in SI units."
    if isinstance(value, Interval | Choices):
        return value
    if _is_number(value):
        return fixed(float(value))
    if isinstance(value, list):
        if len(value) != 2 or not all(_is_number(v) for v in value):
            remedy = decimal_commas(len(value), 2) or remedy
            raise invalid(f"{shortened(value)} is not an interval of two finite numbers", remedy=remedy)
        if value[0] > value[1]:
            raise invalid(f"the bounds are the wrong way round: {value[0]} > {value[1]}", remedy="Write `[low, high]`.")
        return Interval(float(value[0]), float(value[1]))
    if isinstance(value, dict) and set(value) == {"choices"}:
        choices = value["choices"]
        if not isinstance(choices, list) or not choices or not all(_is_number(v) for v in choices):
            raise invalid("`choices` needs a list of at least one finite number", remedy=remedy)
        return Choices(tuple(dict.fromkeys(float(v) for v in choices)))
    if isinstance(value, dict):
        unknown = next((str(key) for key in value if key != "choices"), None)
        raise invalid("unknown key" if unknown else "a number is needed here", unknown, remedy)
    raise invalid(f"a number is needed here, not {shortened(value)}", remedy=remedy)


def _grid_axis(value: Any) -> Quantity:
    """`[low, high, points]`, one number, or the points themselves (`{choices: [...]}`)."""
    if not isinstance(value, list):
        return _chosen(value, "[low, high, points]")
    remedy = "Write `[low, high, points]`."
    if len(value) != 3 or not all(_is_number(v) for v in value):
        raise invalid(f"{shortened(value)} is not an axis of a grid", remedy=remedy)
    low, high, points = value
    if not isinstance(points, int) or not 1 <= points <= LARGEST_COUNT:
        what = f"the number of points must be a whole number from 1 to {LARGEST_COUNT}, not {shortened(points)}"
        raise invalid(what, remedy=remedy)
    if low > high:
        raise invalid(f"the bounds are the wrong way round: {low} > {high}", remedy=remedy)
    if points == 1 and low != high:
        raise invalid("one point cannot cover an interval", remedy="Use at least 2 points, or one number.")
    step = (high - low) / max(points - 1, 1)
    # Twelve digits: a step such as (0.03 - -0.03)/6 is not exact, and a pose of 0.019999999999999993 m cannot be set.
    return Choices((float(low), *(float(f"{low + i * step:.12g}") for i in range(1, points - 1)), float(high))[:points])


def _written(value: Quantity | None) -> Any:
    """A quantity as it stands in YAML."""
    if isinstance(value, Interval):
        return value.low if value.low == value.high else [value.low, value.high]
    return None if value is None else {"choices": list(value.values)}


_NUMBER = {"type": "number"}
_CHOICES = {
    "type": "object",
    "properties": {"choices": {"type": "array", "items": _NUMBER, "minItems": 1}},
    "required": ["choices"],
    "additionalProperties": False,
}
_INTERVAL = {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}
_AXIS = {"type": "array", "items": _NUMBER, "minItems": 3, "maxItems": 3}

QuantityField = Annotated[
    Any,
    BeforeValidator(_quantity),
    PlainSerializer(_written),
    WithJsonSchema({"anyOf": [_NUMBER, _INTERVAL, _CHOICES], "description": "a number, [low, high] or {choices: []}"}),
]
GridAxis = Annotated[
    Any,
    BeforeValidator(_grid_axis),
    PlainSerializer(_written),
    WithJsonSchema({"anyOf": [_NUMBER, _AXIS, _CHOICES], "description": "a number or [low, high, number of points]"}),
]
