"""Calls that must be refused, as one table: what is called, what is wrong with which file, and what the message says.

The files are those of `tests.commands.test_wrong_inputs.inputs`; a command is written as a person types it beside them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from tests.commands.calls import yaml_file
from tests.design.problems import changed

Change = Callable[[Path], object]
"""What is done to the files in a folder."""


@dataclass(frozen=True)
class Wrong:
    """Commands that are refused after a change of their files, and parts of the one message."""

    commands: str | tuple[str, ...]
    said: str | tuple[str, ...]
    change: Change = lambda folder: None

    @property
    def calls(self) -> tuple[str, ...]:
        """Every command."""
        return (self.commands,) if isinstance(self.commands, str) else self.commands

    @property
    def parts(self) -> tuple[str, ...]:
        """Every part of the message."""
        return (self.said,) if isinstance(self.said, str) else self.said

    def __str__(self) -> str:
        return f"{self.calls[0].split()[0]}: {self.parts[-1]}"


def entries(file: str, changes: dict[str, Any]) -> Change:
    """Entries of a YAML file by their dotted keys."""
    return lambda folder: yaml_file(
        folder / file, changed(yaml.safe_load((folder / file).read_text(encoding="utf-8")), changes)
    )


def content(file: str, text: str | bytes) -> Change:
    """A file with another content."""
    return lambda folder: (folder / file).write_bytes(text if isinstance(text, bytes) else text.encode())


def text(file: str, right: str, wrong: str) -> Change:
    """A piece of a file, once."""

    def change(folder: Path) -> None:
        whole = (folder / file).read_text(encoding="utf-8")
        assert right in whole
        (folder / file).write_text(whole.replace(right, wrong, 1), encoding="utf-8")

    return change


def columns(file: str, **cells: str) -> Change:
    """Whole columns of a table, replaced or added."""

    def change(folder: Path) -> None:
        pd.read_csv(folder / file, dtype=str).assign(**cells).to_csv(folder / file, index=False)

    return change


def cell(file: str, row: int, column: str, written: str) -> Change:
    """One cell of a table, by its row of the file: the header is row 1."""

    def change(folder: Path) -> None:
        frame = pd.read_csv(folder / file, dtype=str)
        frame.loc[row - 2, column] = written
        frame.to_csv(folder / file, index=False)

    return change


def turned(folder: Path) -> None:
    """Deflections with the other sign."""
    frame = pd.read_csv(folder / "recordings.csv")
    names = [name for name in map(str, frame) if name.startswith("d")]
    frame.assign(**{name: -frame[name] for name in names}).to_csv(folder / "recordings.csv", index=False)


def too_few(folder: Path) -> None:
    """Three rows that measure one axis."""
    frame = pd.read_csv(folder / "recordings.csv")
    kept = [name for name in map(str, frame) if name == "dz_m" or not name.startswith("d")]
    frame[kept].iloc[:3].to_csv(folder / "recordings.csv", index=False)


def joints(folder: Path) -> None:
    """A hexapod's recordings under the names of joints."""
    frame = pd.read_csv(folder / "recordings.csv").drop(columns=["rx_rad", "ry_rad", "rz_rad"])
    frame.rename(columns={f"{axis}_m": f"q{k}_rad" for k, axis in enumerate("xyz", start=1)}).to_csv(
        folder / "recordings.csv", index=False
    )


def unloaded_targets(folder: Path) -> None:
    """No target carries a load."""
    targets = yaml.safe_load((folder / "config.yaml").read_text(encoding="utf-8"))["targets"]
    entries("config.yaml", {f"targets.{k}.gravity_m_s2": [0.0] * 3 for k in range(len(targets))})(folder)


def rising(*left: str) -> Change:
    """A model whose legs yield against their load; only what is `left` says so."""

    def change(folder: Path) -> None:
        path = folder / "identified" / "model.yaml"
        model = yaml.safe_load(path.read_text(encoding="utf-8"))
        model["compliance"] = {name: -value for name, value in model["compliance"].items()}
        model["relative_compliance"] = [-value for value in model["relative_compliance"]]
        for name in {"compliance", "relative_compliance"} - set(left):
            del model[name]
        yaml_file(path, model)

    return change


def more_than_certain(folder: Path) -> None:
    """A covariance in which some combination has a negative variance."""
    path = folder / "identified" / "model.yaml"
    rows = yaml.safe_load(path.read_text(encoding="utf-8"))["covariance"]
    root = 5.0 * (rows[0][0] * rows[1][1]) ** 0.5
    entries("identified/model.yaml", {"covariance.0.1": root, "covariance.1.0": root})(folder)


