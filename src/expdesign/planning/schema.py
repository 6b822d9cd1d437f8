"""The run configuration as it stands in YAML (file-formats.md, Run configurations): keys, types and their meaning."""

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, model_validator

from expdesign.arrays import FloatArray
from expdesign.estimation.coverage import STANDARD, Coverage
from expdesign.io.schema import LARGEST_COUNT, Count, NonNegative, Number, Positive, Section, invalid
from expdesign.planning.quantity_fields import GridAxis, QuantityField

Effort = Literal["quick", "normal", "thorough"]
Flag = Annotated[bool, Field(strict=True)]
Vector = Annotated[list[Number], Field(min_length=3, max_length=3)]


def left_out(description: str) -> Any:
    """A key that may be left out, and is None then."""
    return Field(default=None, description=description)


class OneForm(Section):
    """A mapping with exactly one of some keys.

    Attributes:
        forms: these keys.
        remedy: what to do where there is none of them, or several.
    """

    forms: ClassVar[tuple[str, ...]]
    remedy: ClassVar[str] = "Keep one."

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        given = [f"`{name}`" for name in self.forms if getattr(self, name) is not None]
        if len(given) != 1:
            *first, last = (f"`{name}`" for name in self.forms)
            what = f"exactly one of {', '.join(first)} and {last} is needed, not {' and '.join(given) or 'none'}"
            raise invalid(what, remedy=self.remedy)
        return self


class PosesSection(OneForm):
    """`experiment.poses`: one of three forms."""

    forms = ("bounds", "grid", "candidates")

    bounds: dict[str, QuantityField] | None = left_out(
        "Continuous poses: a quantity for each coordinate (`x_m` ..., `q1_rad` ... of an arm; m or rad). Default: 0."
    )
    grid: dict[str, GridAxis] | None = left_out(
        "A grid of poses: `[low, high, number of points]` or a number for each coordinate (m or rad). Default: 0."
    )
    candidates: str | list[list[Number]] | None = left_out(
        "A list of poses (m, rad), or a CSV file with a column for each coordinate."
    )
    tips: Annotated[list[str], Field(min_length=1)] | None = left_out(
        "Tips that may be measured, by name, of a robot with several. Default: all. A file of `candidates` may name "
        "one per row in a column `tip`."
    )


class TiltSection(Section):
    """`experiment.load.gravity`: tilt of the base (rad)."""

    tilt_x_rad: QuantityField | None = left_out("Tilt about x (rad): gravity is Ry(tilt_y)·Rx(tilt_x)·g. Default: 0.")
    tilt_y_rad: QuantityField | None = left_out("Tilt about y (rad). Default: 0.")
    tilt_rad: QuantityField | None = left_out("Tilt of a bipod in its plane (rad). Default: 0.")


class LoadSection(Section):
    """`experiment.load`."""

    kind: Literal["payload", "wrench"] = Field(
        description="A mass under gravity, or a force and a moment that do not depend on the pose."
    )
    mass_kg: QuantityField | None = left_out("Mass of a payload (kg), which requires it.")
    com_x_m: QuantityField | None = left_out("Centre of mass in P (m). Default: 0.")
    com_y_m: QuantityField | None = left_out("Centre of mass in P (m). Default: 0.")
    com_z_m: QuantityField | None = left_out("Centre of mass in P (m). Default: 0.")
    gravity: TiltSection | None = left_out(
        "Directions of gravity, where the base can be tilted. Default: as in the robot file."
    )
    fx_N: QuantityField | None = left_out("Force along the axes of O (N). Default: 0.")
    fy_N: QuantityField | None = left_out("Force along the axes of O (N). Default: 0.")
    fz_N: QuantityField | None = left_out("Force along the axes of O (N). Default: 0.")
    mx_Nm: QuantityField | None = left_out("Moment about the axes of O at the origin of P (N·m). Default: 0.")
    my_Nm: QuantityField | None = left_out("Moment about the axes of O at the origin of P (N·m). Default: 0.")
    mz_Nm: QuantityField | None = left_out("Moment about the axes of O at the origin of P (N·m). Default: 0.")


class MeasuredPointsSection(Section):
    """`experiment.deflection_noise.points`: poses come from the measured points of an artefact."""

    positions: list[Vector] = Field(description="Points of the artefact in P (m); at least three, not in line.")
    std_m: Positive = Field(description="Standard deviation of a point's coordinates (m).")
    pose: list[Number] | None = left_out(
        "Pose (m, rad) or joint coordinates at which the covariance is computed. Default: the zero pose or an arm's "
        "reference."
    )


