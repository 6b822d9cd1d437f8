"""Draw how the rooms hang together, from their imports: `python docs/structure.py`.

Writes docs/structure.svg, a dependency structure matrix: a mark in row A and column B says that A imports B, darker
where more modules do. Rooms stand in the order of the data flow, so that all marks lie below the diagonal; one above it
is an import against the flow, and is red. The table in docs/structure.md is made from the same imports.
"""

import ast
import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

DOCS = Path(__file__).parent
PAGE, DRAWING = DOCS / "structure.md", DOCS / "structure.svg"
SOURCES = DOCS.parent / "src"

ORDER = ("general", "io", "mechanics", "chain", "estimation", "planning", "diagnosis", "assurance", "report", "app")
"""The data flow: a package may import those before it. Others stand where their imports put them."""
_GENERAL = {file.stem for file in (SOURCES / "expdesign").glob("*.py")}
"""Modules without a room that say how things are written down; they are drawn as one, `general`."""
_CELL, _LEFT, _TOP = 22, 118, 118


@dataclass(frozen=True)
class Structure:
    """Packages in order, lines and modules of each, and how many modules of one import from another."""

    packages: list[str]
    modules: Counter[str]
    lines: Counter[str]
    imports: Counter[tuple[str, str]]

    @property
    def against(self) -> list[tuple[str, str]]:
        """Imports against the flow."""
        place = {name: index for index, name in enumerate(self.packages)}
        return sorted(pair for pair in self.imports if place[pair[0]] < place.get(pair[1], -1))


def structure(sources: Path = SOURCES) -> Structure:
    """What the modules below `sources`/expdesign import from each other."""
    root = sources / "expdesign"
    modules: Counter[str] = Counter()
    lines: Counter[str] = Counter()
    imports: Counter[tuple[str, str]] = Counter()
    for file in sorted(root.rglob("*.py")):
        if file.parent == root and file.stem in ("__init__", "__main__"):
            continue
        own = _package(file.relative_to(root).parts[0].removesuffix(".py"))
        text = file.read_text(encoding="utf-8")
        modules[own] += 1
        lines[own] += len(text.splitlines())
        for other in {_package(name) for name in _imported(ast.parse(text))} - {own}:
            imports[own, other] += 1
    return Structure(_in_order(set(modules), imports), modules, lines, imports)


def _package(name: str) -> str:
    return "general" if name in _GENERAL else name


def _imported(tree: ast.AST) -> set[str]:
    """First names below expdesign of everything imported, also inside functions."""
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("expdesign."):
            names.add(str(node.module).split(".")[1])
        elif isinstance(node, ast.ImportFrom) and node.module == "expdesign":
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Import):
            names |= {a.name.split(".")[1] for a in node.names if a.name.startswith("expdesign.")}
            # `import expdesign as xd` is for its functions, `import expdesign` for its version.
            names |= {"app" for a in node.names if a.name == "expdesign" and a.asname}
    return names


def _in_order(packages: set[str], imports: Counter[tuple[str, str]]) -> list[str]:
    order = [name for name in ORDER if name in packages]
    for name in sorted(packages - set(order)):
        after = [order.index(other) for other in order if (name, other) in imports]
        order.insert(max(after, default=-1) + 1, name)
    return order


def drawing(found: Structure) -> str:
    """The matrix as SVG."""
    count = len(found.packages)
    size = count * _CELL
    most = max(found.imports.values(), default=1)
    against = set(found.against)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_LEFT + size + 8} {_TOP + size + 8}" '
        f'font-family="sans-serif" font-size="12" role="img" aria-label="Imports between the packages">',
        f'<rect width="{_LEFT + size + 8}" height="{_TOP + size + 8}" fill="white"/>',
    ]
    for index, name in enumerate(found.packages):
        middle = index * _CELL + _CELL / 2
        x, y = _LEFT + index * _CELL, _TOP + index * _CELL
        parts += [
            f'<text x="{_LEFT - 6}" y="{_TOP + middle + 4}" text-anchor="end">{name}</text>',
            f'<text transform="translate({_LEFT + middle + 4},{_TOP - 6}) rotate(-90)">{name}</text>',
            f'<rect x="{x}" y="{y}" width="{_CELL}" height="{_CELL}" fill="#ccc"/>',
        ]
    place = {name: index for index, name in enumerate(found.packages)}
    for (importer, imported), number in sorted(found.imports.items()):
        colour = "#c0392b" if (importer, imported) in against else "#1f4e79"
        if imported not in place:
            continue
        x, y = _LEFT + place[imported] * _CELL, _TOP + place[importer] * _CELL
        parts.append(
            f'<rect x="{x + 2}" y="{y + 2}" width="{_CELL - 4}" height="{_CELL - 4}" fill="{colour}" '
            f'fill-opacity="{0.25 + 0.75 * (number / most) ** 0.5:.2f}">'
            f"<title>{importer} imports {imported} ({number})</title></rect>"
        )
    lines = [f'<rect x="{_LEFT}" y="{_TOP}" width="{size}" height="{size}" fill="none" stroke="#888"/>', "</svg>"]
    return "\n".join([*parts, *lines]) + "\n"


def table(found: Structure) -> str:
    """Packages with their size and what they import."""
    rows = ["| room | modules | lines | imports |", "| --- | --- | --- | --- |"]
    for name in found.packages:
        used = [other for other in found.packages if (name, other) in found.imports]
        rows.append(f"| `{name}` | {found.modules[name]} | {found.lines[name]} | {', '.join(used) or '–'} |")
    total = f"| all | {sum(found.modules.values())} | {sum(found.lines.values())} | |"
    return "\n".join([*rows, total]) + "\n"


def page(text: str, found: Structure) -> str:
    """The page with its table made anew."""
    return re.sub(
        r"(<!-- table -->\n).*?(<!-- end -->)",
        lambda match: f"{match[1]}\n{table(found)}\n{match[2]}",
        text,
        flags=re.DOTALL,
    )


if __name__ == "__main__":
    made = structure()
    DRAWING.write_text(drawing(made), encoding="utf-8")
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8"), made), encoding="utf-8")
    for pair in made.against:
        print("against the flow: {} imports {}".format(*pair))
