"""The page of a study as Markdown."""

import textwrap
from collections.abc import Sequence

from research.studies.study import Picture, Piece, Shown, Study, StudySection, Text, known_studies

_WIDTH = 120


def page_text(study: Study, settings: StudySection, pieces: Sequence[Piece]) -> str:
    """Title, command, assumptions, then the pieces."""
    name = study.name()
    parts = [
        f"# {study.title}",
        f"```\npython -m research.studies {name}\n```",
        _wrapped(
            f"Made from [`configs/studies/{name}.yaml`](../../../configs/studies/{name}.yaml). "
            "The dimensions of the thesis are not public. Assumed here, or taken from where it says:"
        ),
        "\n".join(_item(sentence) for sentence in settings.assumed),
        *(_piece(piece) for piece in pieces),
    ]
    return "\n\n".join(parts) + "\n"


def index_text(scores: Sequence[float]) -> str:
    """The list of all studies; `scores` are the standard errors between every prediction and its Monte-Carlo."""
    parts = [
        "# Studies",
        "```\npython -m research.studies\n```",
        _wrapped(
            "What the thesis shows, computed again. Its dimensions are not public: every page says which figures are "
            "assumed. Each study is one file in `research/studies` and one configuration in `configs/studies`; "
            "its folder here holds the tables (CSV), the figures and a page."
        ),
        _wrapped(
            f"They compare {len(scores)} predictions with Monte-Carlo; the largest difference is "
            f"{max(map(abs, scores)):.2f} standard errors."
        ),
        "\n".join(f"- [{study.title}]({name})" for name, study in known_studies().items()),
    ]
    return "\n\n".join(parts) + "\n"


def _piece(piece: Piece) -> str:
    if isinstance(piece, Text):
        return piece.text if piece.text.startswith("#") else _wrapped(piece.text)
    if isinstance(piece, Picture):
        return f"![{piece.caption.splitlines()[0]}]({piece.name}.svg)\n\n" + _wrapped(f"*{piece.caption}*")
    return _table(piece)


def _table(table: Shown) -> str:
    rows = [table.columns, ["---"] * len(table.columns), *table.rows]
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def _wrapped(text: str) -> str:
    return "\n".join(textwrap.wrap(" ".join(text.split()), _WIDTH, break_long_words=False, break_on_hyphens=False))


def _item(sentence: str) -> str:
    lines = textwrap.wrap(" ".join(sentence.split()), _WIDTH - 2, break_long_words=False, break_on_hyphens=False)
    return "- " + "\n  ".join(lines)
