"""What `mkdocs.yml` cannot say: pages not named there come last, and links to the project's files are checked."""

import re
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError

ROOT = Path(__file__).parents[1]
_LINK = re.compile(r"\[([^\]]+)\]\((\.\./[^)#]+)\)")


def on_config(config: Any) -> Any:
    """A new page is one file: it need not be added to the list."""
    named = {page for entry in config.nav for page in entry.values()}
    config.nav += sorted(page.name for page in Path(config.docs_dir).glob("*.md") if page.name not in named)
    return config


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Files outside the documentation are no part of the built pages: they are named, and must exist."""

    def named(match: re.Match[str]) -> str:
        text, target = match.groups()
        path = (ROOT / "docs" / target).resolve()
        if not path.exists() or ROOT not in path.parents:
            raise PluginError(f"{page.file.src_path} links to {target}, which does not exist")
        name = str(path.relative_to(ROOT))
        return f"`{name}`" if text.strip("`") == name else f"{text} (`{name}`)"

    return _LINK.sub(named, markdown)
