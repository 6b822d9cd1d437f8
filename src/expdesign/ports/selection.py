"""Which laws are there: evidence proposes, the error of blocks that are left out chooses.

Greedy growth of sparse Bayesian learning (Tipping and Faul 2003) over whole laws instead of single columns: the law
with the largest gain of evidence is not always the right one, so that the best few, and the best of every component
that comes near, are tried, and the one that predicts blocks of rows best stays. After every law all sizes are refitted,
laws that lost their worth are left out, and each is exchanged for others.
"""

from dataclasses import dataclass

import numpy as np

from expdesign.arrays import FloatArray, IntArray
from expdesign.ports.dictionary import Atom, Dictionary
from expdesign.ports.evidence import Present
from expdesign.ports.refinement import refined

ALARM = 8.0
"""Gain of log evidence below which nothing is believed to be there: in noise alone the largest gain by any of about
1,200 entries exceeds it in 0.3 % of 600 repetitions (`benchmarks/ports/false_alarms.py`, results/ports)."""
MOST_LAWS = 6
_BEST, _NEAR = 4, 0.6
_ALIKE = 1.02
"""Factor on left-out errors within which evidence decides."""
_SEVERAL = 4.0
"""Log evidence that a law of its own for every actuator has to exceed that of a single one by."""
_MORE = 0.995
"""Factor on the left-out error that every further law has to reach."""


@dataclass(frozen=True)
class Chosen:
    """Laws that are there together.

    Attributes:
        indices: in the dictionary.
        state: with their sizes.
        error: RMS of left-out readings.
        evidence: log evidence, less what laws of several actuators at once cost.
    """

    indices: tuple[int, ...]
    state: Present
    error: float
    evidence: float


@dataclass(frozen=True)
class Proposal:
    """Gains of every entry of the dictionary beside some laws, and the sizes that reach them."""

    gains: FloatArray
    variances: FloatArray


class LawSearch:
    """The search for laws in one set of readings.

    Args:
        dictionary: the laws that may be there; laws that are refined are added to it.
        base: what is there anyway.
        blocks: block of every reading that is left out together, shape (M,).
    """

    def __init__(self, dictionary: Dictionary, base: Present, blocks: IntArray) -> None:
        self.dictionary, self.base, self.blocks = dictionary, base, blocks
        self.atoms = dictionary.atoms
        self._grams = [atom.directions.T @ atom.directions for atom in self.atoms]
        self._dearer = np.array([_SEVERAL * _of_each(atom) for atom in self.atoms])
        self.log: list[str] = []

    def run(self, *, alarm: float = ALARM, most: int = MOST_LAWS) -> Chosen:
        """The laws that are there; none where no gain exceeds `alarm`."""
        current = self._chosen((), self.base)
        while len(current.indices) < most:
            proposal = self.propose(current.state)
            if proposal.gains.max(initial=0.0) < alarm:
                break
            grown = self._best(current, proposal)
            if grown.state.log_evidence - current.state.log_evidence < alarm:
                break
            if current.indices and grown.error > _MORE * current.error:
                break
            current = self._pruned(self._exchanged(grown))
        return current

    def propose(self, state: Present) -> Proposal:
        """The whole dictionary beside some laws."""
        pairs = [state.gain(atom.directions, gram) for atom, gram in zip(self.atoms, self._grams, strict=True)]
        gains, variances = np.array(pairs).reshape(-1, 2).T
        return Proposal(gains - self._dearer, variances)

    def error_of(self, state: Present) -> float:
        """RMS of readings left out block by block."""
        return self._chosen((), state).error

    def _chosen(self, indices: tuple[int, ...], state: Present) -> Chosen:
        errors = state.left_out(self.blocks)
        evidence = state.log_evidence - float(self._dearer[list(indices)].sum())
        return Chosen(indices, state, float(np.sqrt((errors**2).mean())), evidence)

    def _best(self, current: Chosen, proposal: Proposal) -> Chosen:
        """The best of the laws that are worth a trial beside the present ones."""
        trials = []
        for index in self._worth(proposal):
            trials.append(self._beside(current, index, float(proposal.variances[index])))
        best = preferred(trials)
        finer = self._refined(best)
        return best if finer is None else preferred([best, finer])

    def _refined(self, chosen: Chosen) -> Chosen | None:
        """The same with scales and settings of the last law searched continuously, where that gains evidence."""
        rest = self._chosen(chosen.indices[:-1], chosen.state.without(len(chosen.indices) - 1))
        better = refined(self.atoms[chosen.indices[-1]], self.dictionary, rest.state)
        if better is None:
            return None
        atom, variance = better
        self.atoms.append(atom)
        self._grams.append(atom.directions.T @ atom.directions)
        self._dearer = np.append(self._dearer, _SEVERAL * _of_each(atom))
        return self._beside(rest, len(self.atoms) - 1, variance)

    def _beside(self, current: Chosen, index: int, variance: float) -> Chosen:
        state = current.state.beside(self.atoms[index].directions, variance).refitted()
        return self._chosen((*current.indices, index), state)

    def _worth(self, proposal: Proposal) -> list[int]:
        order = np.argsort(-proposal.gains, kind="stable")
        kept = [int(i) for i in order[:_BEST]]
        seen = {self.atoms[i].component for i in kept}
        for i in order:
            component = self.atoms[i].component
            if proposal.gains[i] < _NEAR * proposal.gains[order[0]]:
                break
            if component not in seen:
                seen.add(component)
                kept.append(int(i))
        return kept

    def _exchanged(self, current: Chosen) -> Chosen:
        """Laws replaced one at a time where another predicts better."""
        if len(current.indices) < 2:
            return current
        for position in range(len(current.indices)):
            rest = current.indices[:position] + current.indices[position + 1 :]
            smaller = self._chosen(rest, current.state.without(position).refitted())
            other = self._best(smaller, self.propose(smaller.state))
            if preferred([current, other]) is other and other.indices != current.indices:
                current = other
        return current

    def _pruned(self, current: Chosen) -> Chosen:
        """Without laws that are no longer worth their evidence beside the others."""
        for position in range(len(current.indices) - 1):
            rest = current.indices[:position] + current.indices[position + 1 :]
            smaller = self._chosen(rest, current.state.without(position).refitted())
            if current.state.log_evidence - smaller.state.log_evidence < 2.0 or smaller.error < current.error:
                return self._pruned(smaller)
        return current


def preferred(trials: list[Chosen]) -> Chosen:
    """Of several: the least left-out error, and within 2 % of it the largest evidence."""
    least = min(trial.error for trial in trials)
    return max((t for t in trials if t.error <= _ALIKE * least), key=lambda t: t.evidence)


def _of_each(atom: Atom) -> bool:
    """Whether an entry has a law of its own for every actuator."""
    return atom.entry is not None and atom.component.several and atom.entry.blocks > 1
