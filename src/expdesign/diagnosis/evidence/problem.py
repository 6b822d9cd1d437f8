"""What may be there in one set of readings: named effects and laws, and whatever stands beside something that is.

What stands beside a fit is weighed by its largest gain of log evidence to first order. Named effects that promise
something are then fitted in full, beside the laws that are there, and the problem is linear about that fit from there
on; laws are linear as they are.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from expdesign.arrays import FloatArray, IntArray, rms
from expdesign.chain.component import Component
from expdesign.chain.effect import Effect
from expdesign.chain.ports.law import Law, physics_of
from expdesign.chain.ports.port import Entry
from expdesign.diagnosis.evidence.dictionary import Atom, Dictionary
from expdesign.diagnosis.evidence.refinement import refined
from expdesign.diagnosis.evidence.screen import Screen
from expdesign.diagnosis.evidence.state import Present
from expdesign.diagnosis.library import Candidate
from expdesign.diagnosis.names import NamedModel, Names, hierarchical
from expdesign.diagnosis.options import OPTIONS, DiagnosisOptions
from expdesign.diagnosis.outliers import Mistakes

_Promise = tuple[float, Candidate, Callable[[], FloatArray]]
"""A named effect with the log evidence that it promises, and what gives parameters to start its fit from."""


@dataclass(frozen=True)
class Chosen:
    """Named effects and laws that are there together.

    Attributes:
        named: the effects as they were fitted, beside the laws; None in a problem that is linear.
        laws: numbers of the laws.
        state: linear about that fit, the effects first.
        price: log evidence that all have to bring: −ln of their prior.
        blocks: block of every reading that is left out together, shape (M,).
        at: where every effect is, and every law.
        nameless: whether one of the laws has no name.
        mistaken: which rows stand out of a state as single mistakes do.
    """

    named: NamedModel | None
    laws: tuple[int, ...]
    state: Present
    price: float
    blocks: IntArray
    at: tuple[Component, ...]
    nameless: bool = False
    mistaken: Callable[[Present], Mistakes] | None = None

    @property
    def model(self) -> NamedModel:
        """The named effects, where there may be any."""
        assert self.named is not None
        return self.named

    @property
    def candidates(self) -> tuple[Candidate, ...]:
        """The named effects."""
        return () if self.named is None else self.named.candidates

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The named effects themselves."""
        return () if self.named is None else self.named.effects

    @property
    def components(self) -> list[Component]:
        """Where effects and laws are, each component once."""
        return list(dict.fromkeys(self.at))

    @property
    def count(self) -> int:
        """Of named effects and laws."""
        return len(self.candidates) + len(self.laws)

    @property
    def key(self) -> tuple[object, ...]:
        """Two with the same are the same."""
        return () if self.named is None else self.named.keys, self.laws

    @cached_property
    def mistakes(self) -> Mistakes:
        """Rows that stand out by themselves."""
        return Mistakes(np.zeros(0, dtype=bool)) if self.mistaken is None else self.mistaken(self.state)

    @property
    def evidence(self) -> float:
        """Log evidence less the price, rows that stand out as single mistakes do at theirs."""
        return self.state.log_evidence - self.price + self.mistakes.worth

    @cached_property
    def error(self) -> float:
        """RMS of left-out readings."""
        return rms(self.state.left_out(self.blocks))


class Proposal(NamedTuple):
    """Gains of everything beside what is there, prior included, and the sizes that reach them."""

    gains: FloatArray
    variances: FloatArray


