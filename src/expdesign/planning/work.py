"""What a search has done, counted so that it does not depend on the machine, and which operator to ask next.

Evaluations of designs, steps of descents and options of exchanges are counted at fixed rates in seconds of a processor,
fitted to searches of the shipped configurations on a server of 2026. Operators are asked by what they brought per
second of that (adaptive operator selection by adaptive pursuit of the best, Thierens, GECCO 2005), each at least every
so many generations.
"""

from dataclasses import dataclass, field

import numpy as np

EVALUATION, OPTION = 7.0e-5, 4.0e-7
"""s of evaluating a measurement of a design, and of an option of an exchange."""
STEP, VARIABLE, CUBE = 3.0e-4, 8.0e-6, 3.4e-10
"""s of a step of a descent, for a variable, and for the cube of their number (the factorisations of its programs)."""
CALL = 0.013
"""s of a generation, whatever its operator does."""


@dataclass
class Work:
    """Counted seconds."""

    seconds: float = 0.0

    def called(self) -> None:
        """An operator."""
        self.seconds += CALL

    def evaluated(self, designs: int, measurements: int) -> None:
        """So many designs of m measurements."""
        self.seconds += EVALUATION * designs * measurements

    def descended(self, steps: int, variables: int) -> None:
        """So many steps of single designs with n free variables."""
        self.seconds += steps * (STEP + VARIABLE * variables + CUBE * variables**3)

    def exchanged(self, options: int) -> None:
        """So many options were judged by their sums."""
        self.seconds += OPTION * options


@dataclass
class Credit:
    """What operators have brought per second of work, and which to ask.

    Attributes:
        count: number of operators.
        floor: generations after which each is asked again.
        memory: weight of the last gain in the average.
    """

    count: int
    floor: int
    memory: float
    rates: list[float] = field(default_factory=list)
    waiting: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.rates, self.waiting = [np.inf] * self.count, [0] * self.count

    def choose(self) -> int:
        """The operator to ask: one that waited too long, else the one that has brought most."""
        longest = int(np.argmax(self.waiting))
        chosen = longest if self.waiting[longest] >= max(self.floor, self.count) else int(np.argmax(self.rates))
        self.waiting = [0 if index == chosen else waited + 1 for index, waited in enumerate(self.waiting)]
        return chosen

    def learn(self, operator: int, gain: float, seconds: float) -> None:
        """What an operator brought for so much work."""
        rate, before = gain / seconds, self.rates[operator]
        mixed = self.memory * rate + (1.0 - self.memory) * before
        self.rates[operator] = rate if np.isinf(before) else mixed
