"""The result of `expdesign compare` as a page of Markdown, with the command beside it.

expdesign compare configs/bipod.yaml configs/hexapod-h1.yaml --separate --samples 10000 --out results/compare
python -m benchmarks.compared_criteria results/compare
"""

import argparse
import csv
import textwrap
from pathlib import Path

from expdesign.io.output import write_file

COMMANDS = (__doc__ or "").split("\n\n")[1]
EXPLANATION = (
    "Every row is the best plan by one criterion alone, of all that was found: a search by every criterion, then a "
    "refinement along the gradient of each to a local optimum of it. In brackets: the criterion whose plan it is to "
    "the last measurement. Attained: RMS error at the targets after experiment, identification and exact compensation "
    "in 10 000 repetitions with noise and load errors drawn anew, in tolerances; ± is one standard error. Attained / "
    "best: how far from the best accuracy, with the standard error of the ratio (all designs meet the same draws). "
    "Rank correlation: Spearman's, of the criterion with the attained accuracy, over random designs, with its 95 % "
    "interval. The lower bound is on the criterion `total` of every plan with as many measurements (docs/theory.md, "
    "10)."
)
HEAD = ("plan by", "total (predicted)", "attained", "attained / best", "rank correlation")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    designs, correlations = rows_of(folder / "comparison.csv"), rows_of(folder / "correlation.csv")
    parts = ["# Which criterion's plan is accurate in the end", f"```\n{textwrap.dedent(COMMANDS).strip()}\n```"]
    parts.append("\n".join(textwrap.wrap(EXPLANATION, 120)))
    for name in dict.fromkeys(row["configuration"] for row in designs):
        here = [row for row in designs if row["configuration"] == name]
        over = {
            row["criterion"]: row
            for row in correlations
            if (row["configuration"], row["over"]) == (name, "random designs")
        }
        bound = float(here[0]["total_lower_bound"])
        gap = min(float(row["total"]) for row in here) / bound - 1.0
        said = f"Lower bound of `total`: {bound:.4f} tolerances; the best plan found is {gap:.1%} above it."
        parts.append(f"## {name}\n\n{table(here, over)}\n\n{said}")
    write_file(folder / "README.md", "\n\n".join(parts) + "\n")


def table(designs: list[dict[str, str]], over: dict[str, dict[str, str]]) -> str:
    """The designs of the criteria, best first, and the range of the random ones."""
    by_accuracy = sorted(designs, key=lambda row: float(row["attained"]))
    drawn = [row for row in by_accuracy if row["origin"] == "random"]
    labels = ((drawn[0], "best"), (drawn[len(drawn) // 2], "median"), (drawn[-1], "worst"))
    shown = [
        (row, f"`{row['design']}`" + (f" (plan of `{row['same_plan_as']}`)" if row["same_plan_as"] else ""))
        for row in by_accuracy
        if row["origin"] != "random"
    ]
    shown += [(row, f"{label} of {len(drawn)} random plans") for row, label in labels]
    lines = [f"| {' | '.join(HEAD)} |", "| --- | ---: | ---: | ---: | ---: |"]
    for row, label in shown:
        found = over.get(row["design"])
        correlation = "–"
        if found is not None:
            coefficient, low, high = (float(found[key]) for key in ("coefficient", "low", "high"))
            correlation = f"{coefficient:.2f} ({low:.2f} to {high:.2f})"
        attained = f"{float(row['attained']):.4f} ± {float(row['attained_standard_error']):.4f}"
        ratio = f"{float(row['attained_ratio']):.3f} ± {float(row['attained_ratio_standard_error']):.3f}"
        lines.append(f"| {label} | {float(row['total']):.4f} | {attained} | {ratio} | {correlation} |")
    return "\n".join(lines)


def rows_of(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


if __name__ == "__main__":
    main()