class Problem:
    """Everything that may be there, in one set of readings.

    Args:
        base: what is there anyway.
        laws: that may be there.
        blocks: block of every reading that is left out together, shape (M,).
        names: effects that may be there; None where there are laws alone.
        dictionary: makes further laws that may be there, when they could be worth it; they are refined, and what is
            refined is added to them. None where there are none.
        options: thresholds.
        mistaken: which rows stand out of a state as single mistakes do; None where none can.

    Attributes:
        atoms: the starts of all named effects, then the laws.
        prices: log evidence that each has to bring beyond the alarm, shape (n,).
        start: nothing.
    """

    def __init__(
        self,
        base: Present,
        laws: Sequence[Atom],
        blocks: IntArray,
        names: Names | None = None,
        dictionary: Callable[[], Dictionary] | None = None,
        options: DiagnosisOptions = OPTIONS,
        mistaken: Callable[[Present], Mistakes] | None = None,
    ) -> None:
        self.blocks, self.names, self._dictionary, self.options = blocks, names, dictionary, options
        self._mistaken = mistaken
        self._made: Callable[[Entry], Atom | None] = lambda entry: None
        self.atoms: list[Atom] = []
        self._first = len(names.atoms) if names else 0
        self._law = self.options.price_of_law(len(laws))
        self._screen = Screen(self.atoms)
        self.prices, self._nameless = np.zeros(0), np.zeros(0)
        self._add([*(names.atoms if names else ()), *laws])
        self._listed = len(self.atoms)
        self._refuted: set[int] = set()
        self._seen: dict[tuple[object, ...], list[Chosen]] = {}
        self._seen_names: dict[tuple[object, ...], list[Chosen]] = {}
        self.start = self._chosen(names.base if names else None, (), base)

    @property
    def of_names(self) -> bool:
        """Whether named effects alone have been weighed."""
        return self._first == len(self.atoms)

    def refute(self, laws: set[int]) -> bool:
        """Offer these laws no longer; whether any of them was."""
        new = laws - self._refuted
        self._refuted |= new
        self._seen.clear()
        return bool(new)

    def of_model(self, model: NamedModel) -> Chosen:
        """Named effects as they were fitted, without laws."""
        assert self.names is not None
        return self._chosen(model, (), self.names.state(model))

    def propose(self, beside: Chosen, only: Sequence[int] | None = None) -> Proposal:
        """Everything beside what is there, or `only` some of it."""
        state, named = beside.state, len(beside.candidates)
        gains, variances = self._screen.gains(state, named, beside.laws, only)
        gains[[i for i in range(len(gains)) if (i if only is None else only[i]) in self._refuted]] = 0.0
        prices = self.prices + (0.0 if beside.nameless else self.options.nameless) * self._nameless
        return Proposal(gains - (prices if only is None else prices[only]), variances)

    def trials(self, current: Chosen, *, named: bool = False) -> list[Chosen]:
        """Effects that promise something, and components that come near, each with its laws beside what is there.

        They are remembered, since ends are weighed again.

        Args:
            current: what is there.
            named: whether effects are asked for alone.
        """
        key = current.key
        if key not in self._seen_names:
            some = None if current.laws else range(self._first)
            self._seen_names[key] = self._named(current, self.propose(current, some), -np.inf) if self.names else []
        names = self._seen_names[key]
        if named:
            return names
        if key not in self._seen:
            least = max([self.options.alarm, *(trial.evidence - current.evidence for trial in names)])
            open_to_laws = self.names is None or current.laws or self._most(current) - self.options.nameless > least
            self._seen[key] = [*(self._laws(current) if open_to_laws else ()), *names]
        return self._seen[key]

    def _laws(self, current: Chosen) -> list[Chosen]:
        """With the laws of one component that comes near, each."""
        if self._dictionary is not None:
            self._look_up(self._dictionary())
        proposal = self.propose(current)
        return [self._at(current, component, proposal) for component in self._near(proposal)]

    def singles(self, rest: Chosen, loss: float, *, named: bool = False) -> list[Chosen]:
        """With one effect, or one law if not `named` alone, more that may bring what the one taken away brought."""
        proposal = self.propose(rest, range(self._first) if named else None)
        trials = [one for one in self._named(rest, proposal, self.options.near * loss) if hierarchical(one.effects)]
        gains = proposal.gains[self._first :]
        if gains.size:
            best = int(np.argmax(gains))
            if gains[best] + self.options.margin > loss + self.options.alarm:
                index = self._first + best
                trials.append(self.with_law(rest, index, float(proposal.variances[index])))
        return trials

    def laws_instead(self, rest: Chosen, worth: float, least: float) -> dict[tuple[Component, str], float]:
        """Gain of log evidence by the best law of every component and physics, over an effect that is worth so much.

        A law of no declared form is the physics whose port it has and whose inputs it depends on; it is not charged for
        having no name then. Laws that fall short by more than `least` are left out.
        """
        if self.names is None:
            return {}
        if self._dictionary is not None:
            self._look_up(self._dictionary())
        proposal, found = self.propose(rest), dict[tuple[Component, str], float]()
        known = {candidate.effect.physics for candidate in self.names.library}
        # Sizes of what is beside it may bring more than the law alone shows.
        enough = worth - least - self.options.margin - self.options.nameless
        for index in np.argsort(-proposal.gains, kind="stable"):
            entry = self.atoms[index].entry
            if proposal.gains[index] < enough:
                break
            if entry is None:
                continue
            terms = entry.quantities, entry.channels
            physics = physics_of(self.names.robot, entry.port, entry.component, entry.form, terms, known)
            if (entry.component, physics) not in found:
                trial = self.with_law(rest, int(index), float(proposal.variances[index]))
                named = 0.0 if physics == Law.physics else self.options.nameless
                found[entry.component, physics] = trial.evidence - rest.evidence + named - worth
        return {law: gain for law, gain in found.items() if gain > -least}

    def without(self, chosen: Chosen, position: int) -> Chosen:
        """Without one effect, the others fitted in full, or without one law, the others resized."""
        if position >= len(chosen.candidates):
            smaller = self.less(chosen, position)
            return self.resized(smaller)
        assert self.names is not None
        rest = chosen.candidates[:position] + chosen.candidates[position + 1 :]
        return self._with_names(chosen, rest, {})

    def without_component(self, chosen: Chosen, component: Component) -> Chosen:
        """What is at all other components."""
        for position in reversed(range(chosen.count)):
            if chosen.at[position] == component:
                last_law = position >= len(chosen.candidates)
                chosen = self.less(chosen, position) if last_law else self.without(chosen, position)
        return self.resized(chosen)

    def less(self, current: Chosen, position: int) -> Chosen:
        """Without one law, the sizes of the others as they are."""
        at = position - len(current.candidates)
        laws = current.laws[:at] + current.laws[at + 1 :]
        return self._chosen(current.named, laws, current.state.without(position))

    def resized(self, current: Chosen) -> Chosen:
        """The same with the sizes that maximise the evidence."""
        return self._chosen(current.named, current.laws, current.state.refitted())

    def with_law(self, current: Chosen, index: int, variance: float) -> Chosen:
        """With one law more, all sizes anew from this one's."""
        state = current.state.beside(self._screen.directions(index), variance).refitted()
        return self._chosen(current.named, (*current.laws, index), state)

    def finer(self, grown: Chosen) -> Chosen:
        """The same with scales and settings of the laws searched continuously, where that does not predict worse."""
        tried: set[int] = set()
        while True:
            left = [p for p, index in enumerate(grown.laws) if index < self._listed and index not in tried]
            if not left:
                return grown
            index, rest = grown.laws[left[0]], self.less(grown, len(grown.candidates) + left[0])
            tried.add(index)
            better = refined(self.atoms[index], self._made, rest.state)
            if better is None:
                continue
            self._add([better[0]])
            trial = self.with_law(rest, len(self.atoms) - 1, better[1])
            if trial.evidence > grown.evidence and trial.error <= self.options.alike * grown.error:
                grown = trial

    def _most(self, current: Chosen) -> float:
        """Log evidence that one parameter would gain which took away all that exceeds the noise; ∞ of unknown noise.

        One that takes away q in χ² gains ½·(q − ln q). The noise is that of M − p readings, and as much as it scatters.
        """
        state = current.state
        noise = state.freedom + float(np.sqrt(2.0 * state.freedom))
        excess = max(state.scatter - noise - 2.0 * current.mistakes.worth, 1.0)
        return 0.5 * (excess - float(np.log(excess))) if state.known_noise else float("inf")

    def _look_up(self, dictionary: Dictionary) -> None:
        """Offer the laws of a dictionary."""
        self._law, self._made, self._dictionary = (
            self.options.price_of_law(len(dictionary.atoms)),
            dictionary.made,
            None,
        )
        self._add(dictionary.atoms)
        self._listed = len(self.atoms)

    def _add(self, atoms: Sequence[Atom]) -> None:
        first = len(self.atoms)
        self.atoms += atoms
        self._screen.add(atoms)
        self.prices = np.append(self.prices, [self._price(index) for index in range(first, len(self.atoms))])
        self._nameless = np.append(self._nameless, [atom.entry is not None for atom in atoms])

    def _near(self, proposal: Proposal) -> list[Component]:
        """Components whose laws are given their chance, the one with the best law first."""
        gains = proposal.gains[self._first :]
        best = proposal.gains.max(initial=0.0)
        if gains.max(initial=0.0) < self.options.alarm:
            return []
        order = np.argsort(-gains, kind="stable")
        near = [i for i in order if gains[i] >= self.options.near * best]
        return list(dict.fromkeys(self.atoms[self._first + i].component for i in near))[: self.options.components]

    def _at(self, current: Chosen, component: Component, proposal: Proposal) -> Chosen:
        """With the laws of one component, until no further one is worth its evidence."""
        own = [i for i in range(self._first, len(self.atoms)) if self.atoms[i].component == component]
        best = own[int(np.argmax(proposal.gains[own]))]
        grown = self.with_law(current, best, float(proposal.variances[best]))
        for _ in range(min(self.options.each, self.options.most - current.count) - 1):
            further = self.propose(grown, own)
            if further.gains.max() < self.options.alarm:
                break
            best = int(np.argmax(further.gains))
            grown = self.with_law(grown, own[best], float(further.variances[best]))
        return grown

    def _named(self, current: Chosen, proposal: Proposal, wanted: float) -> list[Chosen]:
        """With one more effect each, fitted in full: the best ones, others only where they promise what is `wanted`.

        No more than three of one physics, so that rival explanations get their fit as well.
        """
        if self.names is None or len(current.candidates) >= self.names.most_effects:
            return []
        best: dict[int, _Promise] = {}
        for index in np.argsort(-proposal.gains[: self._first], kind="stable"):
            candidate = _candidate(self.atoms[index])
            if id(candidate) not in best:
                law, variance = partial(self._screen.directions, int(index)), float(proposal.variances[index])
                begin = partial(_start_of, current.state, self.atoms[index], law, variance)
                best[id(candidate)] = float(proposal.gains[index]), candidate, begin
        ranked = [*best.values(), *self._idle(current)]
        ranked = [item for item in ranked if self.names.fits_beside(item[1], current.candidates)]
        ranked.sort(key=lambda item: (-item[0], item[1].effect.key))
        taken: dict[str, int] = {}
        trials: list[Chosen] = []
        always = 1 if current.laws else self.options.each
        best_of_all = float(proposal.gains.max(initial=0.0))
        # Where nothing promises to be worth it to first order, what is not linear may be nevertheless.
        if best_of_all >= self.options.alarm or current.laws or self._most(current) < self.options.alarm:
            wanted = max(wanted, self.options.near * best_of_all)
        for gain, candidate, start in ranked:
            physics = candidate.effect.physics
            if taken.get(physics, 0) >= self.options.each or len(trials) == self.options.fits:
                continue
            if sum(taken.values()) >= always and gain < wanted:
                break
            chosen = (*current.candidates, candidate)
            trial = self._with_names(current, chosen, {candidate.effect.key: start()})
            taken[physics] = taken.get(physics, 0) + 1
            if self.names.possible(trial.model, candidate, current.state):
                trials.append(trial)
        return trials

    def _idle(self, current: Chosen) -> list[_Promise]:
        """Effects that do nothing to a base model without springs, and what they promise beside what is there."""
        assert self.names is not None
        found: list[_Promise] = []
        for atom in self.names.idle(current.model):
            gain, variance = current.state.gain(atom.directions)
            begin = partial(_start_of, current.state, atom, atom.columns.matrix, variance)
            found.append((gain - self.names.price(_candidate(atom)), _candidate(atom), begin))
        return found

    def _with_names(self, current: Chosen, chosen: Sequence[Candidate], starts: dict[str, FloatArray]) -> Chosen:
        """Other named effects beside the same laws, fitted in full from where those that stay are."""
        assert self.names is not None
        directions = tuple(self._screen.directions(index) for index in current.laws)
        sizes = current.state.variances[len(current.candidates) :]
        staying = [candidate for candidate in chosen if candidate.effect.key not in starts]
        known = dict(zip((c.effect.key for c in staying), self.names.parts(current.model, staying), strict=True))
        parts = [(known | starts)[candidate.effect.key] for candidate in chosen]
        laws = tuple(zip(current.laws, directions, sizes, strict=True))
        model = self.names.model(chosen, parts, current.model, laws)
        state = self.names.state(model)
        for law, size in zip(directions, sizes, strict=True):
            state = state.beside(law, size)
        return self._chosen(model, current.laws, state.refitted() if directions else state)

    def _chosen(self, named: NamedModel | None, laws: tuple[int, ...], state: Present) -> Chosen:
        price = float(self.prices[list(laws)].sum())
        at = tuple(self.atoms[i].component for i in laws)
        if named is not None and self.names is not None:
            price += self.names.price_of(named.candidates)
            at = (*(effect.component for effect in named.effects), *at)
        nameless = any(self.atoms[i].entry is not None for i in laws)
        price += self.options.nameless * nameless
        return Chosen(named, laws, state, price, self.blocks, at, nameless, self._mistaken)

    def _price(self, index: int) -> float:
        """Log evidence that an entry has to bring beyond the alarm."""
        atom = self.atoms[index]
        if index < self._first:
            assert self.names is not None
            return self.names.price(_candidate(atom))
        of_each = atom.entry is not None and atom.component.several and atom.entry.blocks > 1
        return self._law + self.options.uncommon * (of_each + _wanders(atom))


def _candidate(atom: Atom) -> Candidate:
    """The named effect that an atom is one of the starts of."""
    assert atom.named is not None
    found: Candidate = atom.named[0]
    return found


def _start_of(state: Present, atom: Atom, directions: Callable[[], FloatArray], variance: float) -> FloatArray:
    """Parameters from which a named effect is fitted, where it is largest beside what is there, shape (p,)."""
    assert atom.named is not None
    candidate, start, units = atom.named
    free = np.array([not p.shape for p in candidate.effect.parameters])
    # A start away from neutral is one already.
    if not np.array_equal(start[free], candidate.effect.neutral()[free]):
        return np.asarray(start)
    moved: FloatArray = start.copy()
    moved[free] += units * state.beside(directions(), variance).weights[-atom.width :]
    return moved


def _wanders(atom: Atom) -> bool:
    """Whether an entry is a mount that moves whatever it carries."""
    if atom.entry is None or atom.entry.port not in ("base", "platform"):
        return False
    return atom.entry.form in ("twist", "jump") and atom.entry.inputs[0].kind in ("clock", "elapsed", "after")
