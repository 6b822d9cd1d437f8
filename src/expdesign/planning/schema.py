"""The run configuration as it stands in YAML (file-formats.md, Run configurations): keys, types and their meaning."""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, PlainSerializer, WithJsonSchema, model_validator

from expdesign.estimation.coverage_factor import STANDARD, Coverage
from expdesign.io.schema import (
    LARGEST,
    LARGEST_COUNT,
    Count,
    NonNegative,
    Number,
    Positive,
    Section,
    decimal_commas,
    invalid,
    shortened,
)
from expdesign.planning.options import Effort
from expdesign.planning.variables import Choices, Interval, Quantity, fixed


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

    bounds: dict[str, QuantityField] | None = Field(
        default=None,
        description="Continuous poses: for each coordinate (`x_m` ..., or `q1_rad` ... of an arm; m or rad) a number, "
        "`[low, high]` or `{choices: [...]}`. Coordinates that are not named are 0.",
    )
    grid: dict[str, GridAxis] | None = Field(
        default=None,
        description="A grid of poses: for each coordinate (m or rad) `[low, high, number of points]` or a number. "
        "Coordinates that are not named are 0.",
    )
    candidates: str | list[list[Number]] | None = Field(
        default=None,
        description="A list of poses (m, rad), or a CSV file with a column for every coordinate; the path is relative "
        "to the configuration.",
    )
    tips: Annotated[list[str], Field(min_length=1)] | None = Field(
        default=None,
        description="Of a robot with several tips, those that may be measured, by name. Default: all of them. A file "
        "of `candidates` may say it row by row in a column `tip`.",
    )

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

    tilt_x_rad: QuantityField | None = Field(
        default=None, description="Tilt about x (rad): gravity is Ry(tilt_y)·Rx(tilt_x)·g. Default: 0."
    )
    tilt_y_rad: QuantityField | None = Field(default=None, description="Tilt about y (rad). Default: 0.")
    tilt_rad: QuantityField | None = Field(default=None, description="Tilt of a bipod in its plane (rad). Default: 0.")


class LoadSection(Section):
    """`experiment.load`."""

    kind: Literal["payload", "wrench"] = Field(
        description="`payload`: a mass under gravity; `wrench`: a force and a moment that do not depend on the pose."
    )
    mass_kg: QuantityField | None = Field(default=None, description="Mass of a payload (kg); required for a payload.")
    com_x_m: QuantityField | None = Field(
        default=None, description="x of the centre of mass in the platform frame (m). Default: 0."
    )
    com_y_m: QuantityField | None = Field(
        default=None, description="y of the centre of mass in the platform frame (m). Default: 0."
    )
    com_z_m: QuantityField | None = Field(
        default=None, description="z of the centre of mass in the platform frame (m). Default: 0."
    )
    gravity: TiltSection | None = Field(
        default=None,
        description="Where the base can be tilted: the directions of gravity that can be had. Default: as in the "
        "robot file.",
    )
    fx_N: QuantityField | None = Field(default=None, description="Force along x of O (N). Default: 0.")
    fy_N: QuantityField | None = Field(default=None, description="Force along y of O (N). Default: 0.")
    fz_N: QuantityField | None = Field(default=None, description="Force along z of O (N). Default: 0.")
    mx_Nm: QuantityField | None = Field(
        default=None, description="Moment about x of O at the origin of P (N·m). Default: 0."
    )
    my_Nm: QuantityField | None = Field(
        default=None, description="Moment about y of O at the origin of P (N·m). Default: 0."
    )
    mz_Nm: QuantityField | None = Field(
        default=None, description="Moment about z of O at the origin of P (N·m). Default: 0."
    )


class MeasuredPointsSection(Section):
    """`experiment.deflection_noise.points`: poses come from the measured points of an artefact."""

    positions: list[Annotated[list[Number], Field(min_length=3, max_length=3)]] = Field(
        description="Points of the artefact in the platform frame, `[x, y, z]` (m) each; at least three, not in line."
    )
    std_m: Positive = Field(description="Standard deviation of every measured coordinate of a point (m).")
    pose: list[Number] | None = Field(
        default=None,
        description="Pose (m, rad), or joint coordinates, at which the covariance is taken. Default: the zero pose, or "
        "an arm's reference.",
    )


class DeflectionNoiseSection(Section):
    """`experiment.deflection_noise`."""

    std: dict[str, Positive] | None = Field(
        default=None,
        description="Standard deviation of every measured component of a deflection (`dx_m` ... in m, `drx_rad` ... in "
        "rad). Components that are not named are not measured.",
    )
    covariance: list[list[Number]] | None = Field(
        default=None, description="Covariance matrix of a deflection, all components (m², m·rad, rad²)."
    )
    points: MeasuredPointsSection | None = Field(
        default=None, description="Poses are registered from measured points, whose covariance follows from theirs."
    )
    shared_reference: Annotated[bool, Field(strict=True)] = Field(
        default=False,
        description="Whether measurements of one series (of consecutive rows at one pose) share one unloaded "
        "measurement, which carries half of each deflection's covariance.",
    )

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if sum(form is not None for form in (self.std, self.covariance, self.points)) != 1:
            raise invalid("exactly one of `std`, `covariance` and `points` is needed", remedy="Keep one.")
        return self


