"""Simulated laboratories: how often a hexapod passes that is out of tolerance.

    python -m research.benchmarks.laboratories --count 200 --out results/laboratories/laboratories
    python -m research.benchmarks.laboratories --count 200 --loads --out results/laboratories/laboratories-loads

One plan is made by `run`, for a hexapod whose rows of a series share an unloaded reading. Every laboratory then has a
robot of its own: legs of drawn stiffness and, in every other laboratory, one physics that the base model lacks, of
drawn kind, place and size. It simulates the plan with noise, and goes on twice: with the model of `identify`, and with
that of `diagnose --targets`. Each model compensates the targets. The truth is where the drawn robot then stands without
noise; it fails where an axis is beyond its tolerance. At the commands of `diagnose` the laboratory reads each target 25
times, and `verify` decides from these readings. With `--loads` the weights and the direction of gravity have errors as
they are declared: the first target carries the same weights, the second a payload of its own, not quite known either,
and gravity is the same at both.

The share of laboratories that let a robot pass that fails is the global consumer's risk (JCGM 106:2012, 3.3.15); at
U ≤ T with k = 2 it is stated to be at most 4.55 %, for the robot as a whole and physics included that the recordings
may hide.
"""

import argparse
import csv
import sys
import time
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import expdesign as xd
from expdesign.io.yaml_reader import read_yaml
from expdesign.mechanics.robots.robot_file import robot_from_document

RISK = 0.0455
"""Probability beyond ±2 standard deviations."""
ROBOT = Path(__file__).parents[2] / "configs" / "robots" / "hexapod-h1.yaml"
TOLERANCE = {"dx_m": 6e-7, "dy_m": 6e-7, "dz_m": 4e-7, "drx_rad": 3e-6, "dry_rad": 3e-6}
_PAYLOAD = {"mass_kg": 26.5, "com_m": [0.03, 0.02, 0.15]}
CONFIG: dict[str, Any] = {
    "schema_version": 1,
    "experiment": {
        "measurements": 24,
        "poses": {
            "bounds": {
                "x_m": [-0.03, 0.03], "y_m": [-0.03, 0.03], "z_m": [-0.02, 0.02],
                "rx_rad": [-0.15, 0.15], "ry_rad": [-0.15, 0.15], "rz_rad": [-0.2, 0.2],
            },
        },
        "load": {
            "kind": "payload", "mass_kg": {"choices": [5, 10, 26.5]},
            "com_x_m": [-0.1, 0.1], "com_y_m": [-0.1, 0.1], "com_z_m": 0.12,
        },
        "deflection_noise": {
            "shared_reference": True,
            "std": {"dx_m": 1e-6, "dy_m": 1e-6, "dz_m": 1e-6, "drx_rad": 4e-6, "dry_rad": 4e-6, "drz_rad": 4e-6},
        },
    },
    "targets": [
        {"pose": [0.02, 0, 0, 0, 0, 0], "payload": _PAYLOAD, "tolerance": TOLERANCE},
        {"pose": [-0.02, 0, 0, 0.05, 0, 0], "payload": _PAYLOAD, "tolerance": TOLERANCE},
    ],
    "objectives": ["duir"],
    "optimiser": {"population": 24, "generations": 12, "seed": 1},
}  # fmt: skip
HIDDEN = {
    "leg_backlash at leg {leg}, {size:.3g} um": (2.0, 15.0),
    "friction_hysteresis at leg {leg}, rigid, {size:.3g} N": (2.0, 20.0),
    "leg_nonlinear_stiffness at leg {leg}, {size:.3g} um": (0.2, 3.0),
    "base_compliance at base, diagonal": (1.0, 1.0),
}
"""What is concealed, with the range from which its size is drawn (evenly in its logarithm)."""
LOADS: dict[str, Any] = {
    "load_error": [
        {"source": "com", "std": [0.005, 0.005, 0.005]},
        {"source": "mass", "std": 0.05},
        {"source": "direction", "std": [0.002, 0.002]},
    ],
    "payloads": [{"same_as": "experiment"}, {"std": {"mass_kg": 0.05, "com_m": [0.001, 0.001, 0.001]}}],
}
"""Errors of the campaign's loads, and what is known of the payload of each target."""
_READINGS = 25
"""Check readings of every target."""


