"""What the search by evidence decides by: every threshold of it in one place."""

from dataclasses import dataclass


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
        temperature: divides differences of log evidence between components before they become probabilities: the most
            likely of 1 to 16 on 16 cases (`benchmarks/calibration.py`, results/ports).
        share: differences of log evidence count at most in this proportion to the evidence itself: no model is exact.
        open: probability from which a component belongs to the set that cannot be told apart.
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
    temperature: float = 16.0
    share: float = 0.015
    open: float = 0.05


EVIDENCE = EvidenceOptions()
"""What every search decides by."""
