"""What a diagnosis found."""

from dataclasses import dataclass, replace
from functools import cached_property

from expdesign.arrays import BoolArray, FloatArray, rms
from expdesign.chain.chain import Chain
from expdesign.chain.identified import ChainBeside
from expdesign.chain.models.drawn import Drawn
from expdesign.chain.recordings.recordings import Recordings, Remark
from expdesign.diagnosis.confirmation import Stability
from expdesign.diagnosis.dispersion import NONE, Widening, widened, widening, with_share
from expdesign.diagnosis.findings import Finding
from expdesign.diagnosis.held_out import HeldOut, held_out_rows
from expdesign.diagnosis.laws import Laws
from expdesign.diagnosis.locate import Location
from expdesign.diagnosis.names import NamedModel, Names
from expdesign.diagnosis.relinearised import AGREES
from expdesign.diagnosis.remarks import WrittenOtherwise
from expdesign.estimation.arm import ArmCalibration
from expdesign.estimation.coverage import reading_deviations
from expdesign.estimation.fit import Fit
from expdesign.estimation.goodness import StatementOfFit
from expdesign.estimation.noise_level import NoiseLevel
from expdesign.estimation.remarks import Implausible
from expdesign.estimation.weighed import WeighedLoads
from expdesign.mechanics.robots.robot import Robot

ONE_AT_A_TIME, TOGETHER, LAWS = "one effect at a time", "all effects at once", "laws at ports"
"""Ways of working, as `method` says them."""


@dataclass(frozen=True)
class Method:
    """The way of working that the recordings call for, and why."""

    name: str
    reason: str


@dataclass(frozen=True)
class Diagnosis:
    """What was found.

    Attributes:
        robot, recordings: what was diagnosed.
        noise: standard deviations of the readings.
        base: fit of the base model.
        calibrated: what of an arm was calibrated before anything was missing; None of what is no arm.
        model: the chosen model, which is the base model where nothing was found.
        predictive: what predictions are made with: the chosen model, or the base model where the chosen one explains
            too little of what was not fitted.
        verdict: `consistent`, `explained`, `modelled` (by laws at ports) or `unexplained`.
        before, after: whether the base model accounts for the fitted rows, and the chosen one.
        location: of the mismatch.
        findings: effects that are present together.
        errors: of the predictive model, on fitted and held-out rows.
        names: everything that was considered, in the rows that belong to some physics.
        laws: at ports, of a mismatch that named physics does not explain; None where none was sought or found.
        method: the way of working that the data call for, and why.
        doubts: what physics holds against the recordings, whatever the model.
        caveats: what limits these statements: what cannot be told apart, and readings that are not independent.
        inexact: share of what named physics does to predictions that is not known; laws have it in their fit.
        left_out: by what blocks that were left out widen the predictions of a model of groups.
        stability: how often nine tenths of the rows name the same; None where nothing, or laws are named.
        loads: errors of the recorded loads, as the predictive model weighs them; None where none are declared.
        judged: the predictive model with these errors as large as they are, by which it is judged; None likewise.
        written_difference: of the fitted rows as the written model predicts them from what is said here, RMS in
            standard deviations of a reading; 0 where nothing was written.
        ended: what was being done when somebody ended the diagnosis, whose model is the best so far; empty otherwise.
    """

    robot: Robot
    recordings: Recordings
    noise: NoiseLevel
    base: Fit
    model: NamedModel
    predictive: NamedModel
    verdict: str
    before: StatementOfFit
    after: StatementOfFit
    location: Location
    findings: tuple[Finding, ...]
    errors: HeldOut
    names: Names
    laws: Laws | None
    method: Method
    calibrated: ArmCalibration | None = None
    doubts: tuple[Implausible, ...] = ()
    caveats: tuple[Remark, ...] = ()
    inexact: float = 0.0
    left_out: Widening = NONE
    stability: Stability | None = None
    ended: str = ""
    written_difference: float = 0.0
    loads: WeighedLoads | None = None
    judged: Fit | None = None

    @property
    def refuted(self) -> bool:
        """Whether the model that predicts is refuted by the recordings, or no explanation of them."""
        return self.verdict == "unexplained" or self.after.refuted

    @cached_property
    def widening(self) -> Widening:
        """By what the recordings widen what the predictive model predicts."""
        fit = self.judged or self.predictive.fit
        return widening(fit, self.names.sample, known_noise=self.noise.known, left_out=self.left_out)

    @property
    def drawn(self) -> Drawn | None:
        """What no reading shows of an arm's tip, beside `known`."""
        chain = self.predictive.fit.chain
        return chain.drawn if isinstance(chain, ChainBeside) else None

    @property
    def known(self) -> Fit:
        """The predictive model with the covariance that its predictions have, what was identified among its effects.

        Where no row tells a joint's zero from the instrument's turn, both are free while physics is sought. Predictions
        for other readings are made in the frames of `identify`: of what instrument and markers stand for, zeros and
        frames are as they were found, and these are as uncertain as that leaves them.
        """
        found = self._sure
        chain = found.chain
        if not isinstance(chain, ChainBeside):
            return found
        return replace(found.known_as(chain.in_frames(found.estimable)), chain=chain.exact)

    @property
    def _sure(self) -> Fit:
        """The predictive model with the covariance that its predictions have."""
        found = self.predictive.fit
        if self.loads is not None:
            whole = found.estimable.generalised + self.loads.excess
            found = found.known_as(replace(found.estimable, generalised=whole))
        found = widened(found, self.widening)
        return with_share(found, self.inexact) if self.inexact else found

    def covering(self, test: BoolArray) -> "Diagnosis":
        """The diagnosis with the share of held-out rows (N,) that lie in the intervals of the model file.

        The file knows the noise of a reading, and not the errors of the loads of other rows.
        """
        if not test.any():
            return self
        sample = self.names.sample
        plain = replace(sample, whitening=sample.whitening.weighing(None))
        rows = held_out_rows(self.predictive.fit, plain, test)
        share = rows.coverage(self._sure.estimable, self.widening.readings)
        return replace(self, errors=replace(self.errors, coverage=share))

    def read_again(self, chain: Chain, values: FloatArray) -> "Diagnosis":
        """The diagnosis with what a model file predicts, its chain and values (p,) as read, compared with itself."""
        fit, sample = self.predictive.fit, self.names.sample
        said, written = sample.residuals(fit.chain, fit.values), sample.residuals(chain, values)
        return self.written_otherwise(rms(written - said, sample.counts))

    def written_otherwise(self, difference: float) -> "Diagnosis":
        """The diagnosis whose file predicts so far from what it says, which is said where it is more than `AGREES`."""
        remarks = (WrittenOtherwise(difference),) if difference > AGREES else ()
        return replace(self, written_difference=difference, caveats=(*self.caveats, *remarks))

    @property
    def reading_deviations(self) -> FloatArray:
        """Standard deviation of a reading (m, rad), as the fit asks for, shape (k,)."""
        return reading_deviations(self.noise.deviations[self.names.sample.counts], self.widening.readings)

    @property
    def rival(self) -> NamedModel | None:
        """A model with other physics that explains the recordings as well, where there is one."""
        return next((finding.rival for finding in self.findings if finding.rival is not None), None)
