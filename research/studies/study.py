"""What a study is: tables that follow from a configuration, and figures and a page that follow from the tables.

The physics of a study comes from the other packages; its file only arranges it. The three steps are separate so that
what is kept can be checked: tables are made again and compared, figures and page are made again from the kept tables.

    class Sag(Study):
        '''Sag of a platform.'''

        title = "How far the platform sags"
        settings = SagSettings                                   # a StudySection with the study's own keys

        def tables(self, settings, document): ...                # the computation
        def figures(self, settings, tables): ...                 # matplotlib figures by name
        def page(self, settings, tables): ...                    # texts, tables and pictures in order

The name of a study is that of its module, with dashes; its configuration is `configs/studies/NAME.yaml`.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, ClassVar

import pandas as pd
from matplotlib.figure import Figure
from pydantic import Field

from expdesign.io.schema import Count, Section
from expdesign.io.yaml_reader import YamlDocument
from expdesign.plugins import implementations


class StudySection(Section):
    """Keys that the configurations of all studies share.

    Attributes:
        assumed: sentences that say which figures are assumed and where the others are from; the page shows them.
        samples: repetitions of every Monte-Carlo simulation.
        seed: of all random numbers.
    """

    assumed: Annotated[list[str], Field(min_length=1)] = Field(
        description="Sentences that say which figures are assumed and where the others come from; shown on the page."
    )
    samples: Count = Field(default=1, description="Repetitions of every Monte-Carlo simulation.")
    seed: Annotated[int, Field(strict=True, ge=0)] = Field(default=1, description="Seed of all random numbers.")


@dataclass(frozen=True)
class StudyTable:
    """One table of a study, kept as CSV.

    A column `X` with a companion `X_se`, its standard error, comes from random samples; every other column follows from
    the configuration alone, whatever the number of samples. A third column `X_predicted` says what theory predicts
    for it: tests hold every such pair within three standard errors.

    Attributes:
        frame: the rows; column names carry their units.
        digits: significant digits that are kept.
    """

    frame: pd.DataFrame
    digits: int = 6


@dataclass(frozen=True)
class Text:
    """A paragraph in Markdown, or a heading that starts with #."""

    text: str


@dataclass(frozen=True)
class Picture:
    """A figure by its name, and what is to be seen."""

    name: str
    caption: str


@dataclass(frozen=True)
class Shown:
    """A table as the page shows it: headings and cells."""

    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


Piece = Text | Picture | Shown
Tables = Mapping[str, pd.DataFrame]


class Study(ABC):
    """One study.

    Attributes:
        title: of its page.
        settings: what its configuration must say.
    """

    title: ClassVar[str]
    settings: ClassVar[type[StudySection]]

    @classmethod
    def name(cls) -> str:
        """The module's name with dashes."""
        return cls.__module__.rsplit(".", 1)[-1].replace("_", "-")

    @abstractmethod
    def tables(self, settings: Any, document: YamlDocument) -> dict[str, StudyTable]:
        """Every number of the study, by the name of the CSV file.

        Args:
            settings: the validated configuration.
            document: the same as it stands in the file; `document.where(key)` is what other readers want.
        """

    @abstractmethod
    def figures(self, settings: Any, tables: Tables) -> dict[str, Figure]:
        """Figures by name, from the tables as they are kept."""

    @abstractmethod
    def page(self, settings: Any, tables: Tables) -> list[Piece]:
        """The page below title, command and assumptions, from the tables as they are kept."""


@lru_cache(maxsize=1)
def known_studies() -> dict[str, Study]:
    """Every study by its name, in alphabetical order."""
    found = implementations("research.studies", Study)  # type: ignore[type-abstract]
    return {cls.name(): cls() for cls in sorted(found, key=lambda cls: cls.name())}