class DeflectionNoiseSection(OneForm):
    """`experiment.deflection_noise`."""

    forms = ("std", "covariance", "points")

    std: dict[str, Positive] | None = left_out(
        "Standard deviation of each measured component (`dx_m` ... in m, `drx_rad` ... in rad); a "
        "component without one is not measured."
    )
    covariance: list[list[Number]] | None = left_out(
        "Covariance of all components of a deflection (m², m·rad, rad²). Recordings that are read with the "
        "configuration keep their own standard deviations and take its correlations."
    )
    points: MeasuredPointsSection | None = left_out(
        "Measured points from which poses are registered; their noise gives the covariance."
    )
    shared_reference: Flag = Field(
        default=False,
        description="Whether the measurements of a series (consecutive rows at one pose) share one unloaded "
        "measurement, which carries half of each deflection's covariance.",
    )


class LoadErrorSection(Section):
    """One entry of `experiment.load_error`."""

    source: str = Field(
        description="`com` (centre of mass), `mass`, `direction` (of gravity or the wrench) or `wrench`."
    )
    std: NonNegative | list[NonNegative] = Field(
        description="Standard deviations: `com` in P (3 × m; not for a bipod), `mass` (kg), `direction` about x"
        " and y of O (2 × rad; 1 for a bipod), `wrench` (6 × N or N·m; 2 for a bipod)."
    )
    shared: Flag = Field(
        default=True,
        description="Whether all measurements share one unknown error (systematic) or each has another (random), also "
        "further readings under a load that stays on.",
    )


class ReferencePoseSection(Section):
    """`experiment.reference_pose`."""

    pose: list[Number] = Field(description="The pose that is measured before every other pose (m, rad).")
    interpolate: Flag = Field(
        default=False, description="Whether the correction interpolates between the references before and after a pose."
    )


class CostsSection(Section):
    """`experiment.costs`: minutes that the laboratory sheet's order is made for."""

    pose_change: NonNegative = Field(default=0.0, description="Moving to another pose (min).")
    mass_change: NonNegative = Field(default=0.0, description="Changing the load (min).")
    reading: NonNegative = Field(default=0.0, description="Taking one reading (min).")

    @property
    def known(self) -> bool:
        """Whether any of them is stated."""
        return self.pose_change + self.mass_change + self.reading > 0.0

    def minutes(self, poses: ArrayLike, load_changes: ArrayLike, readings: ArrayLike) -> FloatArray:
        """The time of so many changes and readings (min)."""
        changes = np.multiply(poses, self.pose_change) + np.multiply(load_changes, self.mass_change)
        return np.asarray(changes + np.multiply(readings, self.reading))


class BudgetSection(Section):
    """`experiment.budget`: time that measuring may take, in place of a number of measurements."""

    minutes: Positive = Field(description="Time of all changes and readings (min).")
    distinct_poses: Count | None = left_out("Largest number of different poses. Default: chosen by the search.")


class ValidationSection(Section):
    """`experiment.validation`: rows of a plan that are measured to test the model, and not fitted."""

    measurements: Count = Field(description="Number of rows with `split: test`, at other poses and loads.")


class KeepOutSection(Section):
    """One entry of `experiment.constraints.keep_out`: a box in the base frame (m)."""

    low_m: list[Number] = Field(description="Least corner (m).")
    high_m: list[Number] = Field(description="Greatest corner (m).")


class PrimitiveSection(OneForm):
    """A body of simple form in `experiment.constraints.collisions`."""

    forms = ("box_m", "cylinder_m", "sphere_m")

    box_m: Annotated[list[Positive], Field(min_length=3, max_length=3)] | None = left_out(
        "Edges of a box along x, y and z (m)."
    )
    cylinder_m: Annotated[list[Positive], Field(min_length=2, max_length=2)] | None = left_out(
        "Radius and length of a cylinder about z (m)."
    )
    sphere_m: Positive | None = left_out("Radius of a sphere (m).")
    at_m: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0], description="Its centre (m).")

    @property
    def sizes(self) -> list[float]:
        """Three of a box, two of a cylinder, one of a sphere (m)."""
        return self.box_m or self.cylinder_m or [self.sphere_m or 0.0]


class CollisionsSection(Section):
    """`experiment.constraints.collisions`: parts of the robot and its payload that must stay apart."""

    clearance_m: NonNegative = Field(default=0.005, description="Least distance between two parts (m).")
    leg_radius_m: Positive = Field(description="Radius of legs or links (m).")
    payload: PrimitiveSection | None = left_out("The payload, in P. Default: not regarded.")
    platform: PrimitiveSection | None = left_out("The platform, in P. Default: not regarded.")
    base: PrimitiveSection | None = left_out("The base, in O. Default: not regarded.")


class ReflectorSection(Section):
    """One entry of `experiment.constraints.visibility.reflectors`."""

    at_m: Vector = Field(
        default_factory=lambda: [0.0, 0.0, 0.0], description="Its place in the frame of platform or tip (m)."
    )
    direction: Vector = Field(description="Where it looks, in the frame of platform or tip.")
    acceptance_rad: Annotated[Number, Field(gt=0.0, le=3.2)] = Field(
        description="Largest angle between its direction and the line to the station (rad)."
    )
    tip: str | None = Field(
        default=None, description="Tip it sits on, by name, of a robot with several. Default: one sits on each."
    )