def placed(*positions: str) -> Change:
    """Rows of an arm with one marker each, at these positions."""
    header = ",".join(
        ["sequence,series", *(f"q{k}_rad" for k in range(1, 7)), "mass_kg,com_x_m,com_y_m,com_z_m,marker"]
        + [f"{name}_m" for name in ("px", "py", "pz", "spx", "spy", "spz")]
    )
    turns = ("0.1,-1,1,0.3,0.5,0.2", "0.5,-1.2,0.8,-0.3,0.2,0.9", "-0.4,-0.9,1.3,0.1,-0.6,0.4")
    rows = [
        f"{k},{k},{turn},4,0,0,0.1,prism,{place},1e-4,1e-4,1e-4"
        for k, (turn, place) in enumerate(zip(turns, positions, strict=False), start=1)
    ]
    return content("recordings.csv", "\n".join([header, *rows]) + "\n")


def one_joint(folder: Path) -> None:
    """An arm of one joint whose measured axes do not show it."""
    joint = '<parent link="a"/><child link="b"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/>'
    links = f'<link name="a"/><link name="b"/><joint name="j" type="revolute">{joint}</joint>'
    (folder / "r.urdf").write_text(f'<robot name="r">{links}</robot>')
    arm = {"name": "r", "kind": "serial", "urdf": "r.urdf", "base_link": "a", "tip_link": "b"}
    yaml_file(folder / "arm.yaml", arm | {"actuator_stiffness": [1000.0]})
    header = "sequence,series,q1_rad,mass_kg,com_x_m,com_y_m,com_z_m,dx_m,dz_m,sx_m,sz_m"
    yaml_file(folder / "recordings.csv", f"{header}\n1,1,0.5,10,0.1,0,0.5,1e-5,1e-5,1e-5,1e-5\n")


PLANNED = ("check config.yaml", "run config.yaml --out out")
BIPOD = ("check bipod.yaml", "run bipod.yaml --out out")
EVALUATED = "evaluate bipod.yaml bipod-plan.csv"
IDENTIFIED = "identify robot.yaml recordings.csv --out out"
DIAGNOSED = "diagnose robot.yaml recordings.csv --out out"
ARM = ("identify arm.yaml recordings.csv --out out", "diagnose arm.yaml recordings.csv --out out")
CHECKED = "check recordings.csv --robot robot.yaml"
NEXT = "next config.yaml recordings.csv --out next.csv"
MODEL = "identified/model.yaml"
PREDICTED = f"predict {MODEL} plan.csv --out predicted.csv"
COMPENSATED = f"compensate {MODEL} plan.csv --out commands.csv"
SIMULATED = "simulate config.yaml plan.csv --out rows.csv"
EVALUATED_PLAN = "evaluate config.yaml plan.csv"
GIVEN = (
    EVALUATED_PLAN,
    SIMULATED,
    "sheet config.yaml plan.csv --out sheet",
    "montecarlo config.yaml plan.csv --samples 100 --out repeated",
)
REPEATED = "montecarlo bipod.yaml bipod-plan.csv --out out"
LOAD_ERRORS: dict[str, Any] = {
    "effects": [
        {
            "physics": "payload_mass_error",
            "component": "payload",
            "identifier": "load.mass_error",
            "variant": "forgotten",
            "parameters": {"forgotten_N": 1.0},
        }
    ]
}
TWO_POSES: dict[str, Any] = {
    "experiment.poses": {"candidates": [[0.0] * 6, [0.01, *[0.0] * 5], [0.0] * 6]},
    "experiment.load.mass_kg": {"choices": [50, 50.0]},
}