class LoadErrorSection(Section):
    """One entry of `experiment.load_error`."""

    source: str = Field(
        description="`com` (centre of mass), `mass`, `direction` (of gravity or of the wrench) or `wrench`."
    )
    std: NonNegative | list[NonNegative] = Field(
        description="Standard deviations: `com` m in the platform frame (3; none for a bipod), `mass` kg (1), "
        "`direction` rad about x and y of O (2; 1 for a bipod), `wrench` N and N·m (6; 2 for a bipod)."
    )
    shared: Annotated[bool, Field(strict=True)] = Field(
        default=True,
        description="Whether all measurements have one unknown error in common (systematic), or each has its own "
        "(random).",
    )


class ReferencePoseSection(Section):
    """`experiment.reference_pose`."""

    pose: list[Number] = Field(description="The reference pose that is measured before every other pose (m, rad).")
    interpolate: Annotated[bool, Field(strict=True)] = Field(
        default=False, description="Whether the correction interpolates between the references before and after a pose."
    )


class CostsSection(Section):
    """`experiment.costs`: minutes that the laboratory sheet's order is made for."""

    pose_change: NonNegative = Field(default=0.0, description="Moving to another pose (min).")
    mass_change: NonNegative = Field(default=0.0, description="Changing the load (min).")
    reading: NonNegative = Field(default=0.0, description="Taking one reading (min).")


class BudgetSection(Section):
    """`experiment.budget`: time that measuring may take, in place of a number of measurements."""

    minutes: Positive = Field(description="Time of all changes and readings by `experiment.costs` (min).")
    distinct_poses: Count | None = Field(
        default=None, description="Largest number of different poses. Default: chosen by the search."
    )


class ValidationSection(Section):
    """`experiment.validation`: rows of a plan that are measured to test the model, and not fitted."""

    measurements: Count = Field(description="Number of rows with `split: test`, at poses and loads of their own.")


class KeepOutSection(Section):
    """One entry of `experiment.constraints.keep_out`: a box in the base frame (m)."""

    low_m: list[Number] = Field(description="Least corner, `[x, y, z]` (m).")
    high_m: list[Number] = Field(description="Greatest corner, `[x, y, z]` (m).")


class PrimitiveSection(Section):
    """A body of simple form in `experiment.constraints.collisions`."""

    box_m: Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = Field(
        default=None, description="Edges of a box along x, y and z (m)."
    )
    cylinder_m: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="Radius and length of a cylinder about z (m)."
    )
    sphere_m: Positive | None = Field(default=None, description="Radius of a sphere (m).")
    at_m: Annotated[list[Number], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0], description="Its centre (m)."
    )

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if sum(form is not None for form in (self.box_m, self.cylinder_m, self.sphere_m)) != 1:
            raise invalid("exactly one of `box_m`, `cylinder_m` and `sphere_m` is needed", remedy="Keep one.")
        return self


class CollisionsSection(Section):
    """`experiment.constraints.collisions`: parts of the robot and its payload that must stay apart."""

    clearance_m: NonNegative = Field(default=0.005, description="Least distance between two parts (m).")
    leg_radius_m: Positive = Field(description="Radius of legs or links (m).")
    payload: PrimitiveSection | None = Field(
        default=None, description="The payload, in the platform frame. Default: not regarded."
    )
    platform: PrimitiveSection | None = Field(
        default=None, description="The platform, in its frame; compared with the base. Default: not regarded."
    )
    base: PrimitiveSection | None = Field(default=None, description="The base, in O. Default: not regarded.")


class ReflectorSection(Section):
    """One entry of `experiment.constraints.visibility.reflectors`."""

    at_m: Annotated[list[Number], Field(min_length=3, max_length=3)] = Field(
        default_factory=lambda: [0.0, 0.0, 0.0], description="Its place in the frame of platform or tip (m)."
    )
    direction: Annotated[list[Number], Field(min_length=3, max_length=3)] = Field(
        description="Where it looks, in the frame of platform or tip."
    )
    acceptance_rad: Annotated[Number, Field(gt=0.0, le=3.2)] = Field(
        description="Largest angle between its direction and the line to the station (rad)."
    )
    tip: str | None = Field(
        default=None, description="Tip it sits on, by name, of a robot with several. Default: one sits on each."
    )


