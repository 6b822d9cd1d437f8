"""`python -m research.benchmarks.page NAME [--first]`: commands of `results/NAME.md` are carried out."""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_FIRST = re.compile(r"^```\n(.*?)\n```$", re.DOTALL | re.MULTILINE)


def pages() -> dict[str, Path]:
    """The pages of results by their names."""
    found = {path.stem: path for path in (ROOT / "results").glob("*.md")}
    found["studies"] = ROOT / "results" / "studies" / "README.md"
    return {name: path for name, path in sorted(found.items()) if name != "README"}


def commands(page: Path) -> list[str]:
    """The commands that make a page."""
    match = _FIRST.search(page.read_text(encoding="utf-8"))
    return [] if match is None else match[1].splitlines()


def main(names: list[str]) -> int:
    """Carry out the commands of pages, or their first ones, in the project's folder; the status of one that fails."""
    known, most = pages(), 1 if "--first" in names else None
    names = [name for name in names if name != "--first"]
    if not names or not set(names) <= set(known):
        print(f"name one of {', '.join(known)}", file=sys.stderr)
        return 2
    here = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for command in (line for name in names for line in commands(known[name])[:most]):
        print(command, file=sys.stderr, flush=True)
        done = subprocess.run(command, shell=True, cwd=ROOT, env=here, check=False)
        if done.returncode != 0:
            return done.returncode
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
