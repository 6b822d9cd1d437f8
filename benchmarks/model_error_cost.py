"""CPU time of a search with DUIR, FEIR and MEIR against one with the first two alone.

python benchmarks/model_error_cost.py configs/bipod.yaml configs/hexapod-h1.yaml
"""

import argparse
import time
from dataclasses import replace
from pathlib import Path

from expdesign.design.problem_file import problem_from_document
from expdesign.design.search import search
from expdesign.files.yaml_reader import read_yaml


def seconds(path: str, objectives: list[str]) -> float:
    """CPU time of reading and searching one configuration."""
    began = time.process_time()
    document = read_yaml(Path(path))
    search(problem_from_document(replace(document, content={**document.content, "objectives": objectives})))
    return time.process_time() - began


def main() -> None:
    """Print a row per configuration."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("configs", nargs="+")
    print("| configuration | two objectives (s) | three objectives (s) | ratio |\n| --- | --- | --- | --- |")
    for path in parser.parse_args().configs:
        two, three = (seconds(path, ["duir", "feir", *more]) for more in ([], ["meir"]))
        print(f"| {path} | {two:.1f} | {three:.1f} | {three / two:.1f} |", flush=True)


if __name__ == "__main__":
    main()
