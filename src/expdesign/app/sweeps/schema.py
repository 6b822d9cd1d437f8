"""The sweep as it stands in YAML: a configuration, and which of its keys take which values.

schema_version: 1
config: hexapod-h1.yaml
vary:                                        # every combination of these (a grid)
  experiment.measurements: [4, 6, 8]
  optimiser.seed: {from: 1, to: 5}
cases:                                       # and of these, each a set of values that belong together
  - {robot: robots/hexapod-h1.yaml, experiment.load.mass_kg: 26.5}
  - {robot: robots/other.yaml, experiment.load.mass_kg: 40}
"""

from typing import Annotated, Any, Literal, Self

from pydantic import Discriminator, Field, Tag, model_validator

from expdesign.io.schema import LARGEST_COUNT, Count, Section, invalid


class RangeSection(Section):
    """`vary.KEY` as a range of whole numbers, both ends included."""

    first: int = Field(alias="from", strict=True, description="First number.")
    last: int = Field(alias="to", strict=True, description="Last number; it is included where the steps meet it.")
    step: Count = Field(default=1, description="Step from one number to the next.")

    @model_validator(mode="after")
    def _not_empty(self) -> Self:
        if self.last < self.first:
            raise invalid(f"the range from {self.first} to {self.last} is empty", remedy="Swap them.")
        if (self.last - self.first) // self.step >= LARGEST_COUNT:
            raise invalid("the range has too many values", remedy=f"At most {LARGEST_COUNT}.")
        return self

    def values(self) -> list[int]:
        """The numbers."""
        return list(range(self.first, self.last + 1, self.step))


def _form(value: Any) -> str:
    return "range" if isinstance(value, dict | RangeSection) else "list"


Values = Annotated[Annotated[list[Any], Tag("list")] | Annotated[RangeSection, Tag("range")], Discriminator(_form)]
"""Values as a list or as a range, distinguished by their brackets, so that messages fit the form that was meant."""


class SweepSection(Section):
    """A sweep."""

    schema_version: Literal[1] = Field(description="Version of this format.")
    config: str | dict[str, Any] = Field(
        description="The run configuration that is varied: a file (the path is relative to the sweep), or its mapping."
    )
    vary: dict[str, Values] = Field(
        default_factory=dict,
        description="Keys of the configuration, written with dots (`experiment.measurements`), and their values: a "
        "list, or a range `{from: 1, to: 5, step: 1}` of whole numbers. Every combination is run. Default: "
        "nothing varies.",
    )
    cases: list[dict[str, Any]] = Field(
        default_factory=list,
        description="Sets of values that belong together, each a mapping of keys with dots to values; every case is "
        "run with every combination of `vary`. Default: one case, the configuration as it is.",
    )

    @model_validator(mode="after")
    def _something(self) -> Self:
        for key, values in self.vary.items():
            if isinstance(values, list) and not values:
                raise invalid("there is no value", f"vary.{key}", "Name at least one.")
        if not self.vary and not self.cases:
            raise invalid("nothing varies", remedy="Name a key under `vary`, or a case under `cases`.")
        return self
