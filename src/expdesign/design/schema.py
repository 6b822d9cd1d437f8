"""The run configuration as it stands in YAML (interfaces.md, Run configuration): keys, types and their meaning."""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PlainSerializer, WithJsonSchema, model_validator

from expdesign.design.coverage import STANDARD, Coverage
from expdesign.design.variables import Choices, Interval, Quantity, fixed
from expdesign.files.schema import (
    LARGEST,
    LARGEST_COUNT,
    Count,
    NonNegative,
    Number,
    Positive,
    Section,
    invalid,
    shortened,
)


def _is_number(value: Any) -> bool:
    if not isinstance(value, int | float) or isinstance(value, bool) or not abs(value) < float("inf"):
        return False
    if abs(value) > LARGEST:
        raise invalid(f"{shortened(value)} is beyond any quantity in SI units", remedy="Check the exponent.")
    return True


def _quantity(value: Any) -> Quantity:
    """A number, `[low, high]`, or `{choices: [...]}`."""
    remedy = "Write a number, `[low, high]` or `{choices: [...]}`, in SI units."
    if isinstance(value, Interval | Choices):
        return value
    if _is_number(value):
        return fixed(float(value))
    if isinstance(value, list):
        if len(value) != 2 or not all(_is_number(v) for v in value):
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
    if isinstance(value, Interval | Choices):
        return value
    if isinstance(value, dict):
        return _quantity(value)
    if _is_number(value):
        return fixed(float(value))
    remedy = "Write `[low, high, points]`."
    if not isinstance(value, list) or len(value) != 3 or not all(_is_number(v) for v in value):
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


class PosesSection(Section):
    """`experiment.poses`: one of three forms."""

    bounds: dict[str, QuantityField] | None = None
    grid: dict[str, GridAxis] | None = None
    candidates: str | list[list[Number]] | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        given = [name for name in ("bounds", "grid", "candidates") if getattr(self, name) is not None]
        if len(given) != 1:
            named = " and ".join(f"`{name}`" for name in given) or "none"
            raise invalid(
                f"exactly one of `bounds`, `grid` and `candidates` is needed, not {named}", remedy="Keep one."
            )
        return self


class TiltSection(Section):
    """`experiment.load.gravity`: tilt of the base (rad)."""

    tilt_x_rad: QuantityField | None = None
    tilt_y_rad: QuantityField | None = None
    tilt_rad: QuantityField | None = None


class LoadSection(Section):
    """`experiment.load`."""

    kind: Literal["payload", "wrench"]
    mass_kg: QuantityField | None = None
    com_x_m: QuantityField | None = None
    com_y_m: QuantityField | None = None
    com_z_m: QuantityField | None = None
    gravity: TiltSection | None = None
    fx_N: QuantityField | None = None
    fy_N: QuantityField | None = None
    fz_N: QuantityField | None = None
    mx_Nm: QuantityField | None = None
    my_Nm: QuantityField | None = None
    mz_Nm: QuantityField | None = None


class PointsSection(Section):
    """`experiment.deflection_noise.points`: poses come from the measured points of an artefact."""

    positions: list[Annotated[list[Number], Field(min_length=3, max_length=3)]]
    std_m: Positive
    pose: list[Number] | None = None


class NoiseSection(Section):
    """`experiment.deflection_noise`."""

    std: dict[str, Positive] | None = None
    covariance: list[list[Number]] | None = None
    points: PointsSection | None = None
    shared_reference: Annotated[bool, Field(strict=True)] = False

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if sum(form is not None for form in (self.std, self.covariance, self.points)) != 1:
            raise invalid("exactly one of `std`, `covariance` and `points` is needed", remedy="Keep one.")
        return self


class LoadErrorSection(Section):
    """One entry of `experiment.load_error`."""

    source: str
    std: NonNegative | list[NonNegative]
    shared: Annotated[bool, Field(strict=True)] = True


class ReferencePoseSection(Section):
    """`experiment.reference_pose`."""

    pose: list[Number]
    interpolate: Annotated[bool, Field(strict=True)] = False


class BoxSection(Section):
    """One entry of `experiment.constraints.keep_out`: a box in the base frame (m)."""

    low_m: list[Number]
    high_m: list[Number]


class ConstraintsSection(Section):
    """`experiment.constraints`: what a laboratory demands of a plan."""

    distinct_poses: Count = 1
    distinct_masses: Count = 1
    poses: list[list[Number]] = Field(default_factory=list)
    masses_kg: list[NonNegative] = Field(default_factory=list)
    keep_out: list[BoxSection] = Field(default_factory=list)
    effort: Annotated[bool, Field(strict=True)] = False


class ExperimentSection(Section):
    """`experiment`."""

    measurements: Count
    poses: PosesSection
    load: LoadSection | None = None
    deflection_noise: NoiseSection
    load_error: list[LoadErrorSection] = Field(default_factory=list)
    geometric_stiffness: Annotated[bool, Field(strict=True)] = False
    calibration: Literal["elastostatic", "geometric", "both"] = "elastostatic"
    frames: Literal["known", "unknown"] = "known"
    reference_pose: ReferencePoseSection | None = None
    resolution: dict[str, Positive] | None = None
    constraints: ConstraintsSection | None = None


class TargetPayloadSection(Section):
    """`targets[].payload`."""

    mass_kg: Positive
    com_m: list[Number] | None = None


class TargetSection(Section):
    """One entry of `targets`."""

    pose: list[Number]
    payload: TargetPayloadSection | None = None
    wrench: list[Number] | None = None
    tolerance: dict[str, Positive]
    weight: Positive = 1.0
    gravity_m_s2: list[Number] | None = None
    tolerance_axes: Literal["pose", "body"] = "pose"

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        if self.payload is not None and self.wrench is not None:
            raise invalid("exactly one of `payload` and `wrench` is needed", remedy="Keep one.")
        if not self.tolerance:
            raise invalid("at least one axis must matter", "tolerance", "Write e.g. `{dz_m: 1.0e-6}`.")
        return self


class OptimiserSection(Section):
    """`optimiser`."""

    algorithm: Literal["nsga2"] = "nsga2"
    population: Annotated[int, Field(strict=True, ge=4, le=LARGEST_COUNT)] = 100
    generations: Count = 200
    seed: Annotated[int, Field(strict=True, ge=0)] = 1
    polish: Annotated[bool, Field(strict=True)] = True


class AcceptanceSection(Section):
    """`acceptance`: the coverage of the expanded uncertainty."""

    coverage: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = None
    k: Annotated[Number, Field(gt=0.0, le=8.0)] | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.coverage is None) == (self.k is None):
            raise invalid("exactly one of `coverage` and `k` is needed", remedy="E.g. `{k: 2}` or `{coverage: 0.95}`.")
        return self

    @property
    def chosen(self) -> Coverage:
        """As the program takes it."""
        if self.coverage is not None:
            return Coverage(self.coverage)
        return STANDARD if self.k is None else Coverage.of_factor(self.k)


class RunSection(Section):
    """A run configuration."""

    schema_version: Literal[1]
    robot: str | dict[str, Any]
    experiment: ExperimentSection
    targets: Annotated[list[TargetSection], Field(min_length=1)]
    aggregate: Literal["mean", "max"] = "mean"
    objectives: list[str] = Field(default_factory=lambda: ["duir", "feir"])
    optimiser: OptimiserSection = OptimiserSection()
    acceptance: AcceptanceSection | None = None