CONFIGURATIONS = [
    *(
        Wrong(PLANNED, f"{place or key}: ", entries("config.yaml", {key: value}))
        for key, value, place in (
            ("experiment.measurements", 10**9, ""),
            ("experiment.measurements", 100_000, ""),
            ("experiment.measurements", 10**400, ""),
            ("experiment.poses", {"bounds": {"x_m": 10**400}}, "experiment.poses.bounds.x_m"),
            ("experiment.poses", {"bounds": {"x_m": [-1e308, 1e308]}}, "experiment.poses.bounds.x_m"),
            ("experiment.poses", {"grid": {"x_m": [0, 1, 10**12]}}, "experiment.poses.grid.x_m"),
            ("experiment.poses", {"candidates": "y" * 300}, "experiment.poses.candidates"),
            ("experiment.poses", {"candidates": "."}, "experiment.poses.candidates"),
            ("experiment.load.mass_kg", 1e300, ""),
            ("experiment.deflection_noise.std.dx_m", 1e-200, ""),
            ("experiment.deflection_noise.std.dx_m", 1e300, ""),
            ("experiment.load_error.1.std", 1e300, "experiment.load_error[1].std"),
            ("targets.0.tolerance.dz_m", 1e-200, "targets[0].tolerance.dz_m"),
            ("targets.0.tolerance.dz_m", 1e300, "targets[0].tolerance.dz_m"),
            ("targets.0.weight", 1e308, "targets[0].weight"),
            ("targets.0.gravity_m_s2", [0, 0, 1e300], "targets[0].gravity_m_s2[2]"),
            ("optimiser.population", 10**12, ""),
            ("robot", "y" * 300, ""),
            ("robot", ".", ""),
        )
    ),
    Wrong(BIPOD, "targets", entries("bipod.yaml", {"experiment.load.fx_N": 0, "experiment.load.fy_N": 0})),
    *(
        Wrong(PLANNED, words, entries("config.yaml", TWO_POSES | {"experiment.measurements": 6} | changes))
        for changes, words in (
            (
                {"experiment.constraints": {"distinct_poses": 3}},
                ("3 different poses", "`experiment.poses` offers 2"),
            ),
            ({"experiment.constraints": {"distinct_masses": 2}}, ("2 different masses", "offers 1")),
            (
                {"experiment.deflection_noise.std": {"dz_m": 1e-6}, "experiment.measurements": 5},
                "at least 6 measurements",
            ),
        )
    ),
    Wrong("check config.yaml", "targets: no target carries a load", unloaded_targets),
    Wrong(
        "run config.yaml --out out",
        "nothing to choose",
        entries(
            "config.yaml",
            {
                "experiment.poses": {"bounds": {"x_m": 0.01}},
                "experiment.load": {"kind": "payload", "mass_kg": 20.0, "com_x_m": 0.1},
            },
        ),
    ),
    Wrong(
        (*PLANNED, "compare config.yaml --out out"),
        "robot: a body has no actuators",
        entries("config.yaml", {"robot": {"name": "b", "kind": "body"}}),
    ),
]

ROBOTS = [
    *(
        Wrong("check robot.yaml", "line 1, kind: unknown kind", content("robot.yaml", f"kind: {kind}\nname: a\n"))
        for kind in ("[hexapod]", "{a: 1}", "3")
    ),
    *(
        Wrong("check robot.yaml", said, entries("robot.yaml", {"actuator_stiffness": [stiffness] * 6}))
        for stiffness, said in (
            (5.0, "no machine has an actuator stiffness of 5 N/m"),
            (1e15, "no machine has an actuator stiffness of 1e+15 N/m"),
        )
    ),
    *(
        Wrong("check arm.yaml", said, entries("arm.yaml", changes))
        for changes, said in (
            ({"urdf": "none.urdf"}, "there is no file"),
            ({"actuator_stiffness": [1e4] * 5}, "6 values are needed here, not 5"),
            ({"limits": {"q7_rad": [0, 1]}}, "unknown coordinate"),
            ({"limits": {"q1_rad": [1, 0]}}, "the wrong way round"),
            ({"gravity_m_s2": [0, 0]}, "three components"),
        )
    ),
]

