"""Ball bars, draw wires and gauges: an arm is calibrated from distances alone, and from distances beside positions."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.chain.recordings.recordings import Recordings, complete_positions
from expdesign.errors import InputError
from expdesign.mechanics.minimal_set import MinimalSet
from tests.identification.test_arm_calibration import recordings_of
from tests.plant import INSTRUMENT, JOINTS, PLACES, PLAIN, READ, ROBOT, STATED, Arm, recordings
from tests.plant import NOISE as PLACE

POINTS = {"ball": np.array([0.9, 0.3, 0.2]), "wire": np.array([-0.5, 1.0, 0.0])}
ZERO, DISTANCE, GAUGE = 0.25, 2e-5, 1e-5


def measured(count: int = 260, *, positions: bool = False) -> pd.DataFrame:
    """Distances of three markers from two points, every fourth row a gauge; with `positions` every third a position."""
    generator, arm, rows = np.random.default_rng(1), Arm(PLAIN), []
    for number in range(count):
        command = generator.uniform([-2.5, -2.4, -2.0, -2.5, -2.5, -2.8], [2.5, -0.7, 2.0, 2.5, 2.5, 2.8])
        marker = list(PLACES)[number // 4 % 3]
        read = arm.position(command, PLACES[marker])
        place, noise = INSTRUMENT.act(read), generator.standard_normal(3)
        row: dict[str, object] = {"sequence": number + 1, "series": number + 1, "marker": marker}
        row |= dict(zip(JOINTS, command, strict=True))
        row |= {"split": "test" if number % 5 == 0 else "train"}
        if positions and number % 3 == 0:
            row |= dict(zip(READ, read + PLACE * noise, strict=True))
            row |= dict.fromkeys(STATED, PLACE)
        elif number % 4 == 3:
            along = generator.standard_normal(3)
            along /= np.linalg.norm(along)
            row |= {"point": "probe", **dict(zip(("along_x", "along_y", "along_z"), along, strict=True))}
            row |= {"gauge_m": along @ place - ZERO + GAUGE * noise[0], "sgauge_m": GAUGE}
        else:
            name = list(POINTS)[number % 2]
            row |= {"point": name, "distance_m": np.linalg.norm(place - POINTS[name]) + DISTANCE * noise[0]}
            row |= {"sdistance_m": DISTANCE}
        rows.append(row)
    return pd.DataFrame(rows)


@pytest.mark.parametrize("positions", [False, True])
def test_held_out_distances_are_predicted_to_their_noise(positions: bool, tmp_path: Path) -> None:
    frame = measured(positions=positions)
    found = xd.identify(ROBOT, frame)
    arm = found.result.arm
    entries = arm.accuracy
    assert entries["held out", "distance"].before.rms > 20.0 * DISTANCE
    assert entries["held out", "distance"].after.rms < 1.5 * DISTANCE
    assert entries["held out", "gauge"].after.rms < 2.0 * GAUGE
    assert found.result.goodness.p_value is None or found.result.goodness.p_value > 0.01
    values = dict(zip(arm.labels, arm.fit.values, strict=True))
    spread = dict(zip(arm.labels, np.sqrt(np.diag(arm.fit.covariance)), strict=True))
    assert abs(values["gauge probe's zero"] - ZERO) < 4.0 * spread["gauge probe's zero"]
    if positions:
        assert entries["held out", "position"].after.rms < 1.5 * PLACE * np.sqrt(3.0)
    found.save(tmp_path / "found")
    read = ["distance_m", "sdistance_m", "gauge_m", "sgauge_m", *READ, *STATED]
    points = frame.drop(columns=read, errors="ignore")
    points = points[points["point"].notna()]
    predicted = xd.predict(tmp_path / "found" / "model.yaml", points, readings=True).frame
    for name in ("distance_m", "gauge_m"):
        away = (predicted[name] - frame.loc[points.index, name].to_numpy())[(points["split"] == "test").to_numpy()]
        inside = np.abs(away.dropna()) <= 1.96 * predicted[f"s{name}"][away.dropna().index]
        assert inside.mean() > 0.8


def test_what_distances_cannot_be_is_named() -> None:
    frame = measured(40)
    for changes, part in (
        ({"distance_m": -0.3}, "cannot be a distance in m"),
        ({"sdistance_m": 0.0}, "standard deviation of a distance in m: it must be positive"),
        ({"along_z": 1.0}, "a distance and the direction of a gauge"),
    ):
        with pytest.raises(InputError, match=part):
            recordings_of(frame.assign(**{name: frame[name].where(frame.index != 4, v) for name, v in changes.items()}))
    with pytest.raises(InputError, match="a gauge has no direction"):
        recordings_of(frame.drop(columns=["along_x", "along_y", "along_z"]))
    with pytest.raises(InputError, match="`ball` is a gauge here and a fixed point"):
        recordings_of(frame.assign(point="ball"))
    with pytest.raises(InputError, match="distances or gauges, and no positions"):
        complete_positions(recordings_of(frame))


def test_a_diagnosis_says_what_it_leaves_out(caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[Recordings] = []

    def begun(robot: object, recordings: Recordings, *more: object, **options: object) -> None:
        given.append(recordings)
        raise KeyboardInterrupt

    monkeypatch.setattr("expdesign.app.api.diagnose.diagnose_recordings", begun)
    with caplog.at_level("WARNING"), pytest.raises(KeyboardInterrupt):
        xd.diagnose(ROBOT, measured(60, positions=True))
    assert "reads complete positions, not 40 rows with fewer than three coordinates" in caplog.text
    assert "`expdesign identify` fits them" in caplog.text
    assert len(given[0]) == 20


def test_two_coordinates_of_every_position_calibrate_an_arm_and_are_too_few_for_a_diagnosis() -> None:
    frame = recordings(PLAIN, 90, 11, markers=1).drop(columns=["pz_m", "spz_m"])
    arm = xd.identify(ROBOT, frame).result.arm
    assert arm.accuracy["held out", "position"].after.rms < 2.0 * PLACE * np.sqrt(2.0)
    assert np.all(np.diag(arm.fit.covariance)[arm.minimal.kept] > 0.0)
    with pytest.raises(InputError, match="none of 90 rows has all three coordinates") as refused:
        xd.diagnose(ROBOT, frame)
    assert "`expdesign identify` fits single coordinates" in str(refused.value)


def test_a_dropped_parameter_widens_those_alone_that_stand_for_it() -> None:
    found = MinimalSet(np.array([0, 1]), np.array([2, 3]), np.array([[0.0, 2.0], [0.5, 0.0]]))
    assert found.widened(np.array([3.0, 1.0, np.inf, 8.0])).tolist() == [5.0, np.inf, np.inf, 8.0]
