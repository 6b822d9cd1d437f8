"""What is known before effects are sought: the rows, their noise, the base model, and what may be named."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from expdesign.arrays import BoolArray, FloatArray
from expdesign.chain.identified import Identified
from expdesign.chain.readings.choice import reading_of
from expdesign.chain.recorded_inputs import ranges_of
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.chain.row import row_data
from expdesign.diagnosis.base_models import BaseModel, base_model
from expdesign.diagnosis.caveats import caveats
from expdesign.diagnosis.dispersion import dispersion, statement
from expdesign.diagnosis.evidence.dictionary import Dictionary
from expdesign.diagnosis.evidence.search import Search
from expdesign.diagnosis.held_out import HeldOut
from expdesign.diagnosis.library import OUTLIER, candidates, library
from expdesign.diagnosis.locate import locate
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.result import Diagnosis, Method
from expdesign.diagnosis.stages import Report, Stage
from expdesign.errors import InputError
from expdesign.estimation.arm import ArmCalibration, identified_by
from expdesign.estimation.estimability import CORRECT_ROW
from expdesign.estimation.fit import Data, Fit, fit
from expdesign.estimation.goodness import StatementOfFit, allows
from expdesign.estimation.identify import fitted_rows
from expdesign.estimation.load_errors import DeclaredLoadErrors, load_columns
from expdesign.estimation.noise_level import NoiseLevel, noise_from_replicates, noise_from_residuals
from expdesign.estimation.remarks import GenerousNoise
from expdesign.estimation.whitening import Whitening
from expdesign.mechanics.robots.robot import Robot


@dataclass(frozen=True)
class Frame:
    """What is known before effects are sought.

    Attributes:
        robot, recordings: what is diagnosed.
        noise: standard deviations of the readings.
        kind: of base model.
        base: its fit.
        calibrated: what of an arm was calibrated before; None of what is no arm.
        judged: held-out rows on which a model can be judged: not those that need what no fitted row determines, (N,).
        sample: the rows that may be fitted.
        names: named physics in the rows that belong to some physics, and every model of them that was fitted.
        remarks: what is wrong with the noise that was stated.
        load_errors: of the recorded loads, that the noise of the rows contains in their declared size; None where none
            are declared, the noise is what the model leaves over, or positions show an arm's geometry.
        mistakes: whether rows may be set aside as single mistakes.
        laws: whether laws at ports may be there; where groups are, these have them.
    """

    robot: Robot
    recordings: Recordings
    noise: NoiseLevel
    kind: BaseModel
    base: Fit
    judged: BoolArray
    sample: Data
    names: Names
    remarks: tuple[Remark, ...] = ()
    load_errors: DeclaredLoadErrors | None = None
    mistakes: bool = True
    laws: bool = True
    calibrated: ArmCalibration | None = None

    @cached_property
    def before(self) -> StatementOfFit:
        """Whether the base model accounts for the rows."""
        return statement(self.base, self.sample, self.noise)

    @property
    def loads_account_for_it(self) -> bool:
        """Whether the base model is refuted, but not where the loads have the errors that are declared."""
        exact = self.before.without_load_errors
        return exact is not None and not self.before.refuted and not allows(exact, self.before.dof)

    @cached_property
    def dictionary(self) -> Dictionary:
        """The laws that these rows could show."""
        self.names.report(Stage.PORTS, "")
        return Dictionary(self.robot, self.names.sample, self.names.base.fit.values)

    @cached_property
    def search(self) -> Search:
        """For named effects together with laws, which take some rows."""
        enough = self.laws and int(self.names.sample.counts.sum()) >= OPTIONS.fewest_rows
        return Search.over(self.names, (lambda: self.dictionary) if enough else None, mistakes=self.mistakes)

    @property
    def aside(self) -> BoolArray:
        """Rows that belong to no physics, as single mistakes do not, shape (N,)."""
        return self.sample.counts & ~self.names.sample.counts

    def without(self, aside: BoolArray) -> "Frame":
        """The same with these rows set aside, shape (N,)."""
        return replace(self, names=self.names.of_rows(self.sample.restricted(~aside)))

    def diagnosis(
        self, model: NamedModel, verdict: str, errors: HeldOut, method: Method, predictive: NamedModel
    ) -> Diagnosis:
        """What a model comes to, without findings; for the arguments see `Diagnosis`."""
        sample, plain = self.names.sample, model is self.names.base and not self.aside.any()
        variance = 1.0 if self.noise.known else float(model.fit.chi2 / max(sample.readings - model.fit.rank, 1))
        spread = dispersion(model.fit.residuals, sample)
        return Diagnosis(
            robot=self.robot,
            recordings=self.recordings,
            noise=self.noise,
            base=self.base,
            model=model,
            predictive=predictive,
            verdict=verdict,
            before=self.before,
            after=self.before if plain else statement(model.fit, sample, self.noise),
            location=locate(self.base, self.sample, self.robot, self.names.library, variance),
            findings=(),
            errors=errors,
            names=self.names,
            laws=None,
            method=method,
            calibrated=self.calibrated,
            caveats=(*self.remarks, *self.names.confounded_time(model), *caveats(sample, model, spread, errors)),
        )

    @property
    def known(self) -> frozenset[str]:
        """Identifiers of the physics that may be named."""
        return frozenset(entry.effect.physics for entry in self.names.library)


def framed(
    robot: Robot,
    recordings: Recordings,
    *,
    without: frozenset[str],
    report: Report,
    load_errors: DeclaredLoadErrors | None = None,
) -> Frame:
    """The frame of a diagnosis; for arguments and what is raised see `diagnose`."""
    if recordings.test.all():
        remedy = "Mark some loaded rows `train` in the column `split`."
        raise InputError("no row is left to fit", where=recordings.source, remedy=remedy)
    if len(robot.stiffness):
        robot.jacobians(recordings.configurations).require_regular(recordings.where, CORRECT_ROW)
    report(Stage.BASE, "")
    reading = reading_of(robot, recordings)
    kind = base_model(robot, reading)
    calibrated = kind.calibrated(recordings)
    identified = None if calibrated is None else identified_by(calibrated, recordings)
    if identified is not None and without & identified.physics:
        identified = None
    sample_with = _sampler(robot, recordings, kind, identified)
    generous: tuple[Remark, ...] = ()
    if calibrated is not None:
        generous = tuple(remark for remark in calibrated.remarks if isinstance(remark, GenerousNoise))
    if calibrated is not None and generous:
        # With what is stated, knowledge beforehand would hold what the readings show.
        noise = calibrated.noise.of_rows(len(recordings))
    else:
        noise = _noise(robot, recordings, sample_with)
    sample = sample_with(noise.deviations)
    base = fit(sample.chain(robot), sample)
    weighed = load_errors if noise.known and calibrated is None else None
    if weighed is not None:
        sample = _weighing(sample, base, weighed)
        base = fit(base.chain, sample)
    kind.require_determined(recordings, base, sample.idle)
    report(Stage.LIBRARY, "")
    known = frozenset() if identified is None else identified.physics
    offered = library(robot, recordings, without=without | known)
    for effect in offered:
        effect.recorded = ranges_of(sample.rows, ~recordings.test, base.chain.row_symbols())
    entries = candidates(offered, sample, robot, base.values)
    names = Names(robot, sample, entries, known_noise=noise.known, report=report)
    predictable = recordings.test & sample.reading.predictable(robot, recordings)
    judged = predictable if predictable.any() else recordings.test
    mistakes = OUTLIER not in without
    return Frame(
        robot,
        recordings,
        noise,
        kind,
        base,
        judged,
        sample,
        names,
        generous,
        weighed,
        mistakes,
        calibrated=calibrated,
    )


def _weighing(sample: Data, base: Fit, errors: DeclaredLoadErrors) -> Data:
    """The rows with errors of their loads in the covariance, as the base model carries them to the readings."""
    effects = errors.effects(base.chain, base.values, sample.recordings)
    columns = load_columns(effects, np.ones(len(effects)))
    return replace(sample, whitening=sample.whitening.weighing(columns))


def _sampler(
    robot: Robot, recordings: Recordings, kind: BaseModel, identified: Identified | None
) -> Callable[[FloatArray], Data]:
    """The rows that may be fitted, for given standard deviations of the readings (N, k)."""
    rows, counts = row_data(recordings, robot), fitted_rows(recordings)
    fitted = recordings.rows(counts)
    reading = reading_of(robot, recordings)
    idle = kind.idle(fitted)
    # What is not fitted shares no noise with what is.
    references = None if recordings.references is None else np.where(counts, recordings.references, "")

    def sample_with(deviations: FloatArray) -> Data:
        whitening = Whitening(deviations, references=references, within=recordings.within)
        return Data(recordings, rows, whitening, idle=idle, reading=reading, identified=identified, marked=counts)

    return sample_with


def _noise(
    robot: Robot,
    recordings: Recordings,
    sample_with: Callable[[FloatArray], Data],
) -> NoiseLevel:
    """Standard deviations of all readings; where none are stated, as the fitted rows show them."""
    if recordings.deviations is not None:
        return NoiseLevel(recordings.deviations, "recordings")
    translations, counts = robot.coordinates.translations, fitted_rows(recordings)
    fitted = recordings.rows(counts)
    replicated = noise_from_replicates(fitted, translations)
    if replicated is not None:
        return replicated.of_rows(len(recordings))

    def solve(deviations: FloatArray) -> Fit:
        sample = sample_with(np.tile(deviations[:1], (len(recordings), 1)))
        return fit(sample.chain(robot), sample).seen_by(counts)

    return noise_from_residuals(fitted, translations, solve).of_rows(len(recordings))
