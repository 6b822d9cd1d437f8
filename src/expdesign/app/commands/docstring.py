"""What a docstring says, as the help of a command shows it."""

import inspect
import re
from dataclasses import dataclass, field

_SECTION = re.compile(r"^(Args|Returns|Raises|Example|Command):$", re.MULTILINE)
_ARGUMENT = re.compile(r"^    (\w+): ", re.MULTILINE)
_IN_PYTHON = " In Python "
"""What follows it in the text of an argument is not for the command line."""


@dataclass(frozen=True)
class Docstring:
    """A docstring of a function of the package, or of a part of a command.

    Attributes:
        description: paragraphs before the first section, the first of them one sentence.
        arguments: what each argument is, by its name.
        command: paragraphs about the command; the last is an example.
    """

    description: tuple[str, ...]
    arguments: dict[str, str] = field(default_factory=dict)
    command: tuple[str, ...] = ()

    @classmethod
    def of(cls, text: str | None) -> "Docstring":
        """The docstring in its parts, with paragraphs as single lines."""
        head, *rest = _SECTION.split(inspect.cleandoc(text or ""))
        sections = dict(zip(rest[::2], rest[1::2], strict=True))
        _, *named = _ARGUMENT.split(sections.get("Args", ""))
        arguments = {name: " ".join(text.split()) for name, text in zip(named[::2], named[1::2], strict=True)}
        return cls(_paragraphs(head), arguments, _paragraphs(sections.get("Command", "")))

    @property
    def help(self) -> str:
        """The help of a command: what it does, and an example."""
        *about, example = self.command or ("",)
        return "\n\n".join([*self.description, *about, *([f"Example: {example}"] if example else [])])

    def option(self, name: str) -> str:
        """The help of an option, as a sentence; empty where nothing is said of it."""
        text = self.arguments.get(name, "").partition(_IN_PYTHON)[0]
        return text[:1].upper() + text[1:]


def _paragraphs(text: str) -> tuple[str, ...]:
    return tuple(" ".join(part.split()) for part in text.split("\n\n") if part.strip())
