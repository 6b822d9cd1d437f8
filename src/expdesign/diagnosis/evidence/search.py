"""What is there: named effects and laws are weighed together, every part is given its chance, and evidence decides.

Greedy growth of sparse Bayesian learning (Tipping and Faul 2003), over named effects and over components instead of
single columns. Physics of one part seldom is one law: a plate that bends in three directions is three laws of the
platform's mount, and judged one by one an instrument that reads wrong in two of them comes first. So laws are added at
one component until no more of it is worth its evidence, for every component that comes near.

From the best beginnings, and from what names can do alone, the search goes on to further effects and components; what
lost its worth is left out, single ones are exchanged, and of the ends the one is chosen that predicts left-out blocks
best, within 5 % the one with the largest evidence. What has no name pays for that (`DiagnosisOptions.nameless`).
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from expdesign.chain.component import Component
from expdesign.diagnosis.evidence.dictionary import Dictionary
from expdesign.diagnosis.evidence.problem import Chosen, Problem
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS
from expdesign.diagnosis.outliers import single_mistakes
from expdesign.diagnosis.stages import Stage

_TIE = 0.005
"""Gain of log evidence below which two are the same to rounding."""


class Search:
    """The search for what is there.

    Args:
        problem: what may be there, in which readings.
    """

    def __init__(self, problem: Problem) -> None:
        self.problem, self.options, self.start = problem, problem.options, problem.start

    @classmethod
    def over(
        cls, names: Names, dictionary: Callable[[], Dictionary] | None = None, *, mistakes: bool = False
    ) -> "Search":
        """The search among named effects, and the laws of a dictionary, which is made when it is needed.

        Args:
            names: the effects.
            dictionary: makes the laws; None where there are none.
            mistakes: whether rows may be single mistakes.
        """
        mistaken = partial(single_mistakes, sample=names.sample, robot=names.robot) if mistakes else None
        return cls(Problem(names.state(names.base), (), names.blocks, names, dictionary, mistaken=mistaken))

    @property
    def known_names(self) -> Names:
        """Effects that may be there."""
        assert self.problem.names is not None
        return self.problem.names

    def ends(self, most: int | None = None) -> Iterator[Chosen]:
        """What is there, and where that has names alone the likeliest end with laws as well.

        Args:
            most: effects and laws that are looked for at most; as many as the options allow if left out.
        """
        limit = self.options.most if most is None else most
        firsts = self._starts(limit)
        left = list({end.key: end for end in (self._completed(first, limit) for first in firsts)}.values())
        best = preferred(left) if left else self.start
        yield self._finished(best)
        others = [end for end in left if end.laws and not best.laws]
        if others:
            yield self._finished(preferred(others))

    def replacements(self, chosen: Chosen, position: int, *, named: bool = False) -> list[Chosen]:
        """With other effects, or another law if not `named`, in the place of one, where these promise enough."""
        rest = self.problem.without(chosen, position)
        return self.problem.singles(rest, chosen.evidence - rest.evidence, named=named)

    def instead(
        self, model: NamedModel, position: int, least: float
    ) -> tuple[list[NamedModel], dict[tuple[Component, str], float]]:
        """What stands in for one effect of a model: models with another name in its place, and laws.

        Of laws the gain of log evidence by the best one of every component and physics; those that lose more than
        `least` are left out.
        """
        chosen = self.problem.of_model(model)
        rest = self.problem.without(chosen, position)
        loss = chosen.evidence - rest.evidence
        others = self.problem.singles(rest, loss, named=True)
        return [other.model for other in others], self.problem.laws_instead(rest, loss, least)

    def weighed(self, chosen: Chosen, component: Component) -> dict[Component, float]:
        """Gain of log evidence by every component, by all that is there together, in the place of a chosen one.

        Components that come nowhere near are judged by their best single entry. A component with many entries has
        more chances, which the logarithm of their number takes back.
        """
        rest = self.problem.without_component(chosen, component)
        proposal, trials = self.problem.propose(rest), self.problem.trials(rest)
        single: dict[Component, float] = {}
        number: dict[Component, int] = {}
        for atom, gain in zip(self.problem.atoms, proposal.gains, strict=True):
            single[atom.component] = max(single.get(atom.component, 0.0), float(gain))
            number[atom.component] = number.get(atom.component, 0) + 1
        for grown in trials:
            for near in set(grown.components) - set(rest.components) or {component}:
                single[near] = max(single.get(near, 0.0), grown.evidence - rest.evidence)
        single[component] = max(single[component], chosen.evidence - rest.evidence)
        return {place: gain - float(np.log(number[place])) for place, gain in single.items()}

    def _finished(self, best: Chosen) -> Chosen:
        """With the shapes of its laws refined, and each part exchanged where another explains and predicts better."""
        best = self.problem.finer(best)
        if best.laws:
            exchanged = self._swapped(self._exchanged(best))
            if exchanged is not best:
                best = preferred([best, self.problem.finer(exchanged)])
        return best

    def _starts(self, most: int) -> list[Chosen]:
        """The best beginnings, from which the search goes on: the first one need not be right.

        What names can do alone is among them, since what has none may describe as much.
        """
        trials = sorted(self._grown(self.start, most), key=lambda trial: -trial.evidence)
        gains = [trial.evidence - self.start.evidence for trial in trials]
        least = max(self.options.alarm, self.options.nearly * max(gains, default=0.0))
        firsts = [t for t, gain in zip(trials, gains, strict=True) if gain >= least]
        self._note(trials, firsts[:1])
        if self.problem.of_names:
            return firsts[:1]
        named = [t for t, gain in zip(trials, gains, strict=True) if not t.laws and gain >= self.options.alarm]
        return [*firsts[: self.options.starts], *(self._completed(first, most, named=True) for first in named[:1])]

    def _completed(self, current: Chosen, most: int, *, named: bool = False) -> Chosen:
        """With further effects, and laws of further components if not `named` alone, as long as they are worth it."""
        while True:
            trials = self._grown(current, most, named=named)
            if not trials:
                return current
            grown = max(trials, key=lambda trial: trial.evidence)
            gain, explained = grown.evidence - current.evidence, current.evidence - self.start.evidence
            better = gain >= self.options.alarm + (self.options.slight * explained if grown.laws else 0.0)
            self._note(trials, [grown] if better else [])
            if not better:
                return current
            current = self._pruned(grown if grown.laws else self._swapped(grown, named=named))

    def _grown(self, current: Chosen, most: int, *, named: bool = False) -> list[Chosen]:
        """Trials with one more effect, or with the laws of one more component."""
        if current.count >= most:
            return []
        if self.problem.names is not None:
            self.problem.names.report(Stage.EFFECTS, f"{current.count + 1}")
        return self.problem.trials(current, named=named)

    def _exchanged(self, current: Chosen) -> Chosen:
        """What is at one component at a time replaced where another explains and predicts better beside the others."""
        components = current.components
        for component in components if len(components) > 1 else ():
            rest = self.problem.without_component(current, component)
            current = preferred([current, *self.problem.trials(rest)])
        return current

    def _swapped(self, current: Chosen, *, named: bool = False) -> Chosen:
        """Single effects and laws replaced, wherever, as long as that gains evidence.

        The first one takes a share of everything that is there, and those that follow make up for it; given these,
        another one explains more.
        """
        position = 0
        while position < current.count and current.count > 1:
            others = self.replacements(current, position, named=named)
            others = [one for one in others if one.key != current.key]
            best = max(others, key=lambda one: one.evidence, default=current)
            margin = self.options.alarm if set(best.laws) - set(current.laws) else _TIE
            position += 1
            if best.evidence > current.evidence + margin:
                self._note([best], [best], step="exchange")
                current, position = self._pruned(best), 0
        return current

    def unrefuted(self) -> Chosen:
        """What is there without laws that left-out blocks speak against, and with what stands for these otherwise.

        Where rows are alike evidence counts them all as independent, and keeps what only describes the blocks that were
        seen.
        """
        best = next(self.ends())
        while True:
            current = self._predicting(best)
            if not self.problem.refute(set(best.laws) - set(current.laws)):
                return current
            best = preferred([current, self._completed(current, self.options.most)])
        return best

    def _predicting(self, current: Chosen) -> Chosen:
        """Without the laws without which left-out blocks are predicted better, the most harmful first."""
        while len(current.laws) > 1:
            positions = range(len(current.candidates), current.count)
            least = min((self.problem.less(current, position) for position in positions), key=lambda trial: trial.error)
            if least.error > current.error:
                break
            refitted = self.problem.resized(least)
            if refitted.error > self.options.better * current.error:
                break
            current = refitted
        return current

    def _pruned(self, current: Chosen) -> Chosen:
        """Without what is no longer worth its evidence beside the others."""
        for position in range(current.count if current.count > 1 else 0):
            if position < len(current.candidates):
                smaller = self.problem.without(current, position)
                worth, possible = 0.0, hierarchical(smaller.effects)
            else:
                smaller, worth = self.problem.less(current, position), -self.options.alarm
                possible = current.evidence - smaller.evidence < worth + self.options.margin
                smaller = self.problem.resized(smaller) if possible else smaller
            if possible and current.evidence - smaller.evidence < worth:
                self._note([smaller], [smaller], step="backward")
                return self._pruned(smaller)
        return current

    def _note(self, trials: Sequence[Chosen], kept: Sequence[Chosen], step: str = "forward") -> None:
        """What was decided among named effects."""
        for trial in trials:
            if trial.named is not None and not trial.laws:
                reason = f"log evidence {trial.evidence - self.start.evidence:.1f} above the base model's"
                self.known_names.log.add(step, reason, trial.named, kept=any(trial is one for one in kept))


def preferred(trials: Sequence[Chosen]) -> Chosen:
    """Of several: the least left-out error, and within 5 % of it the largest evidence.

    What has no name takes the place of names only where it has more evidence as well.
    """
    if len(trials) == 1:
        return trials[0]

    def worth(trial: Chosen) -> float:
        return trial.evidence - OPTIONS.alarm * len(trial.components)

    def best(of: Sequence[Chosen]) -> Chosen:
        least = min(trial.error for trial in of)
        return max((trial for trial in of if trial.error <= OPTIONS.alike * least), key=worth)

    first = best(trials)
    named = [trial for trial in trials if not trial.nameless and worth(trial) > worth(first)]
    return best(named) if first.nameless and named else first
