"""`python -m research.studies [NAME ...]`: studies of the thesis, made again from their configurations."""

import argparse
import sys
import time
from pathlib import Path

from expdesign.errors import ExpdesignError
from research.studies.making import make, prepare, require_free_study, write_index
from research.studies.study import known_studies


def main(arguments: list[str] | None = None) -> int:
    """Make the studies named, or all; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m research.studies", description="Make studies of the thesis again.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(known_studies())}; all if left out")
    parser.add_argument("--out", type=Path, default=Path("results/studies"), help="folder for the results")
    parser.add_argument("--configurations", type=Path, default=Path("configs/studies"), help="folder with them")
    parser.add_argument("--force", action="store_true", help="replace files that are there for another purpose")
    given = parser.parse_args(arguments)
    try:
        _make(given.names or list(known_studies()), given.configurations, given.out, force=given.force)
    except ExpdesignError as error:
        print(f"studies: {error.message}", file=sys.stderr)
        return 2
    return 0


def _make(names: list[str], configurations: Path, out: Path, *, force: bool) -> None:
    for name in names:  # what is wrong with any of them is said before the work
        prepare(name, configurations)
        require_free_study(name, configurations, out, force=force)
    for name in names:
        started = time.monotonic()
        make(name, configurations, out, force=force)
        print(f"{name}: {time.monotonic() - started:.1f} s", file=sys.stderr)
        print(out / name / "README.md")
    if all((out / name / "study.json").is_file() for name in known_studies()):
        write_index(out, force=force)


if __name__ == "__main__":
    sys.exit(main())
