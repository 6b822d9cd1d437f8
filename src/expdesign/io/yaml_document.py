"""The content of a YAML file, with the line on which every key stands."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

KeyPath = tuple[str | int, ...]


@dataclass(frozen=True)
class YamlDocument:
    """The content of a YAML file.

    Attributes:
        source: name of the file, for messages.
        folder: what relative paths inside the document are relative to.
        content: plain Python data.
        lines: line number (from 1) of each key path.
        prefix: key path of `content` inside the file, where it is a part of it.
    """

    source: str
    folder: Path
    content: Any
    lines: dict[KeyPath, int] = field(default_factory=dict)
    prefix: KeyPath = ()

    def where(self, path: KeyPath = ()) -> str:
        """File, line and key of `path`, as a person would look it up."""
        full = self.prefix + path
        known = full
        while known and known not in self.lines:
            known = known[:-1]
        place = f"{self.source}, line {self.lines[known]}" if known in self.lines else self.source
        return f"{place}, {dotted(full)}" if full else place

    def part(self, *path: str | int) -> "YamlDocument":
        """The document below `path`, which must exist."""
        content = self.content
        for key in path:
            content = content[key]
        return YamlDocument(self.source, self.folder, content, self.lines, self.prefix + path)


def dotted(path: KeyPath) -> str:
    """`("targets", 0, "pose")` as `targets[0].pose`."""
    text = ""
    for key in path:
        text += f"[{key}]" if isinstance(key, int) else (f".{key}" if text else key)
    return text