class VisibilitySection(Section):
    """`experiment.constraints.visibility`: reflectors that the instrument has to see."""

    station_m: Annotated[list[Number], Field(min_length=3, max_length=3)] = Field(
        description="Place of the instrument in O, `[x, y, z]` (m)."
    )
    reflectors: Annotated[list[ReflectorSection], Field(min_length=1)] = Field(
        description="Reflectors on platform or tip."
    )
    link_radius_m: NonNegative = Field(description="Radius of legs or links, which hide what is behind them (m).")
    least: Count | None = Field(
        default=None, description="How many of the reflectors have to be seen at every pose. Default: all."
    )


class ConstraintsSection(Section):
    """`experiment.constraints`: what a laboratory demands of a plan."""

    distinct_poses: Count = Field(default=1, description="Least number of different poses.")
    distinct_masses: Count = Field(default=1, description="Least number of different masses.")
    poses: list[list[Number]] = Field(
        default_factory=list, description="Poses (m, rad) that have to occur. Default: none."
    )
    masses_kg: list[NonNegative] = Field(
        default_factory=list, description="Masses (kg) that have to occur. Default: none."
    )
    keep_out: list[KeepOutSection] = Field(
        default_factory=list, description="Boxes that no part of the robot may enter. Default: none."
    )
    collisions: CollisionsSection | None = Field(
        default=None, description="Parts of robot and payload that must stay apart. Default: not regarded."
    )
    visibility: VisibilitySection | None = Field(
        default=None, description="Reflectors that the instrument has to see. Default: not regarded."
    )
    effort: Annotated[bool, Field(strict=True)] = Field(
        default=False, description="Whether the joints' effort limits of the URDF hold (N or N·m)."
    )


class ExperimentSection(Section):
    """`experiment`."""

    measurements: Count | None = Field(
        default=None,
        description="Number m of loaded measurements of a plan; with a `budget`, the largest. Required without one.",
    )
    poses: PosesSection = Field(description="Where measurements may be taken: exactly one of the three forms.")
    load: LoadSection | None = Field(
        default=None, description="Loads that can be applied; required except for `calibration: geometric`."
    )
    deflection_noise: DeflectionNoiseSection = Field(
        description="Measurement noise of a deflection (of a pose, for `calibration: geometric`): exactly one of "
        "`std`, `covariance` and `points`."
    )
    load_error: list[LoadErrorSection] = Field(
        default_factory=list, description="Sources of error of the applied load. Default: none, and FEIR is 0."
    )
    geometric_stiffness: Annotated[bool, Field(strict=True)] = Field(
        default=False, description="Whether the model includes the change of geometry under load (K_G)."
    )
    calibration: Literal["elastostatic", "geometric", "both"] = Field(
        default="elastostatic",
        description="What is identified: `elastostatic` compliances of the actuators, `geometric` errors of joints and "
        "lengths, or `both`.",
    )
    frames: Literal["known", "unknown"] = Field(
        default="known",
        description="Whether the frames of base and artefact are known in the instrument's, for geometric calibration.",
    )
    reference_pose: ReferencePoseSection | None = Field(
        default=None, description="Thermal deflection is removed with a reference pose. Default: none is measured."
    )
    costs: CostsSection | None = Field(
        default=None,
        description="What measuring costs, by which the laboratory's sheet is put in order. Default: equal costs.",
    )
    budget: BudgetSection | None = Field(
        default=None, description="Time in place of a number of measurements; needs `costs`. Default: no limit."
    )
    validation: ValidationSection | None = Field(
        default=None, description="Rows of a plan kept for validation. Default: none."
    )
    resolution: dict[str, Positive] | None = Field(
        default=None,
        description="Steps in which poses and loads can be set, by column (`x_m: 1e-6`, `mass_kg: 1e-4`). Default: "
        "1e-6 m or rad, 1e-4 kg, 1e-3 N, 1e-4 N·m; finer where an interval is short.",
    )
    constraints: ConstraintsSection | None = Field(
        default=None, description="What a laboratory demands of a plan beside the robot's limits. Default: nothing."
    )


class TargetPayloadSection(Section):
    """`targets[].payload`."""

    mass_kg: Positive = Field(description="Mass (kg).")
    com_m: list[Number] | None = Field(
        default=None, description="Centre of mass in the platform frame, `[x, y, z]` (m). Default: its origin."
    )


