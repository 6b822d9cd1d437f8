"""What computed a result: the code that decides about the numbers, and the libraries that they depend on.

The number of a version says neither what a checkout with changes computed, nor that two versions compute the same. So
the modules from which a run's numbers come are found by following the imports of `app/api/run.py`, and what they do is
digested: their syntax trees without documentation, so that comments, sentences in docstrings and layout do not count.
Modules that only draw or write (`report`) are not among them.
"""

import ast
import hashlib
import json
import re
import sys
from collections.abc import Iterator
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from expdesign.plugins import extensions

LIBRARIES = ("autograd", "casadi", "moocore", "numpy", "pandas", "pymoo", "scipy")
"""On whose versions the numbers depend."""
ROOT = Path(__file__).parents[2]
_START = "expdesign.app.api.run"
_WITHOUT_NUMBERS = (
    "app.commands",
    "app.sweeps",
    "app.templates",
    "app.watching",
    "assurance.plausibility",
    "report",
)
"""Packages whose modules say, draw or carry what others compute."""
_SILENT = tuple(f"expdesign.{name}." for name in _WITHOUT_NUMBERS)
_PACKAGE = re.compile(r"expdesign(\.\w+)+")


@lru_cache(maxsize=1)
def computed_by() -> dict[str, str]:
    """Digest of the code (`code`), and versions of Python, the libraries and installed extensions, by their names."""
    found = {"code": code_digest(), "python": ".".join(map(str, sys.version_info[:2]))}
    for name in LIBRARIES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found | extensions()


def computed_by_text() -> str:
    """`computed_by` as one line, which is part of the identity of a run."""
    return json.dumps(computed_by(), sort_keys=True, separators=(",", ":"))


def code_digest(root: Path = ROOT) -> str:
    """Digest of the modules below `root` (the package's folder) from which the numbers of a run come."""
    digest = hashlib.sha256()
    for name, tree in sorted(_modules(root).items()):
        digest.update(f"{name}\n{ast.dump(_without_documentation(tree))}\n".encode())
    return digest.hexdigest()[:16]


def modules(root: Path = ROOT) -> list[str]:
    """Names of these modules."""
    return sorted(_modules(root))


def _modules(root: Path) -> dict[str, ast.Module]:
    found: dict[str, ast.Module] = {}
    waiting = [_START]
    while waiting:
        name = waiting.pop()
        file = _file(name, root)
        if file is None or name in found or f"{name}.".startswith(_SILENT):
            continue
        found[name] = ast.parse(file.read_text(encoding="utf-8"))
        waiting += _named(found[name], root)
    return found


def _named(tree: ast.Module, root: Path) -> Iterator[str]:
    """Modules that a module imports, and all modules of packages that it names as places of plugins."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("expdesign."):
            yield node.module
            yield from (f"{node.module}.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.startswith("expdesign."))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and _PACKAGE.fullmatch(node.value):
            folder = root.joinpath(*node.value.split(".")[1:])
            for file in folder.rglob("*.py") if folder.is_dir() else ():
                yield ".".join(["expdesign", *file.relative_to(root).with_suffix("").parts])


def _file(name: str, root: Path) -> Path | None:
    """The file of a module, which is a package's `__init__.py` where the module is a package."""
    place = root.joinpath(*name.split(".")[1:])
    files = (place.with_suffix(".py"), place / "__init__.py")
    return next((file for file in files if file.is_file()), None) if name != "expdesign" else None


def _without_documentation(tree: ast.Module) -> ast.Module:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [part for part in node.body if not _is_text(part)]
    return tree


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