@dataclass(frozen=True)
class Laboratory:
    """What was decided, and whether the robot fails at the commands of each model.

    Attributes:
        seed: of it.
        hidden: the physics that was concealed; empty where none was.
        found: verdict of the diagnosis.
        identified, diagnosed: decision with each model.
        identified_error, diagnosed_error: largest error of the truth, in tolerances.
        identified_risk, diagnosed_risk: stated probability that any axis is beyond its tolerance; NaN where nothing is
            decided.
        verified: verdict of the check readings.
        refused: what a command refused; empty where none did.
    """

    seed: int
    hidden: str
    found: str = ""
    identified: str = ""
    identified_error: float = float("nan")
    diagnosed: str = ""
    diagnosed_error: float = float("nan")
    verified: str = ""
    refused: str = ""
    identified_risk: float = float("nan")
    diagnosed_risk: float = float("nan")


def configuration(stiffness: np.ndarray | None = None, *, loads: bool = False) -> dict[str, Any]:
    """The configuration of the laboratories, or that with which the robot of one is simulated."""
    content, robot = deepcopy(CONFIG), deepcopy(read_yaml(ROBOT).content)
    if loads:
        content["experiment"]["load_error"] = LOADS["load_error"]
        for target, payload in zip(content["targets"], LOADS["payloads"], strict=True):
            target["payload"] = target["payload"] | payload
    if stiffness is not None:
        robot["actuator_stiffness"] = stiffness.tolist()
    return {**content, "robot": robot}


def drawn(seed: int, *, loads: bool = False) -> tuple[dict[str, Any], str]:
    """The robot of a laboratory as a configuration, and what is concealed in it."""
    generator = np.random.default_rng([seed, 7])
    stated = robot_from_document(read_yaml(ROBOT)).stiffness
    truth = configuration(stated * np.exp(0.12 * generator.standard_normal(len(stated))), loads=loads)
    if seed % 2 == 0:
        return truth, ""
    text, (low, high) = list(HIDDEN.items())[int(generator.integers(len(HIDDEN)))]
    size = float(np.exp(generator.uniform(np.log(low), np.log(high))))
    return truth, text.format(leg=1 + int(generator.integers(6)), size=size)


def largest_error(truth: Mapping[str, Any], hidden: str, commands: pd.DataFrame, seed: int) -> float:
    """Largest distance of the drawn robot from its targets at commands, in tolerances."""
    reached = xd.simulate(truth, _plan(commands), conceal=hidden or (), seed=seed + 1, noise=False).frame
    errors = [
        np.abs(commands[pose] + reached[f"d{pose}"] - commands[f"target_{pose}"]) / TOLERANCE[f"d{pose}"]
        for pose in ("x_m", "y_m", "z_m", "rx_rad", "ry_rad")
    ]
    return float(np.max(errors))


def _plan(commands: pd.DataFrame) -> pd.DataFrame:
    """Commands, targets and loads, which are known as they are stated there."""
    begins = ("target_", "error_", "com_")
    kept = ["x_m", "y_m", "z_m", "rx_rad", "ry_rad", "rz_rad", "mass_kg", "same_as"]
    plan = commands[[name for name in commands if name in kept or str(name).startswith(begins)]]
    return plan.assign(sequence=np.arange(1, len(plan) + 1), series=np.arange(1, len(plan) + 1))


def check_readings(
    truth: Mapping[str, Any], hidden: str, commands: pd.DataFrame, seed: int, readings: int
) -> pd.DataFrame:
    """What is read at the commands, every target as often as `readings` says."""
    often = pd.concat([commands] * readings, ignore_index=True)
    read = xd.simulate(truth, _plan(often), conceal=hidden or (), seed=seed + 1).frame
    names = [name for name in read if str(name).startswith(("d", "s")) and str(name) not in ("sequence", "series")]
    return often.assign(**{str(name): read[name] for name in names}, sequence=read["sequence"], series=read["series"])


def laboratory(seed: int, plan: pd.DataFrame, *, loads: bool = False) -> Laboratory:
    """One laboratory from its recordings to its certificate."""
    truth, hidden = drawn(seed, loads=loads)
    config = configuration(loads=loads)
    recordings = xd.simulate(truth, plan, conceal=hidden or (), seed=seed + 1).frame
    try:
        identified = xd.identify(config["robot"], recordings, targets=config)
        found = xd.diagnose(config["robot"], recordings, targets=config)
        first, second = (xd.compensate(each, config).frame for each in (identified, found))
        check = check_readings(truth, hidden, second, seed, _READINGS)
        verified = xd.verify(found, check, config=config)
    except xd.ExpdesignError as error:
        return Laboratory(seed, hidden, refused=str(error))
    assert identified.acceptance is not None
    assert found.acceptance is not None
    return Laboratory(
        seed, hidden, found.verdict,
        identified.acceptance.verdict, largest_error(truth, hidden, first, seed),
        found.acceptance.verdict, largest_error(truth, hidden, second, seed),
        verified.result.verdict, "", identified.acceptance.robot_risk, found.acceptance.robot_risk,
    )  # fmt: skip