class TargetSection(Section):
    """One entry of `targets`."""

    pose: list[Number] = Field(description="Pose (m, rad) or joint coordinates at which accuracy is wanted.")
    tip: str | None = Field(
        default=None, description="Which tip is meant, by name; required of a robot with several tips. Default: none."
    )
    payload: TargetPayloadSection | None = Field(
        default=None, description="Payload carried there; exactly one of `payload` and `wrench`."
    )
    wrench: list[Number] | None = Field(
        default=None,
        description="Wrench applied there, `[fx, fy, fz, mx, my, mz]` (N, N·m) in O about the origin of P.",
    )
    tolerance: dict[str, Positive] = Field(
        description="Error that is acceptable on each axis that matters (`dx_m` ... in m, `drx_rad` ... in rad)."
    )
    weight: Positive = Field(default=1.0, description="Weight of the target in a mean over targets.")
    gravity_m_s2: list[Number] | None = Field(
        default=None, description="Gravity in O at this target (m/s²). Default: as in the robot file."
    )
    tolerance_axes: Literal["pose", "body"] = Field(
        default="pose",
        description="Whether tolerances of rotations are of the pose's angles or of rotations about the platform's own "
        "axes.",
    )

    @model_validator(mode="after")
    def _one_load(self) -> Self:
        if self.payload is not None and self.wrench is not None:
            raise invalid("exactly one of `payload` and `wrench` is needed", remedy="Keep one.")
        if not self.tolerance:
            raise invalid("at least one axis must matter", "tolerance", "Write e.g. `{dz_m: 1.0e-6}`.")
        return self


class ModelErrorsSection(Section):
    """`model_error`: what MEIR assumes of the physics that the model leaves out."""

    physics: list[str] | None = Field(
        default=None, description="Identifiers of the physics considered. Default: all that the robot can have."
    )
    without: list[str] = Field(
        default_factory=list, description="Identifiers of physics that machines of this kind never have."
    )
    sizes: dict[str, Number | dict[str, Number]] = Field(
        default_factory=dict,
        description="Prior sizes (standard deviations over machines of this class) in place of the declared ones: by "
        "physics, one number for all its parameters, or numbers by parameter, in the unit or as the multiple that is "
        "declared (`expdesign physics`).",
    )
    level: Number = Field(default=0.01, description="Level α of the χ² test that notices.")
    power: Number = Field(default=0.8, description="Share of experiments 1 − β in which physics has to be noticed.")


class OptimiserSection(Section):
    """`optimiser`."""

    algorithm: Literal["nsga2"] = Field(
        default="nsga2", description="The search: NSGA-II, whose operators know exchanges and gradients."
    )
    effort: Effort = Field(
        default="normal",
        description="When the search ends: where a further second of work is expected to bring less than 0.1 % of the "
        "hypervolume and 0.01 % of `total` (`normal`), five times that (`quick`) or a tenth of it (`thorough`).",
    )
    population: Annotated[int, Field(strict=True, ge=4, le=LARGEST_COUNT)] = Field(
        default=100, description="Designs in the population of the search."
    )
    generations: Count | None = Field(
        default=None, description="Generations of the search at most; where left out, `effort` alone ends it."
    )
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(
        default=1, description="Seed of all random numbers of the search."
    )
    polish: Annotated[bool, Field(strict=True)] = Field(
        default=True, description="Whether designs descend along exact gradients."
    )
    bound_seconds: Annotated[Number, Field(ge=0.0, le=86400.0)] = Field(
        default=0.0,
        description="Processor time (s) of halving boxes for the bounds of DUIR and of `total`, each; estimated from "
        "the work, so that results do not depend on the machine. 0 leaves the bounds of the convex relaxation.",
    )


class AcceptanceSection(Section):
    """`acceptance`: the coverage of the expanded uncertainty."""

    coverage: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = Field(
        default=None, description="Probability that the interval covers; exactly one of `coverage` and `k`."
    )
    k: Annotated[Number, Field(gt=0.0, le=8.0)] | None = Field(
        default=None, description="Coverage factor of the expanded uncertainty."
    )

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

    schema_version: Literal[1] = Field(description="Version of this format.")
    robot: str | dict[str, Any] = Field(
        description="The robot: a file (the path is relative to the configuration), or the mapping itself."
    )
    experiment: ExperimentSection = Field(description="What can be measured, and with which errors.")
    targets: Annotated[list[TargetSection], Field(min_length=1)] = Field(
        description="Where accuracy under load is wanted after compensation; at least one."
    )
    aggregate: Literal["mean", "max"] = Field(
        default="mean",
        description="Criteria over several targets: root of the weighted mean square, or the `max` target's.",
    )
    objectives: list[str] = Field(
        default_factory=lambda: ["duir", "feir"],
        description="Criteria that span the Pareto front, or one alone. Default: `[duir, feir]`.",
    )
    model_error: ModelErrorsSection | None = Field(
        default=None,
        description="What MEIR assumes; with this section (`{}` for its defaults), or with `meir` as an objective, "
        "MEIR is evaluated with the other criteria.",
    )
    optimiser: OptimiserSection = Field(default=OptimiserSection(), description="The search for the Pareto front.")
    acceptance: AcceptanceSection | None = Field(
        default=None,
        description="Coverage of the expanded uncertainty by which targets are accepted. Default: `{k: 2}`.",
    )
