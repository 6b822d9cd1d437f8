"""Which laws are there: every component is given its best chance, and evidence decides between components.

Greedy growth of sparse Bayesian learning (Tipping and Faul 2003) over components instead of single columns. Physics of
one part seldom is one entry of the dictionary: a plate that bends in three directions is three laws of the platform's
mount, and judged entry by entry an instrument that reads wrong in two of them comes first. So laws are added at one
component until no more of it is worth its evidence, for every component that comes near. From the best components the
search goes on to further ones, laws that lost their worth are left out, and of the ends the one is chosen that predicts
left-out series best, within 5 % the one with the largest evidence. At last the laws of each component are exchanged.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.chain.component import Component
from expdesign.chain.ports.port import Entry
from expdesign.diagnosis.evidence.dictionary import Atom
from expdesign.diagnosis.evidence.options import EVIDENCE, EvidenceOptions
from expdesign.diagnosis.evidence.refinement import refined
from expdesign.diagnosis.evidence.screen import Screen
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.sample import rms


@dataclass(frozen=True)
class Chosen:
    """Laws that are there together.

    Attributes:
        indices: in the dictionary.
        state: with their sizes.
        evidence: log evidence, less what laws of several actuators at once cost.
        blocks: block of every reading that is left out together, shape (M,).
        components: number of components that they are at.
        nameless: whether one of them has no name.
    """

    indices: tuple[int, ...]
    state: Present
    evidence: float
    blocks: IntArray
    components: int
    nameless: bool = False

    @cached_property
    def error(self) -> float:
        """RMS of left-out readings."""
        return rms(self.state.left_out(self.blocks))


@dataclass(frozen=True)
class Proposal:
    """Gains of every entry of the dictionary beside some laws, and the sizes that reach them."""

    gains: FloatArray
    variances: FloatArray


class LawSearch:
    """The search for laws in one set of readings.

    Args:
        atoms: the laws that may be there; laws that are refined are added to them.
        base: what is there anyway.
        blocks: block of every reading that is left out together, shape (M,).
        made: the atom of another entry, which refines scales and settings; None where there is none.
        options: thresholds.
    """

    def __init__(
        self,
        atoms: list[Atom],
        base: Present,
        blocks: IntArray,
        made: Callable[[Entry], Atom | None] = lambda entry: None,
        options: EvidenceOptions = EVIDENCE,
    ) -> None:
        self.atoms, self.base, self.blocks, self._made, self.options = atoms, base, blocks, made, options
        self._screen = Screen(base, self.atoms)
        self._dearer = np.array([_dearer(atom) for atom in self.atoms])
        self._listed = len(self.atoms)
        self._refuted: set[int] = set()
        self._seen: dict[tuple[int, ...], tuple[Proposal, list[Chosen]]] = {}
        self.log: list[str] = []

    def run(self, seeds: Sequence[int] = ()) -> Chosen:
        """The laws that are there; none where no gain is an alarm.

        Args:
            seeds: physics of known form that explains something together, from which the search goes on as well.
        """
        start = self._chosen((), self.base)
        firsts = self._starts(start)
        if seeds:
            firsts.append(self._seeded(start, seeds))
        ends = [self._completed(start, first) for first in firsts]
        if not ends:
            return start
        best = self._finer(preferred(ends))
        exchanged = self._swapped(self._exchanged(best))
        if exchanged is not best:
            best = preferred([best, self._finer(exchanged)])
        return self._unrefuted(start, best)

    def _starts(self, start: Chosen) -> list[Chosen]:
        """The best components with their laws, from which the search goes on: the first one need not be right."""
        trials = sorted(self._trials(start), key=lambda trial: -trial.evidence)
        gains = [trial.evidence - start.evidence for trial in trials]
        least = max(self.options.alarm, self.options.like * max(gains, default=0.0))
        return [t for t, gain in zip(trials, gains, strict=True) if gain >= least][: self.options.starts]

    def _seeded(self, current: Chosen, seeds: Sequence[int]) -> Chosen:
        """With physics of known form, less what is not worth its evidence."""
        for index in seeds:
            variance = current.state.gain(self._screen.directions(index))[1]
            current = self._beside(current, index, variance)
        return self._pruned(current)

    def _completed(self, start: Chosen, current: Chosen) -> Chosen:
        """With the laws of further components, as long as they are worth it."""
        while len(current.indices) < self.options.most_laws:
            trials = self._trials(current)
            if not trials:
                break
            grown = max(trials, key=lambda trial: trial.evidence)
            if grown.evidence - current.evidence < self.options.alarm + self.options.inexact * (
                current.evidence - start.evidence
            ):
                break
            current = self._pruned(grown)
        return current

    def propose(self, beside: Chosen, only: Sequence[int] | None = None) -> Proposal:
        """The whole dictionary beside some laws, or `only` some of it."""
        gains, variances = self._screen.gains(beside.state, beside.indices, only)
        gains[[i for i in range(len(gains)) if (i if only is None else only[i]) in self._refuted]] = 0.0
        return Proposal(gains - (self._dearer if only is None else self._dearer[only]), variances)

    def components(self, chosen: Chosen) -> list[Component]:
        """Where the laws are, each component once."""
        return list(dict.fromkeys(self.atoms[i].component for i in chosen.indices))

    def without(self, chosen: Chosen, component: Component) -> Chosen:
        """The laws of all other components, refitted."""
        state, indices = chosen.state, list(chosen.indices)
        for position in reversed(range(len(indices))):
            if self.atoms[indices[position]].component == component:
                state = state.without(position)
                del indices[position]
        return self._chosen(tuple(indices), state.refitted())

    def weighed(self, chosen: Chosen, component: Component) -> dict[Component, float]:
        """Gain of log evidence by every component, by its laws together, in the place of a chosen one.

        Components that come nowhere near are judged by their best single entry. A component with many entries has
        more chances, which the logarithm of their number takes back.
        """
        rest = self.without(chosen, component)
        proposal, trials = self._proposed(rest)
        single: dict[Component, float] = {}
        number: dict[Component, int] = {}
        for atom, gain in zip(self.atoms, proposal.gains, strict=False):
            single[atom.component] = max(single.get(atom.component, 0.0), float(gain))
            number[atom.component] = number.get(atom.component, 0) + 1
        for grown in trials:
            near = self.atoms[grown.indices[-1]].component
            single[near] = max(single[near], grown.evidence - rest.evidence)
        single[component] = max(single[component], chosen.evidence - rest.evidence)
        return {place: gain - float(np.log(number[place])) for place, gain in single.items()}

    def _add(self, atom: Atom) -> None:
        self.atoms.append(atom)
        self._screen.add([atom])
        self._dearer = np.append(self._dearer, _dearer(atom))

    def _chosen(self, indices: tuple[int, ...], state: Present) -> Chosen:
        evidence = state.log_evidence - float(self._dearer[list(indices)].sum())
        chosen = [self.atoms[i] for i in indices]
        nameless = any(atom.entry is not None for atom in chosen)
        return Chosen(indices, state, evidence, self.blocks, len({atom.component for atom in chosen}), nameless)

    def _trials(self, current: Chosen) -> list[Chosen]:
        """Components that come near, each with its laws beside the present ones; none where nothing is worth it."""
        return self._proposed(current)[1]

    def _proposed(self, current: Chosen) -> tuple[Proposal, list[Chosen]]:
        """Gains of all entries beside the present laws, and the trials; remembered, since ends are weighed again."""
        if current.indices not in self._seen:
            proposal = self.propose(current)
            near = self._near(proposal) if proposal.gains.max(initial=0.0) >= self.options.alarm else []
            trials = [self._at(current, component, proposal) for component in near]
            self._seen[current.indices] = proposal, trials
        return self._seen[current.indices]

    def _near(self, proposal: Proposal) -> list[Component]:
        """Components that are given their chance, the one with the best entry first."""
        order = np.argsort(-proposal.gains, kind="stable")
        near = [i for i in order if proposal.gains[i] >= self.options.near * proposal.gains[order[0]]]
        return list(dict.fromkeys(self.atoms[i].component for i in near))[: self.options.components]

    def _at(self, current: Chosen, component: Component, proposal: Proposal) -> Chosen:
        """With the laws of one component, until no further one is worth its evidence."""
        own = [i for i, atom in enumerate(self.atoms) if atom.component == component]
        best = own[int(np.argmax(proposal.gains[own]))]
        grown = self._beside(current, best, float(proposal.variances[best]))
        for _ in range(min(self.options.at_one, self.options.most_laws - len(current.indices)) - 1):
            further = self.propose(grown, own)
            if further.gains.max() < self.options.alarm:
                break
            best = int(np.argmax(further.gains))
            grown = self._beside(grown, own[best], float(further.variances[best]))
        return grown

    def _beside(self, current: Chosen, index: int, variance: float) -> Chosen:
        state = current.state.beside(self._screen.directions(index), variance).refitted()
        return self._chosen((*current.indices, index), state)

    def _finer(self, grown: Chosen) -> Chosen:
        """The same with scales and settings of the laws searched continuously, where that does not predict worse."""
        tried: set[int] = set()
        while True:
            left = [p for p, index in enumerate(grown.indices) if index < self._listed and index not in tried]
            if not left:
                return grown
            index, rest = grown.indices[left[0]], grown.state.without(left[0])
            tried.add(index)
            better = refined(self.atoms[index], self._made, rest)
            if better is None:
                continue
            self._add(better[0])
            indices = (*grown.indices[: left[0]], *grown.indices[left[0] + 1 :], len(self.atoms) - 1)
            trial = self._chosen(indices, rest.beside(self._screen.directions(indices[-1]), better[1]).refitted())
            if trial.evidence > grown.evidence and trial.error <= self.options.alike * grown.error:
                grown = trial

    def _exchanged(self, current: Chosen) -> Chosen:
        """The laws of one component at a time replaced where another explains and predicts better beside the others."""
        components = self.components(current)
        for component in components if len(components) > 1 else ():
            rest = self.without(current, component)
            others = self._trials(rest)
            current = preferred([current, *others])
        return current

    def _swapped(self, current: Chosen) -> Chosen:
        """Single laws replaced, wherever, as long as that gains evidence.

        The first law takes a share of everything that is there, and those that follow make up for it; given these,
        another one explains more.
        """
        position = 0
        while position < len(current.indices):
            rest = current.indices[:position] + current.indices[position + 1 :]
            beside = self._chosen(rest, current.state.without(position))
            proposal = self.propose(beside)
            best = int(np.argmax(proposal.gains))
            promised = beside.evidence + float(proposal.gains[best]) + self.options.slack
            position += 1
            if best not in current.indices and promised > current.evidence + self.options.swap:
                changed = self._beside(beside, best, float(proposal.variances[best]))
                if changed.evidence > current.evidence + self.options.swap:
                    current, position = self._pruned(changed), 0
        return current

    def _unrefuted(self, start: Chosen, best: Chosen) -> Chosen:
        """Without laws that left-out blocks speak against, and with what stands for these otherwise.

        Where rows are alike evidence counts them all as independent, and keeps what only describes the blocks that were
        seen.
        """
        while self.options.refuted > 0.0:
            current = self._predicting(best)
            refuted = set(best.indices) - set(current.indices) - self._refuted
            if not refuted:
                return current
            self._refuted |= refuted
            self._seen.clear()
            best = preferred([current, self._completed(start, current)])
        return best

    def _predicting(self, current: Chosen) -> Chosen:
        """Without the laws without which left-out blocks are predicted better, the most harmful first."""
        while len(current.indices) > 1:
            smaller = [self._less(current, position) for position in range(len(current.indices))]
            least = min(smaller, key=lambda trial: trial.error)
            if least.error > current.error:
                break
            refitted = self._refitted(least)
            if refitted.error > self.options.refuted * current.error:
                break
            current = refitted
        return current

    def _less(self, current: Chosen, position: int) -> Chosen:
        """Without one law, the sizes of the others as they are."""
        rest = current.indices[:position] + current.indices[position + 1 :]
        return self._chosen(rest, current.state.without(position))

    def _refitted(self, current: Chosen) -> Chosen:
        return self._chosen(current.indices, current.state.refitted())

    def _pruned(self, current: Chosen) -> Chosen:
        """Without laws that are no longer worth their evidence beside the others."""
        for position in range(len(current.indices) - 1):
            smaller = self._less(current, position)
            if current.evidence - smaller.evidence < self.options.worth + self.options.slack:
                smaller = self._refitted(smaller)
                if current.evidence - smaller.evidence < self.options.worth:
                    return self._pruned(smaller)
        return current


def preferred(trials: list[Chosen]) -> Chosen:
    """Of several: the least left-out error, and within 5 % of it the largest evidence."""
    least = min(trial.error for trial in trials)
    alike = (trial for trial in trials if trial.error <= EVIDENCE.alike * least)
    return max(alike, key=lambda t: t.evidence - EVIDENCE.alarm * t.components - EVIDENCE.contested * t.nameless)


def _dearer(atom: Atom) -> float:
    """Log evidence that an entry has to bring beyond others."""
    return EVIDENCE.several * _of_each(atom) + EVIDENCE.wanders * _wanders(atom)


def _of_each(atom: Atom) -> bool:
    """Whether an entry has a law of its own for every actuator."""
    return atom.entry is not None and atom.component.several and atom.entry.blocks > 1


def _wanders(atom: Atom) -> bool:
    """Whether an entry is a mount that moves whatever it carries."""
    return atom.entry is not None and atom.entry.form == "twist" and atom.entry.inputs[0].kind in ("clock", "elapsed")