class VisibilitySection(Section):
    """`experiment.constraints.visibility`: reflectors that the instrument has to see."""

    station_m: Vector = Field(description="Place of the instrument in O, `[x, y, z]` (m).")
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
        default_factory=list, description="Poses (m, rad) that must occur. Default: none."
    )
    masses_kg: list[NonNegative] = Field(
        default_factory=list, description="Masses (kg) that must occur. Default: none."
    )
    keep_out: list[KeepOutSection] = Field(
        default_factory=list, description="Boxes in O that the robot must not enter. Default: none."
    )
    collisions: CollisionsSection | None = left_out(
        "Parts of robot and payload that must stay apart. Default: not regarded."
    )
    visibility: VisibilitySection | None = left_out("Reflectors that the instrument has to see. Default: not regarded.")
    effort: Flag = Field(default=False, description="Whether the effort limits of the URDF hold (N or N·m).")


MOST_MEASUREMENTS = 10_000
"""More are no plan of a laboratory, and exhaust a machine."""


class ExperimentSection(Section):
    """`experiment`."""

    measurements: Annotated[Count, Field(le=MOST_MEASUREMENTS)] | None = left_out(
        "Number m of loaded measurements; with a `budget`, at most. Required without one."
    )
    poses: PosesSection = Field(description="Where measurements may be taken.")
    load: LoadSection | None = left_out("Loads that can be applied; required unless `calibration: geometric`.")
    deflection_noise: DeflectionNoiseSection = Field(
        description="Noise of a measured deflection (of a pose, with `calibration: geometric`)."
    )
    load_error: list[LoadErrorSection] = Field(
        default_factory=list, description="Sources of error of the applied load. Default: none, FEIR is 0."
    )
    estimator: Literal["generalised", "weighted"] = Field(
        default="generalised",
        description="Which least squares estimate the parameters: those that weigh noise and declared load errors "
        "(in plans at their declared size, in `identify` at one estimated from the recordings), or the noise alone.",
    )
    geometric_stiffness: Flag = Field(
        default=False, description="Whether the model includes the change of geometry under load."
    )
    calibration: Literal["elastostatic", "geometric", "both"] = Field(
        default="elastostatic",
        description="What is identified: compliances of the actuators, errors of joints and lengths, or both.",
    )
    frames: Literal["known", "unknown"] = Field(
        default="known",
        description="Whether the instrument's frame and the artefact's place are known, for geometric calibration.",
    )
    reference_pose: ReferencePoseSection | None = left_out(
        "Thermal deflection is removed with this pose. Default: no reference pose."
    )
    costs: CostsSection | None = left_out("Time of each step, which orders the laboratory sheet. Default: equal.")
    budget: BudgetSection | None = left_out(
        "Time in place of a number of measurements; needs `costs`. Default: no limit."
    )
    validation: ValidationSection | None = left_out("Rows of a plan kept for validation. Default: none.")
    resolution: dict[str, Positive] | None = left_out(
        "Steps in which poses and loads can be set, by column (`x_m: 1e-6`). Default: 1e-6 m or "
        "rad, 1e-4 kg, 1e-3 N, 1e-4 N·m; finer where an interval is short."
    )
    constraints: ConstraintsSection | None = left_out("What the laboratory demands of a plan. Default: nothing.")


class TargetPayloadErrorSection(Section):
    """`targets[].payload.std`: standard deviations of the target's own payload."""

    mass_kg: Positive | None = left_out("Of the mass (kg). Default: exact.")
    com_m: list[Positive] | None = left_out("Of the centre of mass in P (m). Default: exact.")


class TargetPayloadSection(Section):
    """`targets[].payload`."""

    mass_kg: Positive = Field(description="Mass (kg).")
    com_m: list[Number] | None = left_out("Centre of mass in P (m). Default: its origin.")
    std: TargetPayloadErrorSection | None = left_out(
        "How well this payload is known, which U contains. Default: exactly."
    )
    same_as: Literal["experiment"] | None = left_out(
        "`experiment` where the target carries the weights of the experiment: their errors act there as recordings "
        "showed them, those of every loading or of several weights as declared. Default: a payload of its own."
    )

    @model_validator(mode="after")
    def _one_payload(self) -> Self:
        if self.std is not None and self.same_as is not None:
            what = "the errors of the weights of the experiment are those of `experiment.load_error`"
            raise invalid(what, "std", remedy="Leave out `std`, or `same_as`.")
        if self.std is not None and self.std.mass_kg is not None and self.std.mass_kg > self.mass_kg:
            what = f"an error of {self.std.mass_kg:g} kg is larger than the mass, {self.mass_kg:g} kg"
            raise invalid(what, "std", remedy="In kg.")
        return self


