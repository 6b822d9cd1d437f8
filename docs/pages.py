"""What `mkdocs.yml` cannot say: pages not named there come last, notebooks of the gallery become pages, and links to
the project's files are checked.
"""

import importlib.util
import re
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File

ROOT = Path(__file__).parents[1]
_LINK = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+[^)#]+)\)")
_NOTEBOOK = re.compile(r"\]\(([\w-]+)\.ipynb\)")
_GALLERY = "gallery/index.md"


def on_config(config: Any) -> Any:
    """A new page is one file: it need not be added to the list."""
    named = set(_named(config.nav))
    more = sorted(page.name for page in Path(config.docs_dir).glob("*.md") if page.name not in named)
    if more:
        config.nav.append({"More": more})
    return config


def _named(entries: list[dict[str, Any]]) -> Iterator[str]:
    """Pages in the list and in its sections."""
    for entry in entries:
        for page in entry.values():
            if isinstance(page, str):
                yield page
            else:
                yield from _named(page)


def on_files(files: Any, config: Any) -> Any:
    """Every notebook of the gallery is a page as well, with its picture beside it."""
    gallery = _gallery()
    for path in gallery.notebooks():
        notebook = gallery.read(path)
        text, picture = gallery.page(notebook, path.stem), gallery.picture_of(notebook)
        files.append(File.generated(config, f"gallery/{path.stem}.md", content=text))
        files.append(File.generated(config, f"gallery/{path.stem}.png", content=picture))
    return files


def _gallery() -> ModuleType:
    """`gallery.py`, which stands beside this file in no package."""
    spec = importlib.util.spec_from_file_location("gallery", Path(__file__).with_name("gallery.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Files outside the documentation are no part of the built pages: they are named, and must exist."""
    if page.file.src_uri == _GALLERY:
        markdown = _NOTEBOOK.sub(r"](\1.md)", markdown)

    def named(match: re.Match[str]) -> str:
        text, target = match.groups()
        path = (ROOT / "docs" / Path(page.file.src_uri).parent / target).resolve()
        if not path.exists() or ROOT not in path.parents:
            raise PluginError(f"{page.file.src_path} links to {target}, which does not exist")
        if ROOT / "docs" in path.parents:
            return match.group()
        name = str(path.relative_to(ROOT))
        return f"`{name}`" if text.strip("`") == name else f"{text} (`{name}`)"

    return _LINK.sub(named, markdown)
