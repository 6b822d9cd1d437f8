"""What is known of a kind of physics before anything is measured: declared once, by the effect's class.

MEIR, diagnosis, `expdesign physics`, reports and the table in file-formats.md read it; there is no other list. An
effect that declares nothing works everywhere: it is called by its identifier, and is as large as its parameters'
typical sizes (`Parameter.scale`) say.

`Parameter` holds size, bounds and knowledge beforehand of a parameter of an effect or an instrument, `Variant` the form
of an effect: a closed set of names (a `StrEnum`), or a value with a text form of its own. An effect of one form has the
variant `form.ONLY`, whose text is empty. Variants with numbers in them (a range of poses, the size of a weight, another
leg) are frozen dataclasses whose `str` is what files hold, and which round their numbers to what that text says, so
that a file gives back the same physics to the last bit.
"""

from dataclasses import dataclass
from enum import StrEnum
from math import isfinite
from typing import Literal, Protocol, runtime_checkable


@dataclass(frozen=True)
class Parameter:
    """A parameter of an effect.

    Attributes:
        name: with its unit.
        scale: typical size, by which it is scaled in fits.
        neutral: value at which the effect vanishes (for a shape, a typical value).
        low, high: bounds.
        spread: standard deviation about `neutral` before anything is measured, infinite where nothing is known.
        shape: whether it only shapes the effect (a pitch, a time constant) and means nothing while the others are
            neutral.
    """

    name: str
    scale: float
    neutral: float = 0.0
    low: float = float("-inf")
    high: float = float("inf")
    shape: bool = False
    spread: float = float("inf")


@runtime_checkable
class Variant(Protocol):
    """Anything hashable with one text form."""

    def __str__(self) -> str: ...

    def __hash__(self) -> int: ...


def rounded(value: float) -> float:
    """A number as a variant's text gives it back (six digits)."""
    return float(f"{value:.6g}")


Of = Literal["", "actuator compliance", "pose compliance", "actuator force", "own deflection"]
"""What a size is a multiple of.

`""`: nothing, it is in the parameter's own unit. `actuator compliance`: the mean compliance of the actuators concerned.
`pose compliance`: √(D_ii·D_jj), D the compliance of the robot at the targets and i, j the axes of the parameter.
`actuator force`: the largest force in the actuators concerned at the targets. `own deflection`: the parameter at which
the effect moves the targets as much as the springs of the actuators concerned do.
"""
TYPICAL = "assumed: the typical size of the parameter"
"""Source of the size of a parameter of which its class declares none."""
LOOSELY = 10.0
"""Sizes that hold in a fit what the recordings do not determine (`Parameter.spread`): loosely, so that they do not pull
at what is determined."""

TEN_PERCENT = "assumed: a part that is meant to be rigid yields a tenth as much as the actuators together"
STRAIN_WAVE = "assumed: one minute of arc, the order that catalogues of strain-wave gears state for one turn"
IN_1000_S = "assumed: 1 K in 1000 s"


class Input(StrEnum):
    """On what physics depends, beside constants of the machine."""

    FORCE = "force"
    PLACE = "place"
    HISTORY = "history"
    TIME = "time"
    TEMPERATURE = "temperature"


class Beyond(StrEnum):
    """What a prediction does with physics where its inputs leave the recorded range.

    `goes on`: its form is mechanics, and holds with the same parameters. `holds`: it stays at its value at the nearest
    end of the recorded times and temperatures (`Effect.seen`).
    """

    GOES_ON = "goes on"
    HOLDS = "holds"


@dataclass(frozen=True)
class Size:
    """How large a parameter is on machines of this class: its standard deviation σ, and where that is from.

    Sizes that rest on no publication begin with `assumed`: they are to be replaced by what is known about the machine
    at hand (`model_error.sizes`).

    Attributes:
        parameter: names of parameters, with `*` for any characters.
        value: σ, in the parameter's unit or as a multiple.
        source: where the value is from.
        of: what it is a multiple of, where machines of all sizes agree better in a ratio than in an absolute figure.

    Raises:
        ValueError: the value is no positive number.
    """

    parameter: str
    value: float
    source: str
    of: Of = ""

    def __post_init__(self) -> None:
        if not (self.value > 0.0 and isfinite(self.value)):
            raise ValueError(f"`{self.parameter}` cannot have the prior size {self.value:g}")

    @property
    def assumed(self) -> bool:
        """Whether no publication states it."""
        return self.source.startswith("assumed")


@dataclass(frozen=True)
class Declaration:
    """What a class of effects says of its physics.

    Attributes:
        left_out: what the base model leaves out (file-formats.md, Identifiers of physics).
        phrase: a machine that has it, as the subject of a sentence; `{component}` stands for the place.
        usually: what usually behaves like that.
        port: where on the chain it acts, as laws without a name do (`ports/places`).
        form: name of its parametric form, where it has one or its variants say something else (`Effect.form_name`).
        laws: kinds of laws at its port (`ports.words.FORMS`) that are this physics in a form of their own.
        inputs: on what it depends.
        beyond: what it does beyond the recorded range.
        linear: whether what it does is nearly proportional to its parameters, so that small errors of many parts add up
            and can be weighed as one group.
        sizes: of its parameters; the first whose names fit counts.
    """

    left_out: str = ""
    phrase: str = ""
    usually: str = ""
    port: str = ""
    form: str = "linear"
    laws: tuple[str, ...] = ()
    inputs: tuple[Input, ...] = ()
    beyond: Beyond = Beyond.GOES_ON
    linear: bool = True
    sizes: tuple[Size, ...] = ()