def share(wrong: int, count: int) -> str:
    """A share with its standard error, as a text."""
    if not count:
        return "–"
    part = wrong / count
    # With none seen the standard error of Laplace's estimate says how far none reaches.
    spread = np.sqrt(part * (1.0 - part) / count) if 0 < wrong < count else 1.0 / (count + 2)
    return f"{100.0 * part:.1f} ± {100.0 * spread:.1f} % ({wrong} of {count})"


def _mean_risk(found: list[Laboratory], decision: str, stated: str) -> str:
    """Mean of the stated risk of those that pass, as a text."""
    risks = [getattr(x, stated) for x in found if stated and getattr(x, decision) == "pass"]
    return f"{100.0 * np.mean(risks):.1f} %" if risks else "–"


def page(found: list[Laboratory], command: str, seconds: float) -> str:
    """The result as a page."""
    lines = [
        "# Laboratories: how often a robot passes that is out of tolerance", "",
        *(__doc__ or "").strip().splitlines()[4:], "", "```", command, "```", "",
        f"{len(found)} laboratories in {seconds:.0f} s of processor time; "
        f"refused by a command: {sum(bool(each.refused) for each in found)}.", "",
        "| physics | decided by | pass | fail | not decided or not proven | passes that fail, of all | of passes "
        "| risk stated with the passes, mean |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]  # fmt: skip
    groups = {
        "none hidden": [x for x in found if not x.hidden],
        "one hidden": [x for x in found if x.hidden],
        "all": found,
    }
    for name, group in groups.items():
        for way, decision, error, stated in (
            ("`identify`", "identified", "identified_error", "identified_risk"),
            ("`diagnose`", "diagnosed", "diagnosed_error", "diagnosed_risk"),
            ("`verify`", "verified", "diagnosed_error", ""),
        ):
            done = [(getattr(x, decision), getattr(x, error)) for x in group if not x.refused]
            passes = [error for verdict, error in done if verdict == "pass"]
            wrong = sum(error > 1.0 for error in passes)
            fails = sum(verdict == "fail" for verdict, _ in done)
            lines.append(
                f"| {name} | {way} | {len(passes)} | {fails} | {len(done) - len(passes) - fails} | "
                f"{share(wrong, len(done))} | {share(wrong, len(passes))} | {_mean_risk(group, decision, stated)} |"
            )
    lines += [
        "",
        f"Stated: at most {100.0 * RISK:.2f} % of all, what the recordings may hide included.",
    ]
    bad = [x for x in found if "pass" in (x.diagnosed, x.verified) and x.diagnosed_error > 1.0]
    if bad:
        lines += ["", "Robots that fail and passed with the model of `diagnose`, or its check readings:", ""]
        lines += [
            f"- {x.seed}: {x.hidden or 'nothing hidden'}; {x.found}, `diagnose` {x.diagnosed}, `verify` {x.verified}, "
            f"largest error {x.diagnosed_error:.2f} tolerances"
            for x in bad
        ]
    return "\n".join([*lines, ""])


def main(arguments: list[str] | None = None) -> int:
    """Work through the laboratories and write the table as CSV and as a page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="seed of the first laboratory")
    parser.add_argument("--loads", action="store_true", help="with errors of the loads")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="no laboratory begins after so long")
    parser.add_argument("--out", type=Path, required=True, help="table and page, without ending")
    options = parser.parse_args(arguments)
    began, cpu = time.monotonic(), time.process_time()
    plan = xd.run(configuration(loads=options.loads)).plan
    found: list[Laboratory] = []
    for seed in range(options.first, options.first + options.count):
        if time.monotonic() - began > options.seconds:
            break
        found.append(laboratory(seed, plan, loads=options.loads))
        print(found[-1], flush=True)
        with options.out.with_suffix(".csv").open("w", encoding="utf-8", newline="") as stream:
            writer = csv.DictWriter(stream, [field.name for field in fields(Laboratory)])
            writer.writeheader()
            writer.writerows(asdict(each) for each in found)
        limit = "" if np.isinf(options.seconds) else f" --seconds {options.seconds:g}"
        first = f" --first {options.first}" if options.first else ""
        first += " --loads" if options.loads else ""
        command = (
            f"python -m research.benchmarks.laboratories --count {options.count}{first}{limit} --out {options.out}"
        )
        text = page(found, command, time.process_time() - cpu)
        options.out.with_suffix(".md").write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