PLANS = [
    *(
        Wrong(
            ("evaluate config.yaml plan.csv", SIMULATED, PREDICTED, COMPENSATED),
            (f"plan.csv, row 4, column {column}: ", word),
            cell("plan.csv", 4, column, written),
        )
        for column, written, word in (
            ("rx_rad", "30", "Check the unit"),
            ("x_m", "300", "Check the unit"),
            ("mass_kg", "1e300", "beyond any quantity"),
            ("com_x_m", "1e300", "beyond any quantity"),
            ("sequence", "1", "twice"),
            ("sequence", "1.5", "whole number"),
        )
    ),
    # Recordings with these rows would be refused.
    Wrong(SIMULATED, ("plan.csv, row 4", "singular"), cell("plan.csv", 4, "rz_rad", "1.5708")),
    Wrong(SIMULATED, ("plan.csv, row 4", "command"), cell("plan.csv", 4, "series", "1")),
    Wrong(SIMULATED, "plan.csv, row 2, column mass_kg", cell("plan.csv", 2, "mass_kg", "x")),
    # No other column is taken for the one that is missing.
    Wrong(PREDICTED, "column com_x_m: the column is missing. Add", text("plan.csv", "com_x_m", "colour")),
    Wrong(PREDICTED, "plan.csv, column z_m: the column is missing. Is `zz_m`", text("plan.csv", ",z_m", ",zz_m")),
    Wrong(
        COMPENSATED,
        ("plan.csv, row 4", "beyond the robot's limits: leg"),
        text("plan.csv", "3,2,-0.01,0,0,", "3,2,-0.01,0,0.2,"),
    ),
    *(
        Wrong(commands, ("plan.csv, row 2", said), cell("plan.csv", 2, column, written))
        for commands, column, written, said in (
            ((COMPENSATED, PREDICTED), "mass_kg", "26500", "1000 times the largest that was calibrated (26.5)"),
            ((COMPENSATED, PREDICTED), "com_x_m", "100", "a centre of mass would be 100 m away"),
            (COMPENSATED, "x_m", "10", "column x_m: at 10 m a leg would be"),
            (COMPENSATED, "rx_rad", "2.0", "beyond the robot's limits: leg 1"),
            (
                GIVEN,
                "mass_kg",
                "26500",
                "the mass is 26500 kg, 1000 times the largest in the configuration's experiment",
            ),
            (GIVEN, "com_x_m", "100", "a centre of mass would be 100 m away from a robot"),
            (EVALUATED_PLAN, "mass_kg", "-1", "column mass_kg"),
        )
    ),
    Wrong(
        GIVEN,
        "row 2, column fz_N: the wrench (-1) contradicts the payload",
        columns("plan.csv", **dict.fromkeys(("fx_N", "fy_N", "mx_Nm", "my_Nm", "mz_Nm"), "0"), fz_N="-1"),
    ),
    Wrong("check plan.csv", "no measured column"),
    *(
        Wrong(EVALUATED, ("bipod-plan.csv", *words), content("bipod-plan.csv", header + rows))
        for header in ("sequence,series,x_m,y_m,fx_N,fy_N\n",)
        for rows, words in (
            ("1,1,0.0,0.0,200,-900\n", ("row 2", "singular")),
            ("1,1,0.1,0.5,200,\n", ("row 2, column fy_N", "empty")),
            ("1,1,0.1,0.5,200,nan\n", ("row 2, column fy_N", "not a finite number")),
            ("", ("no rows",)),
            ("1,1,-0.2,0.55,200,-900\n2,1,0.2,0.6,200,-900\n", ("row 3, column x_m", "series 1")),
            ("1,1,-0.2,5.0,200,-900\n", ("row 2", "beyond the robot's limits", "leg 2")),
        )
    ),
    Wrong(EVALUATED, ("column fx_N", "missing"), text("bipod-plan.csv", "fx_N", "colour")),
    Wrong(REPEATED, "identify 1 of 2 stiffnesses", content("bipod-plan.csv", "x_m,y_m,fx_N,fy_N\n0,0.5,500,500\n")),
]

RECORDINGS = [
    *(
        Wrong((CHECKED, IDENTIFIED, DIAGNOSED, NEXT), ("recordings.csv", word), columns("recordings.csv", **cells))
        for cells, word in (
            ({"sx_m": "1e-200"}, "row 2, column sx_m"),
            ({"px_m": "0", "py_m": "0", "pz_m": "0", "marker": "a"}, "`dx_m` together with positions of markers"),
            (dict.fromkeys(("dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"), "0"), "every deflection is 0"),
        )
    ),
    Wrong((IDENTIFIED, DIAGNOSED), "load", columns("recordings.csv", mass_kg="0")),
    Wrong((IDENTIFIED, DIAGNOSED), "no row is left to fit", columns("recordings.csv", split="test")),
    Wrong((IDENTIFIED, DIAGNOSED), "wrong sign", turned),
    Wrong(
        (NEXT, "identify robot.yaml recordings.csv --targets config.yaml --out out"),
        "the mass is 26500 kg, 1000 times the largest in the configuration's experiment (26.5). Is it in grams?",
        columns("recordings.csv", mass_kg="26500"),
    ),
    Wrong(NEXT, "row 3, column sequence", cell("recordings.csv", 3, "sequence", "1")),
    Wrong(CHECKED, "3 readings cannot determine 6 compliances", too_few),
    *(
        Wrong(
            ("check recordings.csv --robot arm.yaml", *ARM),
            "do not tell where the instrument stands",
            placed(*positions),
        )
        for positions in (("0.1,0.2,0.3",), ("0.1,0.2,0.3", "0.2,0.3,0.4"), ("0,0,0", "1,1,1", "2,2,2"))
    ),
    Wrong(
        ARM,
        "measured ax",
        one_joint,
    ),
]

