"""Citations resolve to documents and headings, and data flow in one direction, as docs/structure.md shows."""

import re
from collections import defaultdict
from pathlib import Path

from tests.docs.test_tutorial import loaded

ROOT = Path(__file__).parents[2]


CODE = sorted(
    file
    for folder in ("src", "tests", "docs", "research")
    for file in (ROOT / folder).rglob("*.py")
    if file.resolve() != Path(__file__).resolve()
)


THEORY = (ROOT / "docs/theory.md").read_text(encoding="utf-8")


FORMATS = (ROOT / "docs/file-formats.md").read_text(encoding="utf-8")


_TOKEN = r"(?:[0-9]+(?:\.[0-9A-I]+)*|C[0-9]+)"


_BETWEEN = r"(?:, | and | to |[-–])"


THEORY_CITATION = re.compile(rf"theory\.md,?(?:\s+sections?)?\s+({_TOKEN}(?:{_BETWEEN}{_TOKEN})*)")


FORMATS_CITATION = re.compile(r"file-formats\.md, ([^\n;)]+)")


DOCUMENT = re.compile(r"(?<![\w/.{}-])(?:docs/)?([a-z][a-z-]*\.md)\b")


def theory_sections() -> set[str]:
    """`2`, `2.3`, `9.H` of the headings, and the checks `C1` ... of the table in section 11."""
    headings = re.findall(r"^#{2,3} ([0-9]+(?:\.[0-9A-I]+)?)\.? ", THEORY, flags=re.MULTILINE)
    checks = re.findall(r"^\| (C[0-9]+) \|", THEORY, flags=re.MULTILINE)
    return {*headings, *checks}


def formats_headings() -> list[str]:
    return re.findall(r"^#{2,3} (.+)$", FORMATS, flags=re.MULTILINE)


def sections_cited(text: str) -> list[str]:
    """Every section that a text cites; the ends of ranges stand for them, as does `2.2-3` for 2.2 and 2.3."""
    found = []
    for match in THEORY_CITATION.finditer(text):
        above = ""
        for separator, token in re.findall(rf"({_BETWEEN}|)({_TOKEN})", match[1]):
            short = separator in ("-", "–") and "." in above and "." not in token and token.isdigit()
            found.append(f"{above.split('.', maxsplit=1)[0]}.{token}" if short else token)
            above = token
    return found


def test_sections_of_the_theory_exist() -> None:
    known = theory_sections()
    assert {"1", "2.3", "9.H", "10.5", "C16"} <= known
    cited = [(file, section) for file in CODE for section in sections_cited(file.read_text(encoding="utf-8"))]
    assert len(cited) > 100
    assert not [(str(file.relative_to(ROOT)), section) for file, section in cited if section not in known]


def test_headings_of_the_file_formats_exist() -> None:
    known = formats_headings()
    cited = [
        (str(file.relative_to(ROOT)), heading)
        for file in CODE
        for heading in FORMATS_CITATION.findall(file.read_text(encoding="utf-8"))
    ]
    assert len(cited) > 10
    assert not [(file, heading) for file, heading in cited if not heading.startswith(tuple(known))]


def test_documents_exist() -> None:
    """In the package: benchmarks and tests also name files that they write."""
    documents = {file.name for folder in ("", "docs") for file in (ROOT / folder).glob("*.md")}
    missing = [
        (str(file.relative_to(ROOT)), name)
        for file in CODE
        if file.is_relative_to(ROOT / "src")
        for name in DOCUMENT.findall(file.read_text(encoding="utf-8"))
        if name not in documents
    ]
    assert not missing


SCRIPT = loaded("structure")


def test_nothing_is_imported_against_the_flow() -> None:
    found = SCRIPT.structure()
    assert tuple(found.packages) == SCRIPT.ORDER
    assert found.against == []


def test_a_class_name_stands_for_one_thing() -> None:
    """Except what configurations and robot files say, as objects of the API."""
    found = defaultdict(set)
    for path in (ROOT / "src" / "expdesign").rglob("*.py"):
        for name in re.findall(r"^ *class (\w+)", path.read_text(encoding="utf-8"), flags=re.MULTILINE):
            if path.name != "objects.py":
                found[name].add(path)
    assert {name: paths for name, paths in found.items() if len(paths) > 1} == {}
