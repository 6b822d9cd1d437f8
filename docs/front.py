"""Draw the front of a finished run as a picture: `python docs/front.py RUN_FOLDER PICTURE.svg`."""

import sys
from pathlib import Path

import matplotlib as mpl
import matplotlib.pyplot as plt
import pandas as pd


def main(folder: Path, picture: Path) -> None:
    """Draw `folder/pareto.csv`."""
    mpl.rcParams["svg.hashsalt"] = "front"
    front = pd.read_csv(folder / "pareto.csv")
    figure, axes = plt.subplots(figsize=(6.4, 3.6))
    axes.plot(front["duir"], front["feir"], "o", markersize=4, color="#1f5fa8", label="designs")
    for mark, label, symbol in (("recommended", "recommended: least total", "*"), ("knee", "knee", "D")):
        row = front[front[mark]].iloc[0]
        axes.plot(row["duir"], row["feir"], symbol, markersize=12 if symbol == "*" else 7, label=label)
    axes.set_xlabel("DUIR: error from measurement noise, in tolerances")
    axes.set_ylabel("FEIR: error from load errors,\nin tolerances")
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    figure.tight_layout()
    figure.savefig(picture, metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