MODELS = [
    *(
        Wrong(PREDICTED, f", {place or key}: ", entries(MODEL, {key: value}))
        for key, value, place in (
            ("covariance", [], ""),
            ("covariance", [[1.0]], ""),
            ("covariance", ["1.0 l.0"], ""),
            ("schema_version", 3, ""),
            ("compliance", {"leg 1": 1e-7}, ""),
            ("robot", {"kind": "hexapod"}, "robot.name"),
            ("covariance.5", [1.0], "covariance"),
            ("covariance.0.0", -1.0, "covariance"),
            ("covariance.0.0", float("nan"), "covariance[0][0]"),
            ("covariance.0.0", 1e308, "covariance[0][0]"),
            ("birge_ratio", -1.0, ""),
            ("compliance.leg 2", 2e-6, ""),
            ("relative_compliance.1", 10.0, "compliance.leg 2"),
            ("relative_compliance", [1.0], ""),
            ("robot.actuator_stiffness", [5.24e9] * 6, "compliance.leg 1"),
            ("calibrated.x_m", [0.01, -0.01], ""),
            ("covariance.0.1", 1.0, "covariance"),
            ("covariance.0.1", "a", "covariance[0][1]"),
            ("parameters", ["a"], ""),
            ("robot", [1], ""),
            ("compliance.leg 1", 1e300, ""),
        )
    ),
    Wrong(PREDICTED, "compliance.leg 1: a negative compliance", rising("compliance")),
    Wrong(PREDICTED, "compliance.leg 1: a negative compliance", rising("compliance", "relative_compliance")),
    Wrong(PREDICTED, ", covariance: no covariance: some combination", more_than_certain),
    Wrong(
        PREDICTED,
        ", covariance: infinite beside finite variances",
        entries("identified/model.yaml", {"covariance.0.1": float("inf"), "covariance.1.0": float("inf")}),
    ),
    Wrong(
        COMPENSATED,
        ", load_errors.covariance: 1 rows of 7 numbers are needed here",
        entries("identified/model.yaml", {"load_errors": LOAD_ERRORS | {"covariance": [[1e-6]]}}),
    ),
    Wrong(
        COMPENSATED,
        ", load_errors.covariance: finite numbers are needed here",
        entries("identified/model.yaml", {"load_errors": LOAD_ERRORS | {"covariance": [[0.0] * 6 + [float("inf")]]}}),
    ),
    Wrong(
        COMPENSATED,
        ", load_errors.covariance: no covariance: some combination",
        entries("identified/model.yaml", {"load_errors": LOAD_ERRORS | {"covariance": [[1.0] * 6 + [1e-6]]}}),
    ),
]

