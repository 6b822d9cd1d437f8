"""Practice on physics that no list holds: `python -m benchmarks.ports.practice --count 36 --seed 1 --out FILE`.

Cases are made from `practice_physics` on linear maps, of the size 2 to 10 standard deviations that a base fit leaves,
and diagnosed in this process. One JSON line a case says what was asked and answered, with the log evidence of every
component, from which `benchmarks.ports.calibration --from FILE` fits the temperature. These cases serve to develop and
to calibrate; rates are reported from another generator (`benchmarks/concealed`).
"""

import argparse
import json
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import yaml
from benchmarks.concealed.experiments import Experiment, draw_interleaved
from benchmarks.concealed.generate import generate
from benchmarks.concealed.linear_model import Array, BaseFit
from benchmarks.concealed.robots import HEXAPODS, bipod
from benchmarks.ports.practice_physics import KINDS, Kind, Rows

from expdesign.app.api.inputs import robot_of, table_of
from expdesign.app.api.recorded import recordings_of
from expdesign.chain.recordings.reader import points_from_table
from expdesign.chain.row import row_data
from expdesign.diagnosis.diagnose import diagnose
from expdesign.diagnosis.library import OUTLIER, library
from expdesign.diagnosis.result import Diagnosis
from expdesign.report.diagnosis_record import diagnosis_record
from virtual_laboratory.recordings import deflection_columns, std_columns

DEFLECTIONS = ("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad")
STDS = ("sx_m", "sy_m", "sz_m", "srx_rad", "sry_rad", "srz_rad")
LEAST, MOST, MOST_OF_TWO = 2.0, 10.0, 7.0
"""Standard deviations that a base fit leaves of one kind, and the most of each of two."""


@dataclass(frozen=True)
class Question:
    """One case.

    Attributes:
        name, kinds, accepted, allowed: what it is, accepted components, and listed physics that is no wrong name.
        robot: the robot file's mapping.
        recordings, later: tables; `later` without deflections, `truth` (M × k) is what they are without noise, `std` of
            the noise (k,).
        base: RMS that the base model misses the later rows by, in standard deviations; NaN where it is not known.
        without: listed physics that is withheld from the program.
        noise: RMS of the noise of `truth`, in standard deviations.
    """

    name: str
    kinds: tuple[str, ...]
    accepted: frozenset[str]
    allowed: frozenset[str]
    robot: dict[str, object]
    recordings: pd.DataFrame
    later: pd.DataFrame
    truth: Array
    std: Array
    base: float
    without: frozenset[str] = frozenset()
    noise: float = 0.0


def questions(count: int, seed: int, only: str = "") -> Iterator[Question]:
    """Cases: kinds in turn, every fourth a pair, every tenth consistent."""
    order = np.random.default_rng([seed, 0])
    kinds = [kind for kind in KINDS if only in kind.name]
    turn: list[Kind] = []
    for number in range(count):
        if not turn:
            turn = [kinds[i] for i in order.permutation(len(kinds))]
        chosen = [turn.pop()]
        if not only and number % 4 == 3:
            chosen.append(kinds[int(order.integers(len(kinds)))])
        if not only and number % 10 == 9:
            chosen = []
        yield _question(f"{seed}-{number:03d}", chosen, np.random.default_rng([seed, 1, number]))


def withheld(count: int, seed: int, only: str = "") -> Iterator[Question]:
    """Listed physics, one effect a case, withheld from the program: cases of `benchmarks.concealed`."""
    for case in generate(count, seed, [only or "one"], 1):
        (effect,) = case.truth["effects"]
        std = case.later[[name for name in case.later if name in STDS]].to_numpy(dtype=float)[0]
        measured = [name for name in case.later if name in DEFLECTIONS]
        accepted = {name for one in effect["components"] for name in ([one] if isinstance(one, str) else one)}
        yield Question(
            f"{seed}-{case.truth['case']}", (effect["physics"],), frozenset(accepted), frozenset(), case.robot,
            case.recordings, case.later.drop(columns=[*measured, *(n for n in case.later if n in STDS)]),
            case.later[measured].to_numpy(dtype=float), std, float("nan"), frozenset({effect["physics"]}),
            case.truth["later_noise_rms"],
        )  # fmt: skip


def _question(name: str, kinds: list[Kind], rng: np.random.Generator) -> Question:
    for _ in range(200):
        found = _attempt(name, kinds, rng)
        if found is not None:
            return found
    raise RuntimeError(f"{name}: {[kind.name for kind in kinds]} cannot be made to show")


