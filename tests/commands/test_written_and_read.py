"""What `diagnose` writes the other commands read: every kind of robot and way of working, in many series and in one.

Each robot has effects that its base model lacks. `diagnose` writes the model; `check`, `predict`, `compensate` and
`verify` read its file, as a person goes on with it.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import expdesign as xd
from expdesign.chain.chain import Chain
from expdesign.chain.effects.joints.backlash import JointBacklash
from expdesign.chain.effects.joints.bearings import JointCompliance
from expdesign.chain.effects.joints.geometry import ArmGeometryError
from expdesign.chain.effects.links.links import LinkCompliance
from expdesign.chain.models.model_file import Model, read_model
from expdesign.chain.row import row_data
from expdesign.diagnosis.result import LAWS, ONE_AT_A_TIME, TOGETHER
from expdesign.errors import InputError
from expdesign.io.output import csv_text
from tests.cases import ROBOTS, content_of, robot
from tests.chain.arm_rows import arm_rows, concealed, six_axis
from tests.chain.arms import DEVIATION, READING, configurations, read_arm, recordings_of
from tests.chain.bodies import BODY
from tests.chain.kinds import KINDS
from tests.chain.places import WRENCH, rows
from tests.commands.calls import ROOT, call
from tests.diagnosis.samples import effect
from tests.identification.experiments import read
from tests.oracle import Array
from tests.ports.test_supports import column_rows

NAMELESS = frozenset(kind.physics for kind in KINDS)
"""With no physics to name, only laws at ports are left."""


@dataclass(frozen=True)
class Way:
    """A robot file with recordings of it, how they are worked with, and what a person wants of the model then."""

    file: Path
    recordings: pd.DataFrame
    targets: pd.DataFrame
    method: str
    without: frozenset[str] = frozenset()


def parallel(name: str, folder: Path, method: str) -> Way:
    """A leg with play, in a file with what the table of robots says."""
    here, case = robot(name), ROBOTS[name]
    file = folder / "robot.yaml"
    file.write_text(yaml.safe_dump({"name": name} | content_of(here)), encoding="utf-8")
    frame = rows(name, WRENCH, series=8)
    frame = frame[[c for c in frame if not re.match(r"abs_|g._m_s2|leg\d", str(c))]]
    play = effect(name, "leg_backlash", "leg 1", "middle")
    exact = Chain(here, (play,)).predict(
        row_data(read(frame, here), here), np.append(np.ones(len(here.stiffness)), _gap(name))
    )
    noise = np.random.default_rng(3).standard_normal(exact.shape) * case.deviation
    frame[list(here.coordinates.deflection)] = exact + noise
    kept = ["sequence", *here.configuration, *here.coordinates.wrench]
    return Way(file, frame, frame[kept].iloc[[0, 5, 9]], method, NAMELESS if method == LAWS else frozenset())


def _gap(name: str) -> float:
    """Play that shows beside the noise and the load."""
    return 12.0 * ROBOTS[name].deviation[0]


def arm_with_deflections(folder: Path, method: str) -> Way:
    """Payloads on an arm whose fourth joint has play, or whose second yields across its axis as no name says."""
    here = six_axis()
    file = ROOT / "configs" / "robots" / "ur5.yaml"
    frame = arm_rows(here, series=8).drop(columns=[f"leg{i}_degC" for i in range(1, 7)])
    soft, play = JointCompliance.from_text(here, "joint 2", ""), JointBacklash.from_text(here, "joint 4", "middle")
    measured = concealed(here, frame, (soft,), [2e-5]) if method == LAWS else concealed(here, frame, (play,), [4e-4])
    frame[list(here.coordinates.deflection)] = measured.deflections
    kept = ["sequence", *here.configuration, "mass_kg", "com_x_m", "com_y_m", "com_z_m"]
    return Way(file, frame, frame[kept].iloc[[0, 5, 9]], method, NAMELESS if method == LAWS else frozenset())


def arm_with_positions(folder: Path, method: str) -> Way:
    """Positions of a marker on an arm whose geometry is off everywhere, and two of whose links bend."""
    here = read_arm(folder)
    q = configurations(72, 1)
    blank = recordings_of(here, q, np.zeros((72, 3)))
    effects = (
        *(ArmGeometryError.from_text(here, f"joint {i}", "offset") for i in (3, 4, 5, 6)),
        *(LinkCompliance.from_text(here, f"link {i}", "") for i in (3, 4)),
        *(ArmGeometryError.from_text(here, f"link {i}", "frame") for i in (3, 4, 5)),
    )
    chain = Chain(here, effects, reading=READING)
    values = np.concatenate([chain.start()[: chain.base], [4e-3, -3e-3, 5e-3, -4e-3], [3e-4, 2e-4, 5e-4, 3e-4], LINKS])
    exact = chain.predict(row_data(blank, here), values)
    positions = exact + DEVIATION * np.random.default_rng(2).standard_normal(exact.shape)
    frame = pd.DataFrame({"sequence": np.arange(1, 73), "series": np.arange(1, 73)})
    frame[list(here.configuration)] = q
    frame[list(here.coordinates.wrench)] = 0.0
    frame["marker"] = "ball"
    frame[["px_m", "py_m", "pz_m"]], frame[["spx_m", "spy_m", "spz_m"]] = positions, DEVIATION
    kept = ["sequence", *here.configuration, *here.coordinates.wrench]
    regular = np.argsort(np.linalg.cond(here.jacobians(q).forward))[:3]
    return Way(folder / "arm.yaml", frame, frame[kept].iloc[np.sort(regular)], method)


WAYS = [
    *((name, method) for name in ROBOTS for method in (ONE_AT_A_TIME, LAWS)),
    ("arm", ONE_AT_A_TIME), ("arm", LAWS), ("arm with positions", ONE_AT_A_TIME),
]  # fmt: skip
LINKS = np.random.default_rng(1).normal(0.0, [2e-3, 2e-3, 2e-3, 4e-3, 4e-3, 4e-3], (3, 6)).ravel()
QUICK = {("bipod", ONE_AT_A_TIME), ("bipod", LAWS), ("H1", LAWS), ("arm with positions", ONE_AT_A_TIME)}


def way_of(kind: str, method: str, folder: Path) -> Way:
    if kind == "arm":
        return arm_with_deflections(folder, method)
    return arm_with_positions(folder, method) if "positions" in kind else parallel(kind, folder, method)


def _cases() -> list[object]:
    """One of each kind in every run, the others as a slow proof."""
    return [pytest.param(*way, marks=() if way in QUICK else pytest.mark.slow, id="-".join(way)) for way in WAYS]


@pytest.mark.parametrize("series", ["per pose", "other"])
@pytest.mark.parametrize(("kind", "method"), _cases())
def test_what_diagnose_writes_is_read(kind: str, method: str, series: str, tmp_path: Path) -> None:
    way = way_of(kind, method, tmp_path)
    recorded = way.recordings if series == "per pose" else in_other_series(way.recordings)
    measured = tmp_path / "recordings.csv"
    measured.write_text(csv_text(recorded), encoding="utf-8")
    found = xd.diagnose(way.file, measured, without=way.without)
    assert found.result.method.name == method
    found.save(tmp_path / "diagnosed")
    file = tmp_path / "diagnosed" / "model.yaml"
    written, kept = found.model, read_model(file)
    np.testing.assert_array_equal(kept.values, written.values)
    np.testing.assert_allclose(kept.covariance, written.covariance, rtol=1e-12)
    assert_sound(kept.covariance)
    assert_physical(kept)

    assert call("check", file) == 0
    points, targets = tmp_path / "points.csv", tmp_path / "targets.csv"
    points.write_text(csv_text(recorded), encoding="utf-8")
    targets.write_text(csv_text(way.targets), encoding="utf-8")
    assert call("predict", file, points, "--readings", "--out", tmp_path / "predicted.csv") == 0
    assert_predicted(recorded, pd.read_csv(tmp_path / "predicted.csv"))
    commands = tmp_path / "commands.csv"
    assert call("compensate", file, targets, "--out", commands) == 0
    with pytest.raises(InputError, match="an input"):
        xd.compensate(file, targets).save(targets, force=True)
    checked = tmp_path / "check.csv"
    checked.write_text(csv_text(check_measurement(file, pd.read_csv(commands))), encoding="utf-8")
    assert call("verify", file, checked, "--out", tmp_path / "verified") == 0
    assert (tmp_path / "verified" / "report.html").exists()


def test_groups_of_effects_are_read_as_they_were_written(tmp_path: Path) -> None:
    """A column with play between its guides, and springs: `predict` gives what the diagnosis has, digit by digit."""
    machine, measured, predicted = (tmp_path / name for name in ("robot.yaml", "recordings.csv", "predicted.csv"))
    machine.write_text(yaml.safe_dump({"name": BODY.name, "kind": "body", "home": BODY.home.tolist()}))
    measured.write_text(csv_text(column_rows()), encoding="utf-8")
    found = xd.diagnose(machine, measured)
    assert found.result.method.name == TOGETHER
    assert len(found.result.predictive.fit.chain.effects) > 1
    found.save(tmp_path / "diagnosed")
    file = tmp_path / "diagnosed" / "model.yaml"
    kept = read_model(file)
    np.testing.assert_array_equal(kept.values, found.model.values)
    np.testing.assert_allclose(kept.covariance, found.model.covariance, rtol=1e-12)
    assert_sound(kept.covariance)

    assert call("predict", file, measured, "--out", predicted) == 0
    known, recordings = found.result.known, found.result.recordings
    expected, slopes = known.chain.predict_with_sensitivities(row_data(recordings, BODY), known.values)
    frame, axes = pd.read_csv(predicted), list(recordings.axes)
    names = [BODY.coordinates.deflection[axis] for axis in axes]
    np.testing.assert_allclose(frame[names], expected[:, axes], rtol=1e-9, atol=1e-15)
    deviations = frame[[BODY.coordinates.deviation[axis] for axis in axes]]
    np.testing.assert_allclose(deviations, known.estimable.deviations(slopes)[:, axes], rtol=1e-9, atol=1e-15)


def in_other_series(recordings: pd.DataFrame) -> pd.DataFrame:
    """All positions in one series; deflections, of which a series has one command, each in a series of its own."""
    return recordings.assign(series=1 if "px_m" in recordings else recordings["sequence"])


def assert_sound(covariance: Array) -> None:
    """Symmetric and positive semidefinite where it is finite, in units of its own deviations."""
    known = np.isfinite(np.diag(covariance))
    inner = covariance[np.ix_(known, known)]
    np.testing.assert_array_equal(inner, inner.T)
    scale = np.sqrt(np.where(np.diag(inner) > 0.0, np.diag(inner), 1.0))
    assert np.linalg.eigvalsh(inner / np.outer(scale, scale)).min(initial=0.0) > -1e-9


def assert_physical(model: Model) -> None:
    """Compliances are possible, and those of the drawing, which are true, within what they are known to."""
    count = model.chain.compliances
    relative, deviations = model.values[:count], np.sqrt(np.diag(model.covariance)[:count])
    assert ((relative > 0.0) & (relative < 100.0)).all()
    assert (np.abs(relative - 1.0) < np.maximum(4.0 * deviations, 3.0)).all()


def assert_predicted(recorded: pd.DataFrame, predicted: pd.DataFrame) -> None:
    """Readings lie where they are predicted, with standard deviations that are neither absent nor without end."""
    read_as = [str(c) for c in recorded if re.fullmatch(r"(d|dr|p)[xyz]_(m|rad)", str(c))]
    error = (recorded[read_as] - predicted[read_as]).to_numpy()
    deviation = predicted[[f"s{c.removeprefix('d')}" for c in read_as]].to_numpy()
    assert np.isfinite(deviation).all()
    assert (deviation > 0.0).all()
    inside = (np.abs(error) < 1.96 * deviation).mean()
    assert 0.85 < inside <= 1.0


def check_measurement(model: Path, commands: pd.DataFrame) -> pd.DataFrame:
    """What is read at the commands where the robot is as the model says, with noise."""
    predicted = xd.predict(model, commands, platform=True).frame
    here = read_model(model).chain.robot
    names = list(here.coordinates.deflection)
    size = np.array([2e-6 if name.endswith("_m") else 4e-6 for name in names])
    result = commands.copy()
    result[names] = predicted[names] + size * np.random.default_rng(6).standard_normal((len(commands), len(names)))
    result[list(here.coordinates.deviation)] = size
    return result
