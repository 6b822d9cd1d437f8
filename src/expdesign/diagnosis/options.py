"""What a diagnosis and its search by evidence decide by: every threshold in one place."""

from dataclasses import dataclass
from math import log


@dataclass(frozen=True)
class DiagnosisOptions:
    """Thresholds; tolerances of arithmetic are where they are used. Log evidence is natural.

    Attributes:
        level: of the test that a part's rows differ, that a drift shows apart from what else changed, and, shared among
            four tests, that rows set aside have too much in common.
        gain_level: of the paired t-test over blocks that were left out.
        alarm: log evidence, prior included, that something has to bring to be believed: odds of e³, about 20 to 1. A
            law that falls short of none by as much is left out, and a law elsewhere replaces what it exceeds by it.
        overlap: of laws that are alike: the prior of a law is e^overlap over their number. In noise alone the largest
            gain by 1,200 laws exceeds price and `alarm` in 0.3 % of 600 repetitions
            (`research/benchmarks/false_alarms.py`).
        kinds: of physics among which the prior probability of an effect is shared.
        nameless: log evidence that laws have to bring beyond named physics, as what machines are known to do is
            likelier.
        margin: log evidence that new sizes of other laws may bring: what falls short by more is not fitted.
        uncommon: log evidence by which a law of its own for every actuator has to exceed that of a single one, and a
            mount that moves with time alone a drift of the reading.
        most: effects and laws that are there together.
        components: that are given their chance, at most.
        each: laws of one component that are added together, effects of one physics that are fitted in full in each
            step, those that are fitted whatever their scores promise, and ends of guides that are weighed.
        starts: components that the search goes on from, at most; effects that are named beside groups.
        fits: places that are fitted in full in each step, best scores first.
        near: share of the largest gain from which something is given its chance.
        nearly: share that is nearly all: of the best gain that a start needs, of the variance of time that a quantity
            predicts from which both are confounded, of the visible blocks that laws have to predict better where they
            leave more than the rest of the excess, as imitations of something else do.
        half: share that is most of it: of the excess of left-out squares that laws may leave before predictions are
            those of the base model (functions that change faster than the rows sample them are located, not modelled);
            of the visible blocks that laws have to predict better otherwise; of its standard deviation beforehand above
            which a parameter counts as not determined; of a drift, that has to show apart.
        remainder: share that may remain where something is explained, since no library is exact: of the excess of χ²,
            of the rows as mistakes, and of the evidence for components that are not told apart.
        listed: share below which something is hardly there: of the excess of χ², an effect or a law only predicts;
            changes of a block's mean square error in variances of the noise are not counted; noise, in misfits of the
            base model, at which ends of guides are compared.
        slight: share that is as good as nothing: of the evidence explained so far, which a further component has to
            gain; of the posterior weight, which an effect needs to be averaged over.
        better: factor on left-out errors that something further has to go for, or has to reach in the place of names.
        alike: the same within which evidence decides.
        clearly: the same from which one predicts clearly worse, as of the last rows, which are few.
        predicts: left-out errors, dispersion or noise, in expected ones, above which something is missing.
        noticeable: standard deviations: from none, above which the name of an effect is said; of what the base model
            leaves, from which groups of effects can be told.
        shows: standard deviations of χ² that count as visible.
        correlated: correlation of consecutive residuals above which rows are no longer taken for independent.
        most_inflated: factor on variances: a law whose errors are more than five times as large as it says is wrong,
            not unsure; held-out errors so much larger than fitted ones ask for what was not determined.
        form: share of what named physics does by which the library's form of it usually differs from the machine's.
        settled: fall of χ² in one step below which a refit has settled, as decisions turn on more; or a tenth of it as
            a share of the excess that the fit leaves: what is wrong by far need not be exact.
        groups: stations or series from which they are left out as wholes, and blocks into which rows are divided
            otherwise.
        refits: parts of the rows, each left out once to see whether the same is named.
        fewest_rows: below which no law is sought, and predictions are averaged over what may be there; `groups` times
            as many are needed to learn groups of effects.
        temperature: divides differences of log evidence before they become probabilities: models of real mechanisms are
            never exact. Like the next five set on development sets of `research/benchmarks/concealed`.
        surest: share that is right of the conclusions for which nothing else comes near.
        surest_place: probability that a law is where it is found, at most.
        indistinguishable: penalised misfits that differ by less leave two explanations open.
        close: log evidence by which components may differ that are not told apart.
        doubted: factor on probabilities of what something else may imitate: in an unexplained case that is fitted or
            located by laws, beside laws; its square where a mismatch remains.
        averaged_odds: prior odds of something beside the likeliest model: of 0.1, 0.3 and 1 the first gives machines
            that hide nothing as small an error as the base model does.
    """

    level: float = 0.01
    gain_level: float = 0.05
    alarm: float = 3.0
    overlap: float = 2.1
    kinds: float = 20.0
    nameless: float = 10.0
    margin: float = 10.0
    uncommon: float = 20.0
    most: int = 6
    components: int = 6
    each: int = 3
    starts: int = 2
    fits: int = 10
    near: float = 0.4
    nearly: float = 0.8
    half: float = 0.5
    remainder: float = 0.05
    listed: float = 0.03
    slight: float = 0.01
    better: float = 0.98
    alike: float = 1.05
    clearly: float = 1.1
    predicts: float = 1.3
    noticeable: float = 2.0
    shows: float = 3.0
    correlated: float = 0.3
    most_inflated: float = 25.0
    form: float = 0.1
    settled: float = 1e-2
    groups: int = 5
    refits: int = 10
    fewest_rows: int = 12
    temperature: float = 3.0
    surest: float = 0.98
    surest_place: float = 0.95
    indistinguishable: float = 7.0
    close: float = 48.0
    doubted: float = 0.5
    averaged_odds: float = 0.1

    def price_of_law(self, count: int) -> float:
        """−ln of the prior probability of one of so many laws."""
        return max(log(max(count, 1)) - self.overlap, 0.0)


OPTIONS = DiagnosisOptions()
"""What every diagnosis decides by."""
