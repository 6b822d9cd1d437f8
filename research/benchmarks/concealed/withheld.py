"""Diagnose with the library's entries for some physics taken out, in a process of its own.

`python -m research.benchmarks.concealed.withheld ROBOT RECORDINGS OUT physics ...`. This is the one place where the
program's option `without` (identifiers whose entries its library shall not offer) is used.
"""

from __future__ import annotations

import inspect
import sys
from importlib import import_module


def main() -> int:
    """Run one diagnosis; 2 where the program cannot leave physics out."""
    robot, recordings, out, *without = sys.argv[1:]
    program = import_module("expdesign")  # not at the top: nothing else here may import the program under test
    if "without" not in inspect.signature(program.diagnose).parameters:
        print("the program cannot take entries out of its library (diagnose has no `without`)", file=sys.stderr)
        return 2
    program.diagnose(robot, recordings, without=frozenset(without)).save(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