class TargetSection(Section):
    """One entry of `targets`."""

    pose: list[Number] = Field(description="Pose or joint coordinates (m, rad).")
    tip: str | None = left_out("Tip that is meant, by name; required of a robot with several. Default: none.")
    payload: TargetPayloadSection | None = left_out("Payload there; either `payload` or `wrench`.")
    wrench: list[Number] | None = left_out(
        "Wrench there, `[fx, fy, fz, mx, my, mz]` in O about the origin of P (N, N·m)."
    )
    tolerance: dict[str, Positive] = Field(
        description="Acceptable error of each axis that matters (`dx_m` ... in m, `drx_rad` ... in rad)."
    )
    weight: Positive = Field(default=1.0, description="Weight in a mean over targets.")
    gravity_m_s2: list[Number] | None = left_out("Gravity in O at this target (m/s²). Default: as in the robot file.")
    tolerance_axes: Literal["pose", "body"] = Field(
        default="pose",
        description="Whether tolerances of rotations hold for the pose's angles or for rotations about the "
        "platform's axes.",
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

    physics: list[str] | None = left_out("Physics considered. Default: all that the robot can have.")
    without: list[str] = Field(default_factory=list, description="Physics that machines of this kind never have.")
    sizes: dict[str, Number | dict[str, Number]] = Field(
        default_factory=dict,
        description="Prior sizes (standard deviations over machines of this class) that replace the declared "
        "ones (`expdesign physics`): by physics a number for all its parameters, or numbers by "
        "parameter, in the declared unit.",
    )
    level: Number = Field(default=0.01, description="Level α of the χ² test.")
    power: Number = Field(
        default=0.8, description="Share of experiments 1 − β in which the test has to notice physics."
    )


class OptimiserSection(Section):
    """`optimiser`."""

    algorithm: Literal["nsga2"] = Field(
        default="nsga2", description="The search: NSGA-II with exchanges and descents as operators."
    )
    effort: Effort = Field(
        default="normal",
        description="The search ends where a further turn of all operators promises less than 0.1 % of the hypervolume "
        "and 0.01 % of `total` (`normal`), 5 times (`quick`) or 0.1 times that (`thorough`).",
    )
    population: Annotated[int, Field(strict=True, ge=4, le=LARGEST_COUNT)] = Field(
        default=100, description="Designs in the population."
    )
    generations: Count | None = left_out("Largest number of generations. Default: `effort` alone ends the search.")
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(default=1, description="Seed of all random numbers.")
    polish: Flag = Field(default=True, description="Whether designs descend along exact gradients.")
    bound_seconds: Annotated[Number, Field(ge=0.0, le=86400.0)] = Field(
        default=0.0, description="No longer used: bounds are those of the convex relaxation."
    )


class AcceptanceSection(OneForm):
    """`acceptance`: the coverage of the expanded uncertainty."""

    forms = ("coverage", "k")
    remedy = "E.g. `{k: 2}` or `{coverage: 0.95}`."

    coverage: Annotated[Number, Field(gt=0.0, lt=1.0)] | None = left_out(
        "Coverage probability; either `coverage` or `k`."
    )
    k: Annotated[Number, Field(gt=0.0, le=8.0)] | None = left_out("Coverage factor.")

    @property
    def chosen(self) -> Coverage:
        """As the program takes it."""
        if self.coverage is not None:
            return Coverage(self.coverage)
        return STANDARD if self.k is None else Coverage.of_factor(self.k)


class RunSection(Section):
    """A run configuration."""

    schema_version: Literal[1] = Field(description="Version of this format.")
    robot: str | dict[str, Any] = Field(description="The robot file, or its content.")
    experiment: ExperimentSection = Field(description="What can be measured, and with which errors.")
    targets: Annotated[list[TargetSection], Field(min_length=1)] = Field(
        description="Where accuracy under load is wanted; at least one."
    )
    aggregate: Literal["mean", "max"] = Field(
        default="mean",
        description="Criteria over several targets: root of the weighted mean square, or the largest.",
    )
    objectives: list[str] = Field(
        default_factory=lambda: ["duir", "feir"],
        description="Criteria that span the Pareto front, or one alone. Default: `[duir, feir]`.",
    )
    model_error: ModelErrorsSection | None = left_out(
        "What MEIR assumes. With this section (`{}` for defaults), or `meir` as an objective, MEIR is evaluated."
    )
    optimiser: OptimiserSection = Field(default=OptimiserSection(), description="The search for the Pareto front.")
    acceptance: AcceptanceSection | None = left_out(
        "Coverage of the expanded uncertainty that decides acceptance. Default: `{k: 2}`."
    )
