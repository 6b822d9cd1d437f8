"""The pages stay short enough to be read: what stands on one of them stands on no other, and the sum is bounded."""

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
MOST = 27_000
"""Words of all pages, outside of blocks of code (which tests execute)."""
LONG = 10
"""Words of a sentence from which on two alike are one statement in two places."""
_CODE = re.compile(r"^```.*?^```", flags=re.DOTALL | re.MULTILINE)
_LETTER = re.compile(r"[^\W\d_]")


def prose(page: Path) -> str:
    """The text of a page without its blocks of code."""
    return _CODE.sub("", page.read_text(encoding="utf-8"))


def words(text: str) -> list[str]:
    """What has a letter; marks of tables and numbers are no words."""
    return [each for each in text.split() if _LETTER.search(each)]


def sentences(page: Path) -> Iterator[str]:
    """Long sentences outside of tables and code."""
    lines = (line for line in prose(page).splitlines() if not line.startswith(("|", "#", "    ")))
    for paragraph in "\n".join(lines).split("\n\n"):
        for sentence in re.split(r"(?<=[.:;])\s", " ".join(paragraph.split())):
            if len(words(sentence)) >= LONG:
                yield sentence


def test_the_pages_together_are_not_too_long() -> None:
    assert sum(len(words(prose(page))) for page in PAGES) < MOST


def test_no_sentence_stands_on_two_pages() -> None:
    found = Counter(sentence for page in PAGES for sentence in set(sentences(page)))
    assert sum(found.values()) > 500
    assert [sentence for sentence, count in found.items() if count > 1] == []