def _attempt(name: str, kinds: list[Kind], rng: np.random.Generator) -> Question | None:
    planar = all(kind.planar for kind in kinds) and rng.random() < 0.15
    machine = bipod(rng) if planar else HEXAPODS[str(rng.choice(list(HEXAPODS)))](rng)
    wishes = KINDS[int(rng.integers(len(KINDS)))].wishes if not kinds else kinds[0].wishes
    for kind in kinds[1:]:
        if not wishes.compatible(kind.wishes):
            return None
        wishes = wishes | kind.wishes
    experiment = draw_interleaved(machine, wishes, rng)
    rows = Rows(experiment)
    seen = np.isin(np.arange(1, len(rows.pose) + 1), experiment.rows["sequence"])
    std, axes = experiment.std[experiment.measured], experiment.measured
    fit = BaseFit(machine.robot, experiment.rows, std, axes, experiment.fitted)
    if fit.condition > 60.0:
        return None
    deflections, accepted, allowed = rows.own, set(), set()
    for kind in kinds:
        components, change = kind.make(rows, rng)
        shows = fit.residual(change[seen])
        size = float(np.sqrt((shows**2).mean()))
        if not np.isfinite(change).all() or size <= 0.0 or size < 0.02 * _rms((change / experiment.std)[:, axes]):
            return None
        most = MOST if len(kinds) == 1 else MOST_OF_TWO
        deflections = deflections + change * float(np.exp(rng.uniform(np.log(LEAST), np.log(most)))) / size
        accepted |= set(components)
        allowed |= set(kind.names)
    noisy = deflections + rng.standard_normal(deflections.shape) * experiment.std
    recordings = _written(experiment, experiment.rows, noisy[seen])
    later = experiment.later.reset_index(drop=True)
    truth = deflections[~seen][:, axes]
    miss = _base_miss(fit, experiment, rows, noisy[seen], deflections, seen)
    return Question(
        name, tuple(kind.name for kind in kinds), frozenset(accepted), frozenset(allowed), machine.file(), recordings,
        later, truth, std, miss,
    )  # fmt: skip


def _base_miss(fit: BaseFit, experiment: Experiment, rows: Rows, noisy: Array, truth: Array, seen: np.ndarray) -> float:
    """RMS by which the base model misses the later rows."""
    axes, std = experiment.measured, experiment.std
    columns = rows.map * rows.force[:, None, :] / std[:, None]
    left = columns[seen][experiment.fitted][:, axes].reshape(-1, columns.shape[2])
    right = (noisy / std)[experiment.fitted][:, axes].ravel()
    compliance = np.linalg.lstsq(left, right, rcond=None)[0]
    return _rms((columns[~seen] @ compliance - truth[~seen] / std)[:, axes])


def _written(experiment: Experiment, rows: pd.DataFrame, deflections: Array) -> pd.DataFrame:
    robot = experiment.machine.robot
    table = rows.copy()
    for axis in experiment.measured:
        table[deflection_columns(robot)[axis]] = [float(f"{v:.6g}") for v in deflections[:, axis]]
        table[std_columns(robot)[axis]] = experiment.std[axis]
    return table


def answer(question: Question, scratch: Path, *, nameless: bool = False) -> dict[str, object]:
    """What the program says, judged; `nameless` without any listed physics, which takes a third of the time."""
    file = scratch / f"{question.name}.yaml"
    file.write_text(yaml.safe_dump(question.robot), encoding="utf-8")
    machine = robot_of(file)
    started = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        recordings = recordings_of(question.recordings, machine)
        every = frozenset(effect.physics for effect in library(machine.robot, recordings)) | {OUTLIER}
        found = diagnose(machine.robot, recordings, without=every if nameless else question.without)
        record = diagnosis_record(found, None)
        seconds = time.process_time() - started
        predicted, deviations = predicted_of(found, question, machine.robot)
    miss = (predicted - question.truth) / question.std
    first = _first(record)
    names = [
        e["physics"] for e in record["effects"]
        if e["physics"] not in ("law", "outlier") and e["probability"] > 0.5 and e["physics"] not in question.allowed
    ]  # fmt: skip
    laws = found.laws
    evidence = [] if laws is None else [[str(p.component), p.log_evidence, p.probability] for p in laws.parts[0].places]
    return {
        "case": question.name,
        "kinds": question.kinds,
        "accepted": sorted(question.accepted),
        "rows": len(question.recordings),
        "verdict": found.verdict,
        "first": first,
        "located": first in question.accepted,
        "probability": _probability(record, first),
        "wrong_names": names,
        "base": question.base,
        "model": float(np.sqrt(max(_rms(miss) ** 2 - question.noise**2, 0.0))),
        "worse": bool(_rms(miss, 1.0) > 1.02 * np.sqrt(question.base**2 + 1.0)),
        "covered": float((np.abs(miss) < 1.96 * np.hypot(deviations / question.std, question.noise)).mean()),
        "seconds": seconds,
        "effects": [
            [e["physics"], e["component"], e["variant"], e.get("depends_on"), round(e["probability"], 3)]
            for e in record["effects"]
        ],
        "said": [e["reason"] for e in found.names.log.entries if e["step"] in ("laws", "verdict", "held out")],
        "left_out": None if laws is None else [laws.before, laws.after, laws.left_out.better, laws.left_out.p_value],
        "evidence": evidence,
    }  # fmt: skip


