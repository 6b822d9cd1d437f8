"""A design problem: everything that a run configuration says, as objects that the search and the criteria work on."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from expdesign.arrays import BoolArray, FloatArray, IntArray
from expdesign.copying import Copied
from expdesign.errors import ExpdesignError, InputError, NotIdentifiableError
from expdesign.estimation.compensation.target_loads import TargetLoads
from expdesign.estimation.coverage import STANDARD, Coverage
from expdesign.estimation.load_errors import DeclaredLoadErrors, Estimator
from expdesign.mechanics.elastostatics.measurements import LoadedRobot
from expdesign.planning.budget import Budget
from expdesign.planning.constraints import Constraints
from expdesign.planning.criteria.assessment import Assessment
from expdesign.planning.criteria.criterion import Criterion, known_criteria
from expdesign.planning.criteria.information import Information
from expdesign.planning.criteria.targets import Targets
from expdesign.planning.deflection_noise import DeflectionNoise
from expdesign.planning.found_robot import FoundRobot
from expdesign.planning.schema import CostsSection, OptimiserSection
from expdesign.planning.space import DesignSpace


def go_on() -> None:
    """Nothing ends what is going on."""


LIMIT_ROUNDING = 1e-12
"""m or rad beyond a limit that are rounding."""


@dataclass(frozen=True, repr=False)
class DesignProblem(Copied):
    """What can be measured, with what noise and load errors, and where accuracy is wanted.

    Attributes:
        loaded: the robot under the load of the experiment, with the sources of load error.
        noise: of the measured deflections.
        targets: where accuracy is wanted.
        target_wrenches: wrench at each target (N, N·m), shape (t, n).
        target_loads: for each target, the robot under its kind of load and that load's parameters (k,).
        space: the designs that can be chosen.
        objectives: the criteria that span the front.
        optimiser: settings of the search.
        config: the configuration as resolved (robot written out, defaults filled in).
        source: name of the configuration file.
        found: the model that the robot was found to be; None where the configuration names a robot file.
        coverage: of the expanded uncertainty by which a target is accepted.
        constraints: on designs beside the robot's limits, or None.
        robot_file: path of the robot's file; empty where the configuration holds the robot itself.
        further: criteria beside those of every design (`known_criteria`) for which the configuration asks.
        known: of the parameters before anything is measured, with the load errors source by source, or None.
        estimator: which least squares estimate the parameters.
        costs: of measuring, where the configuration states them.
        budget: of time in place of a number of measurements, or None.
        validation: rows of a plan that are kept for validation.
        interrupt: called before every evaluation of measurements; raises to end what is going on.
        own_loads: how well the payloads at the targets are known; None where wrenches act at some.
    """

    loaded: LoadedRobot
    noise: DeflectionNoise
    targets: Targets
    target_wrenches: FloatArray
    target_loads: tuple[tuple[LoadedRobot, FloatArray], ...]
    space: DesignSpace
    objectives: tuple[Criterion, ...]
    optimiser: OptimiserSection
    config: dict[str, Any]
    source: str
    found: FoundRobot | None = None
    coverage: Coverage = STANDARD
    constraints: Constraints | None = None
    costs: CostsSection | None = None
    budget: Budget | None = None
    validation: int = 0
    robot_file: str = ""
    further: tuple[Criterion, ...] = ()
    known: Information | None = None
    estimator: Estimator = "generalised"
    interrupt: Callable[[], None] = field(default=go_on, compare=False)
    own_loads: TargetLoads | None = None

    def __repr__(self) -> str:
        objectives = ", ".join(criterion.name for criterion in self.objectives)
        count = len(self.targets.configurations)
        return (
            f"DesignProblem({self.loaded.robot.name}: {self.space.measurements} measurements, "
            f"{count} target{'s' * (count != 1)}, objectives {objectives})"
        )

    @property
    def criteria(self) -> dict[str, Criterion]:
        """Every known criterion, and the further ones, by name."""
        return {**known_criteria(), **{criterion.name: criterion for criterion in self.further}}

    @property
    def load_errors(self) -> DeclaredLoadErrors | None:
        """The errors that recorded loads may have; None where the configuration declares none."""
        return DeclaredLoadErrors(self.loaded, self.source) if self.loaded.sources else None

    def assess(self, configurations: FloatArray, loads: FloatArray, series: IntArray | None = None) -> Assessment:
        """The pieces of every criterion for b designs: configurations (b, m, n_q), loads (b, m, k), series (b, m), 0
        for what is not measured.
        """
        self.interrupt()
        measurements = self.loaded.measure(configurations, loads)
        shared = tuple(source.shared for source in self.loaded.sources)
        if series is None:
            series = self.noise.series(configurations)
        states = (configurations, loads)
        return Assessment(measurements, self.noise, shared, self.targets, series, states, self.known, self.estimator)

    def assessed(self, decisions: FloatArray) -> Assessment:
        """The pieces of every criterion of designs (b, m, g)."""
        quantities = self.space.quantities(decisions)
        return self.assess(*self.space.split(quantities), self.space.series(quantities))

    def whitened(self, configurations: FloatArray, loads: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Whitened maps of single measurements, with any batch dimensions in front.

        Returns:
            G·A, reading per parameter, shape (..., k, n_p), and G·D·L, reading per standard deviation of each load
            error, shape (..., k, d) in the order of `shared_errors`.
        """
        self.interrupt()
        measurements = self.loaded.measure(configurations, loads)
        axes = np.eye(measurements.observation.shape[-2])[self.noise.axes]
        whitener = self.noise.whitener_at(measurements.jacobians.pose) @ axes
        columns = measurements.compliance @ measurements.load_errors
        return whitener @ measurements.observation, whitener @ columns

    @property
    def shared_errors(self) -> BoolArray:
        """Per load error, whether its δ is the same for all measurements, shape (d,)."""
        flags = [np.full(len(source.deviation), source.shared) for source in self.loaded.sources]
        return np.concatenate(flags) if flags else np.zeros(0, dtype=bool)

    def informed(self, decisions: FloatArray) -> Information:
        """What each of the measurements (c, g) says by itself, with its load errors source by source, batch (c,)."""
        return self.assess(
            *self.space.decode(decisions[:, None]), np.ones((len(decisions), 1), dtype=np.int64)
        ).readings

    def reachable(self, decisions: FloatArray) -> BoolArray:
        """Which measurements (..., g) can be taken: within the robot's limits and those of `experiment.constraints`."""
        self.interrupt()
        configurations, loads = self.space.decode(decisions)
        usable: BoolArray = self.loaded.robot.usable(configurations)
        if self.constraints is not None:
            usable &= self.constraints.allowed(self.loaded, configurations, loads)
        return usable

    def settable(self, decisions: FloatArray) -> FloatArray:
        """Designs (b, m, g) as they can be set, sorted, which rounding does not take beyond the robot's limits."""
        robot = self.loaded.robot
        return self.space.settable(decisions, lambda poses: robot.limit_excess(poses) - LIMIT_ROUNDING)

    def require_elastostatic(self, what: str) -> None:
        """Raise an `InputError` where something other than the stiffness alone is calibrated."""
        if not self.loaded.regressor.referenced:
            said = f"{what} for elastostatic calibration only"
            remedy = "`run` and `evaluate` know every calibration; take `experiment.calibration` out for this."
            raise InputError(said, where=f"{self.source}, experiment.calibration", remedy=remedy)

    def unidentified(self, assessment: Assessment, source: str = "") -> ExpdesignError | None:
        """The error that says what the first design of an assessment, of a file `source`, cannot identify, or None."""
        if bool(assessment.identifies_targets[0]):
            return None
        missing = ~assessment.estimable[0] & (self.targets.importance > 0.0)
        target, axis = np.argwhere(missing)[0]
        name = self.loaded.robot.coordinates.deflection[axis]
        rank, parameters = int(assessment.rank[0]), assessment.parameters
        noun = self.loaded.regressor.noun
        needed = f"{name.rsplit('_', 1)[0]} at target {target + 1}"
        what = f"the measurements identify {rank} of {parameters} {noun}, and {needed} depends on the others"
        if rank == 0 and self.loaded.regressor.referenced:
            what = f"no load acts on any actuator: none of the {parameters} {noun} can be determined"
        return NotIdentifiableError(what, where=source or self.source, remedy=self.loaded.regressor.remedy)
