"""What is kept under results/studies, and the problems of the configurations that it follows from."""

from pathlib import Path

import pandas as pd

from expdesign.planning.problem import DesignProblem
from expdesign.planning.problem_file import problem_from_document
from research.studies.making import prepare, read_frame

ROOT = Path(__file__).parents[3]
CONFIGURATIONS, KEPT = ROOT / "configs" / "studies", ROOT / "results" / "studies"


def kept_text(study: str, file: str) -> str:
    return (KEPT / study / file).read_text(encoding="utf-8")


def kept(study: str, table: str) -> pd.DataFrame:
    return read_frame(kept_text(study, f"{table}.csv"))


def problem_of(study: str) -> DesignProblem:
    return problem_from_document(prepare(study, CONFIGURATIONS).document.where("problem"))