def predicted_of(found: Diagnosis, question: Question, robot: object) -> tuple[Array, Array]:
    """Predicted deflections of the later rows and their standard deviations, measured axes only."""
    points = points_from_table(table_of(question.later, "later"), robot)  # type: ignore[arg-type]
    fit = found.predictive.fit
    values, sensitivities = fit.chain.predict_with_sensitivities(row_data(points, robot), fit.values)  # type: ignore[arg-type]
    known = np.isfinite(fit.covariance.diagonal())
    inner = fit.covariance[np.ix_(known, known)]
    s = sensitivities[..., known]
    deviations: Array = np.sqrt(np.einsum("nkp,pq,nkq->nk", s, inner, s))
    shown = DEFLECTIONS[:2] if question.robot.get("kind") == "bipod" else DEFLECTIONS
    axes = [i for i, name in enumerate(shown) if name in question.recordings]
    inverse = np.argsort(points.lines, kind="stable")
    return np.asarray(values[inverse][:, axes]), deviations[inverse][:, axes]


def _first(record: dict) -> str:  # type: ignore[type-arg]
    location = record["location"]
    if location is None:
        return ""
    named = location["component"]
    return str(named if isinstance(named, str) else named[0])


def _probability(record: dict, first: str) -> float | None:  # type: ignore[type-arg]
    location = record["location"]
    for candidate in [] if location is None else location["candidates"]:
        if candidate["component"] == first:
            return float(candidate["probability"])
    return None


def _rms(values: Array, noise: float = 0.0) -> float:
    return float(np.sqrt((values**2).mean() + noise**2))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=36)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="part of a kind's name")
    parser.add_argument("--out", type=Path, required=True, help="JSON lines; cases that are in it are not asked again")
    parser.add_argument("--withheld", action="store_true", help="listed physics that is withheld from the program")
    parser.add_argument(
        "--share", type=int, nargs=2, default=(0, 1), help="this of so many parts, for processes beside"
    )
    parser.add_argument("--nameless", action="store_true", help="without any listed physics: locations and laws alone")
    chosen = parser.parse_args()
    done = set()
    if chosen.out.exists():
        done = {json.loads(line)["case"] for line in chosen.out.read_text(encoding="utf-8").splitlines()}
    asked = withheld if chosen.withheld else questions
    for number, question in enumerate(asked(chosen.count, chosen.seed, chosen.only)):
        if question.name in done or number % chosen.share[1] != chosen.share[0]:
            continue
        try:
            found = answer(question, chosen.out.parent, nameless=chosen.nameless)
        except Exception as error:
            found = {"case": question.name, "kinds": question.kinds, "error": repr(error)}
        with chosen.out.open("a", encoding="utf-8") as file:
            file.write(json.dumps(found) + "\n")
        print(_line(found), flush=True)


def _line(found: dict[str, object]) -> str:
    if "error" in found:
        return f"{found['case']} {found['kinds']}: {found['error']}"
    return (
        f"{found['case']} {'+'.join(found['kinds'])} {found['accepted']}: {found['verdict']}, "  # type: ignore[arg-type]
        f"{'right' if found['located'] else 'WRONG'} {found['first']} p={found['probability']}, "
        f"base {found['base']:.2f} model {found['model']:.2f}{' WORSE' if found['worse'] else ''}, "
        f"covered {found['covered']:.2f}, names {found['wrong_names']}, {found['seconds']:.1f} s"
    )


if __name__ == "__main__":
    main()
