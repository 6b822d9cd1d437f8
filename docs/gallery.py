"""The gallery: runs its notebooks, keeps their outputs, and makes thumbnails and index.

    python docs/gallery.py              # all, then the index
    python docs/gallery.py worn-leg     # one

Also read by `docs/pages.py`, which makes a page of every notebook when the documentation is built.
"""

import base64
import re
import sys
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import nbformat

FOLDER = Path(__file__).parent / "gallery"
ORDER = (
    "which-instrument",
    "how-many-measurements",
    "from-box-to-certificate",
    "telescope-camera",
    "soft-platform",
    "worn-leg",
    "law-on-no-list",
    "arm-with-tracker",
    "arm-from-urdf",
    "soft-ground",
    "geometry-and-stiffness",
)
"""Of the index; a notebook that is not named here comes last."""
MOST_LINES = 60
_WIDTH, _COLOURS = 360, 48
_HEAD = """# Gallery

Each notebook answers one question of a laboratory in at most 60 lines of Python. Pictures need the extra `studies`;
`python docs/gallery.py` runs the notebooks again.
"""
_GRID = "display: grid; grid-template-columns: repeat(auto-fill, minmax(230px, 1fr)); gap: 1.5rem"


def notebooks() -> list[Path]:
    """Paths of the notebooks in the order of the index."""
    place = {name: number for number, name in enumerate(ORDER)}
    return sorted(FOLDER.glob("*.ipynb"), key=lambda path: (place.get(path.stem, len(ORDER)), path.stem))


def read(path: Path) -> Any:
    """A notebook."""
    return nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]


def executed(path: Path) -> Any:
    """The notebook with the outputs of a run, in which figures are drawn as small files."""
    import nbclient  # noqa: PLC0415 (not needed to read)

    notebook = read(path)
    drawing = "%config InlineBackend.figure_formats = ['png']\n%config InlineBackend.rc = {'figure.dpi': 100}\n"
    notebook.cells.insert(0, nbformat.v4.new_code_cell(drawing))  # type: ignore[no-untyped-call]
    folder = {"metadata": {"path": str(path.parent)}}
    nbclient.NotebookClient(notebook, timeout=600, kernel_name="python3", resources=folder).execute()
    notebook.cells.pop(0)
    for number, cell in enumerate((c for c in notebook.cells if c.cell_type == "code"), start=1):
        cell.execution_count = number
        cell.metadata.pop("execution", None)
        for output in cell.outputs:
            output.pop("execution_count", None)
            if output.output_type == "execute_result":
                output["execution_count"] = number
                output["data"] = {"text/plain": output["data"]["text/plain"]}
            elif "image/png" in output.get("data", {}):
                output["data"] = {"image/png": base64.b64encode(smaller(picture(output))).decode() + "\n"}
    return notebook


def picture(output: Any) -> bytes:
    """The bytes of an output's picture."""
    return base64.b64decode(output["data"]["image/png"])


def smaller(image: bytes, width: int | None = None) -> bytes:
    """A picture with few colours, scaled down to a width if there is one."""
    from PIL import Image  # noqa: PLC0415 (not needed to read)

    shown = Image.open(BytesIO(image)).convert("RGB")
    if width is not None and shown.width > width:
        shown = shown.resize((width, round(shown.height * width / shown.width)), Image.Resampling.LANCZOS)
    written = BytesIO()
    shown.quantize(_COLOURS).save(written, "PNG", optimize=True)
    return written.getvalue()


def picture_of(notebook: Any) -> bytes:
    """The notebook's one picture."""
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    (found,) = [picture(output) for output in outputs if "image/png" in output.get("data", {})]
    return found


def title_of(notebook: Any) -> tuple[str, str]:
    """The heading of a notebook and below it the first sentence that asks, or else the first."""
    heading, _, text = notebook.cells[0].source.partition("\n")
    sentences = re.split(r"(?<=[.?])\s", " ".join(text.split()))
    return heading.lstrip("# "), next((each for each in sentences if each.endswith("?")), sentences[0])


def page(notebook: Any, name: str) -> str:
    """A notebook as a page of the documentation; its picture is a file beside it."""
    parts = []
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(f"```python\n{cell.source}\n```")
        for output in cell.outputs:
            data = output.get("data", {})
            if "image/png" in data:
                parts.append(f"![{title_of(notebook)[0]}]({name}.png)")
            else:
                parts.append(f"```text\n{data.get('text/plain', output.get('text', ''))}\n```")
    parts.append(f"[The notebook]({name}.ipynb) · [Gallery](index.md)")
    return "\n\n".join(parts) + "\n"


def index() -> str:
    """The page with all thumbnails."""
    items = []
    for path in notebooks():
        title, sentence = title_of(read(path))
        link = f"{path.stem}.ipynb"
        items.append(
            f'<div markdown="1">\n\n[![{title}](thumbnails/{path.stem}.png)]({link})\n\n'
            f"**[{title}]({link})**\n\n{sentence}\n\n</div>"
        )
    return _HEAD + f'\n<div markdown="1" style="{_GRID}">\n\n' + "\n\n".join(items) + "\n\n</div>\n"


def main(names: Sequence[str]) -> None:
    """Run notebooks, then write thumbnails and index."""
    for path in notebooks():
        if names and path.stem not in names:
            continue
        notebook = executed(path)
        nbformat.write(notebook, path)  # type: ignore[no-untyped-call]
        thumbnail = FOLDER / "thumbnails" / f"{path.stem}.png"
        thumbnail.parent.mkdir(exist_ok=True)
        thumbnail.write_bytes(smaller(picture_of(notebook), _WIDTH))
        print(path.stem, flush=True)
    (FOLDER / "index.md").write_text(index(), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
