"""`Form`: a variant of physics, as a law of single actuators (what an `Acting` one gains) or of the load.

The laws stand where the physics is (`effects`); those that several share in `play.py` and `memory.py`.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import casadi as ca

from expdesign.chain.declaration import Beyond, Parameter
from expdesign.chain.row import Row


@dataclass(frozen=True)
class Acting:
    """One of the actuators concerned, at a row.

    Attributes:
        index: which one.
        before: its force in the reference state (N or N·m).
        force: by which the load changes that.
        compliance: c (m/N or rad/(N·m)).
        elongation: what it has gained so far (m or rad).
        place: its commanded coordinate (m or rad).
        state: what it remembers of the row before, (`Form.memory`,).
        row: the row.
    """

    index: int
    before: ca.SX
    force: ca.SX
    compliance: ca.SX
    elongation: ca.SX
    place: ca.SX
    state: ca.SX
    row: Row


Law = Callable[[Acting, ca.SX], tuple[ca.SX, ca.SX]]
"""What an actuator gains (m or rad) and its next states, from what is known of it and parameters."""
LoadLaw = Callable[[ca.SX, Row, ca.SX], ca.SX]
"""The actual wrench (n,) from the assumed one, the row and parameters."""


@dataclass(frozen=True)
class Form:
    """A variant of physics: a law of single actuators or of the load, with everything that is the variant's own.

    Attributes:
        law: what each actuator gains.
        name: text of the variant in files, which tells it from others; empty for the only one.
        memory: states of one actuator.
        load: what the load is.
        parameters: with names as `Effect.quantities` has them; empty where those of the physics are its own.
        says: its sentence, where it is another one than that of the physics.
        called: name of the parametric form, where its physics has several (`Effect.form_name`).
        beyond: what it does beyond the recorded range, where that is not what its physics does.
    """

    law: Law | None = field(default=None, compare=False)
    name: str = ""
    memory: int = field(default=0, compare=False)
    parameters: tuple[Parameter, ...] = field(default=(), compare=False)
    says: str = field(default="", compare=False)
    called: str = field(default="", compare=False)
    beyond: Beyond | None = field(default=None, compare=False)
    load: LoadLaw | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return self.name


ONLY = Form()
"""The variant of an effect that has one form."""