OTHER_FILES = [
    *(
        Wrong(command, said)
        for command, said in (
            ("run robot.yaml", "this is a robot, not a run configuration"),
            ("evaluate plan.csv config.yaml", "this is a table, not a run configuration"),
            ("identify config.yaml plan.csv --out out", "this is a run configuration, not a robot"),
            ("compensate robot.yaml plan.csv --out out", "this is a robot, not an identified model"),
            ("predict config.yaml plan.csv --out out", "this is a run configuration, not a robot"),
            ("predict plan.csv plan.csv --out out", "this is a table, not"),
            ("sweep robot.yaml --out out", "this is a robot, not a sweep"),
            ("sweep config.yaml --out out", "this is a run configuration, not a sweep"),
            ("predict none.yaml plan.csv --out out", "none.yaml"),
            ("diagnose none.yaml recordings.csv --out out", "none.yaml"),
            ("diagnose robot.yaml none.csv --out out", "none.csv"),
            ("diagnose recordings.csv recordings.csv --out out", "recordings.csv"),
            ("identify robot.yaml recordings.csv recordings.csv --out out", "given twice"),
            ("simulate config.yaml plan.csv --out identified", "this is a folder, not a file"),
            ("sheet config.yaml plan.xlsx --out out", "plan.xlsx"),
        )
    ),
    Wrong("sweep sweep.yaml --out out", "not a run configuration", entries("sweep.yaml", {"config": "robot.yaml"})),
    Wrong(
        "identify arm.yaml recordings.csv --out out",
        ("the rows have poses (x_m, y_m, z_m ...), and `", "is commanded by q1_rad, q2_rad", "wrong robot file?"),
    ),
    Wrong(IDENTIFIED, ("the rows have joints (q1_rad, q2_rad, q3_rad ...), and `", "by x_m"), joints),
    *(
        Wrong(f"evaluate config.yaml {name}", (f"{name}: ", said), content(name, written))
        for name, written, said in (
            ("run.yaml", b"robot: x\ntargets:\n  - pose: [0, 0, 0, 0, 0, 0]\n", "this is a YAML file"),
            ("report.html", b"<!doctype html>\n<p>text</p>\n", "this is a page, not a table"),
            ("run.json", b'{"config": {}, "versions": {}}\n', "this is a record of results, not a table"),
            ("plan.xls", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1rest", "Save it as .xlsx"),
            ("plan.ods", b"PK\x03\x04rest", "Save it as .xlsx"),
        )
    ),
    *(
        Wrong((f"check {name}", f"evaluate {name} plan.csv", f"sweep {name} --out out"), said, content(name, written))
        for name, written, said in (
            ("report.html", "<!DOCTYPE html>\n<p>text</p>\n", "this is a page (HTML)"),
            ("run.json", '{"config": {"robot": "x"}, "versions": {}}\n', "this is a record of results"),
        )
    ),
    Wrong(
        "identify plan.xlsx robot.yaml --out out",
        "plan.xlsx: this is a workbook, not text",
        lambda folder: pd.read_csv(folder / "plan.csv").to_excel(folder / "plan.xlsx", index=False),
    ),
    Wrong(
        "identify robot.yaml other.xlsx --out out",
        "other.xlsx, sheet `Tabelle1`, column sequence: the column is missing. Add the column",
        lambda folder: pd.read_csv(folder / "plan.csv")[["series", "x_m"]].to_excel(
            folder / "other.xlsx", index=False, sheet_name="Tabelle1"
        ),
    ),
    Wrong("check robot.yaml", "not valid YAML", content("robot.yaml", "kind: hexapod\0\n")),
    Wrong(
        "check robot.yaml",
        "entries",
        content(
            "robot.yaml",
            "a0: &a0 [0, 0, 0, 0, 0, 0, 0, 0, 0, 0]\n"
            + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]\n" for i in range(1, 8)),
        ),
    ),
]

OPTIONS = [
    Wrong(command, said)
    for command, said in (
        *((f"{IDENTIFIED} --prior={value}", "--prior") for value in ("0", "-5", "nan", "1e-300")),
        *((f"{NEXT} {option}", option.split()[0]) for option in ("--count 0", "--accuracy -1", "--accuracy nan")),
        (f"{SIMULATED} --seed -1", "--seed"),
        (f"{PREDICTED} --units mm,furlong", "--units: unknown unit `furlong`"),
        (f"{REPEATED} --distribution cauchy", "--distribution: `cauchy` is not one of `normal`, `uniform`"),
        (f"{REPEATED} --samples 3", "3 is not a number of repetitions from 100"),
        (f"{REPEATED} --seed -1", "-1 is not a seed"),
        (f"{DIAGNOSED} --series 0", "--series: 0 is not a number of series"),
        ("compare config.yaml --out out --plan a=plan.csv --plan a=plan.csv", "`a` appears twice"),
        ("compare config.yaml --out out --generations 0", "--generations: 0 is not a number of generations"),
        ("compare config.yaml --out out --plan duir=x.csv", "--plan: `duir` is the name of a criterion"),
        *(
            (f"{command} --workers {workers}", "--workers")
            for command in ("compare config.yaml --out out", REPEATED, "sweep sweep.yaml --out out")
            for workers in ("0", "2 --cluster tcp://localhost:1")
        ),
        ("run config.yaml --out out --seconds -1", "--seconds: -1 is not a time in s"),
        ("new hexpod --out out", "Did you mean `hexapod`?"),
        ("schema config", "Did you mean `configuration`?"),
    )
]

WRONG = [*CONFIGURATIONS, *ROBOTS, *PLANS, *RECORDINGS, *MODELS, *OTHER_FILES, *OPTIONS]
