"""All benchmarks of the design search, one after the other: `python -m benchmarks.optimality.run_all`.

Takes about twenty minutes of processor time; each is a process of its own, and each can be run alone. FIGAROH is
compared where `--figaroh` names an interpreter that has it.
"""

import argparse
import subprocess
import sys


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figaroh", default=sys.executable, help="Python interpreter with FIGAROH installed")
    arguments = parser.parse_args()
    for module, options in (
        ("benchmarks.optimality.hypervolume", ["plain"]),
        ("benchmarks.optimality.hypervolume", ["script"]),
        ("benchmarks.optimality.against_figaroh", ["--python", arguments.figaroh]),
        ("benchmarks.optimality.differential_evolution", []),
        ("benchmarks.optimality.bounds", []),
        ("benchmarks.optimality.scale", []),
        ("benchmarks.evaluation", ["--results", "results/benchmarks"]),
    ):
        subprocess.run([sys.executable, "-m", module, *options], check=True)


if __name__ == "__main__":
    main()
