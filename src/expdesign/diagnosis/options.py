"""What a diagnosis and its search by evidence decide by: every threshold in one place."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DiagnosisOptions:
    """Thresholds. Those of laws at ports are with `ports`; tolerances of arithmetic are where they are used.

    Attributes:
        groups: stations or series from which they are left out as wholes, blocks into which rows are divided otherwise,
            and series from which a machine may have settled between them.
        refits: parts of the rows, each left out once to see whether the same is named, or marked rows are judged by.
        shortest_block: rows of a block of marked rows at least: residuals of rows in a row are alike.
        later: factor by which a model may predict the last rows worse than the base model: so few say little.
        better: factor on left-out errors that something further has to go for, or laws have to reach beside names.
        settled: fall of χ² in one step below which a refit has settled: decisions turn on more.
        rough: the same as a share of the excess of χ² that a fit leaves: what is wrong by far need not be exact.
        level: of the test that a part's rows differ, and that a drift shows apart from what else changed.
        mistakes_level: probability below which rows set aside have too much in common; there are four such tests.
        alike: correlation of consecutive residuals above which rows are no longer taken for independent.
        noteworthy: dispersion, or noise beside all laws at once, below which residuals are independent noise as stated.
        listed: share of the excess of χ² below which an effect or a law is no finding: it only predicts.
        explodes: ratio of held-out and fitted error above which held-out rows ask for what was not determined.
        unknown: share of its standard deviation beforehand above which a parameter counts as not determined.
        fewest_rows: below which no law is sought, and predictions are averaged over what may be there.
        single_mistakes: share of the rows that may be single mistakes beside laws.
        usual_mistakes: share of mistakes among recordings beyond which they are no longer single ones.
        all_rows: below which all effects at once cannot be learnt.
        all_excess: RMS of what the base model leaves, in standard deviations, from which many effects can be told.
        all_gains: factor on left-out errors that all effects at once have to reach.
        few: factor on left-out errors within which one or two groups predict as well as all together.
        beside_groups: named effects that are looked for where groups predict: few causes are what names are for.
        refutes: ratio of errors of marked rows and of left-out blocks above which marked rows speak against laws of
            time and memory.
        ends: of guides that are weighed.
        quiet: noise at which ends of guides are compared, in misfits of the base model.
        most_typical: typical sizes of a parameter that its deviation within a group is at most.
        unlike: medians of its group that it is at most: parts of one kind are alike, so that one which hardly shows is
            not as large as it would have to be to show.
        averaged: effects beside the likeliest model over which predictions are averaged, at most.
        averaged_share: posterior weight that each of them has at least.
        averaged_odds: prior odds of something beside the likeliest model: of 0.1, 0.3 and 1 the first gives machines
            that hide nothing as small an error as the base model does (results/model-error).
        kinds: of physics among which the prior probability of an effect is shared.
        fits_per_step: places that are fitted in full in each step, best scores first.
        promising: share of an effect's gain that a score has to promise for a place to be tried in its stead.
        always: places that are tried whatever their scores promise.
        same_pose: share of a coordinate's range within which rows of a series are at one pose.
        confounded: share of the variance of time that one quantity predicts, from which both are confounded.
        drift_shows: part of a drift that has to show in what the other quantity leaves of time.
        temperature: spreads posterior weights: models of real mechanisms are never exact. Like the next three set on
            development sets of `benchmarks/concealed`.
        most: share that is right of the conclusions for which nothing else comes near.
        fitting: factor on probabilities in an unexplained case where the recordings are fitted, or laws locate it.
        tentative: the same where a mismatch remains, part of which effects may imitate.
        beside_laws: the same for a named effect that stands beside laws, part of which it may imitate.
        beside_its_law: the same where one of these is of its own component: physics of a form that has no name.
        indistinguishable: penalised misfits that differ by less leave two explanations open.
        residual_share: of the excess of χ² that may remain in an explained case: no library is exact.
        present: of its own standard deviations, how far an effect has to be from none for its name to be said.
        predicts: `HeldOut.test_surprise` above which a model describes the recordings but does not predict.
        halved: factor on the left-out RMS that halves its square: what an imitation has to reach to predict.
        shows: standard deviations of χ² that count as visible.
    """

    groups: int = 5
    refits: int = 10
    shortest_block: int = 4
    later: float = 1.1
    better: float = 0.98
    settled: float = 1e-2
    rough: float = 1e-3
    level: float = 0.01
    mistakes_level: float = 0.0025
    alike: float = 0.3
    noteworthy: float = 1.5
    listed: float = 0.03
    explodes: float = 10.0
    unknown: float = 0.5
    fewest_rows: int = 12
    single_mistakes: float = 0.02
    usual_mistakes: float = 0.05
    all_rows: int = 60
    all_excess: float = 2.0
    all_gains: float = 0.9
    few: float = 1.15
    beside_groups: int = 2
    refutes: float = 2.0
    ends: int = 3
    quiet: float = 0.03
    most_typical: float = 1e3
    unlike: float = 10.0
    averaged: int = 12
    averaged_share: float = 0.005
    averaged_odds: float = 0.1
    kinds: float = 20.0
    fits_per_step: int = 10
    promising: float = 0.5
    always: int = 3
    same_pose: float = 0.01
    confounded: float = 0.8
    drift_shows: float = 0.5
    temperature: float = 3.0
    most: float = 0.98
    fitting: float = 0.5
    tentative: float = 0.25
    beside_laws: float = 0.6
    beside_its_law: float = 0.5
    indistinguishable: float = 7.0
    residual_share: float = 0.05
    present: float = 2.0
    predicts: float = 1.3
    halved: float = 0.7
    shows: float = 3.0


OPTIONS = DiagnosisOptions()
"""What every diagnosis decides by."""


@dataclass(frozen=True)
class EvidenceOptions:
    """Thresholds; log evidence is natural.

    Attributes:
        alarm: log evidence, prior included, that something has to bring to be believed: odds of e³, about 20 to 1.
        law: −ln of the prior probability of a law: in noise alone the largest gain by any of `entries` laws exceeds
            `law` and `alarm` together in 0.3 % of 600 repetitions (`benchmarks/false_alarms.py`).
        entries: laws of the dictionary for which `law` was set.
        contested: log evidence by which laws have to exceed named physics: what machines are known to do is likelier.
        most: effects and laws that are there together.
        at_one: laws of one component that are added together.
        near: share of the largest gain from which a component is given its chance.
        components: that are given their chance, at most.
        starts: components that the search goes on from, at most.
        like: share of the best one's gain that they need.
        alike: factor on left-out errors within which evidence decides.
        refuted: factor on left-out errors that speaks against a law; 0 where evidence alone decides, as of single laws.
        several: log evidence that a law of its own for every actuator has to exceed that of a single one by.
        wanders: the same of a mount that moves with time alone over a drift of the reading, which is far commoner.
        swap: gain of log evidence for which something is replaced by a law elsewhere.
        tie: the same by a named effect.
        worth: log evidence, prior included, below which a law that was there is left out.
        slack: log evidence that new sizes of the other laws may bring; what falls short by more is not fitted.
        inexact: share of the evidence explained so far that a further component has to gain: no kernel is exact, and
            what one leaves over, the next component would take.
        remains: share of the excess of left-out squares over the noise that laws may leave before predictions are those
            of the base model: functions that change faster than the rows sample them are located, not modelled.
        level: of the paired t-test over blocks.
        mostly: share of the blocks with a visible change that laws have to predict better where they leave `little`.
        nearly_all: the same where they leave more, as imitations of something else do.
        little: share of the excess that is little.
        visible: change of a block's mean square error, in variances of the noise, that counts as one.
        most_inflated: factor on variances: a law whose errors are more than five times as large as it says is wrong,
            not unsure.
        temperature: divides differences of log evidence between components before they become probabilities. With
            `place_most` the most likely on 97 cases of development seeds of `benchmarks/concealed`.
        place_most: probability that a law is where it is found, at most.
        close: log evidence by which components may differ that are not told apart.
        share: the same in proportion to the evidence itself: no model is exact.
    """

    alarm: float = 3.0
    law: float = 5.0
    entries: int = 1200
    contested: float = 10.0
    most: int = 6
    at_one: int = 3
    near: float = 0.4
    components: int = 6
    starts: int = 2
    like: float = 0.8
    alike: float = 1.05
    refuted: float = 0.0
    several: float = 25.0
    wanders: float = 20.0
    swap: float = 4.0
    tie: float = 0.005
    worth: float = -3.0
    slack: float = 10.0
    inexact: float = 0.01
    remains: float = 0.5
    level: float = 0.05
    mostly: float = 0.6
    nearly_all: float = 0.75
    little: float = 0.25
    visible: float = 0.02
    most_inflated: float = 25.0
    temperature: float = 4.0
    place_most: float = 0.95
    close: float = 48.0
    share: float = 0.045


EVIDENCE = EvidenceOptions()
"""What every search decides by."""
