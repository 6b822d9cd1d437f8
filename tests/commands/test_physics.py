"""What a robot can have is listed, and every example of the list conceals it in simulated recordings."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import expdesign as xd
from expdesign.arrays import FloatArray
from expdesign.errors import InputError
from tests.commands.calls import CONFIG, ROBOT, ROOT, Printed, call, plan_file

DEFLECTION = ["dx_m", "dy_m", "dz_m", "drx_rad", "dry_rad", "drz_rad"]


def history(folder: Path) -> pd.DataFrame:
    """A plan with times and temperatures."""
    plan = pd.read_csv(plan_file(folder))
    return plan.assign(time_s=100.0 * plan["sequence"], temperature_degC=20.0 + plan["sequence"])


def bent(plan: pd.DataFrame, *texts: str) -> FloatArray:
    """Deflections without noise and load errors."""
    made = xd.simulate(CONFIG, plan, conceal=texts, noise=False, load_errors=False)
    deflections: FloatArray = made.frame[DEFLECTION].to_numpy()
    return deflections


@pytest.fixture(scope="module")
def listed() -> list[dict[str, Any]]:
    entries: list[dict[str, Any]] = xd.physics(ROBOT).record["physics"]
    return entries


def test_the_list_has_what_the_interfaces_name(listed: list[dict[str, Any]]) -> None:
    named = {entry["physics"] for entry in listed}
    assert {"leg_backlash", "creep", "payload_com_offset", "leg_coupling", "base_compliance", "thermal_drift"} <= named
    play = next(entry for entry in listed if entry["physics"] == "leg_backlash")
    assert play["components"] == [f"leg {number}" for number in range(1, 7)]
    assert play["variants"] == ["middle", "short", "long"]
    gap = play["parameters"][0]
    assert (gap["parameter"], gap["unit"], gap["usual"]) == ("gap_m", "m", 1.5e-6)
    assert play["example"] == "leg_backlash at leg 1, middle, 1.5 um"


def test_what_a_body_stands_on_is_listed_in_all_its_forms() -> None:
    body = {"name": "machine", "kind": "body"}
    forms: dict[str, list[str]] = {}
    for entry in xd.physics(body).record["physics"]:
        forms.setdefault(entry["identifier"], []).extend(entry["variants"])
    assert forms["support.compliance"] == ["axes", "rotation", "centre"]
    assert {"along x", "about z"} <= set(forms["support.play"])
    assert "lift-off oblique" in forms["support.nonlinearity"]


def test_every_example_can_be_concealed(listed: list[dict[str, Any]], tmp_path: Path) -> None:
    plan = history(tmp_path)
    concealed = 0
    for entry in listed:
        if "deflections" in entry["shown_in"]:
            assert np.isfinite(bent(plan, entry["example"])).all(), entry["example"]
            concealed += 1
            continue
        with pytest.raises(InputError, match="does not show in deflections"):
            bent(plan, entry["example"] or f"{entry['identifier']} at {entry['components'][0]}")
    assert concealed >= 20
    plain, play = bent(plan), bent(plan, "leg_backlash at leg 4, 5 um")
    assert np.abs(play - plain).max() > 5e-7
    # Play adds to a leg's length: twice the gap moves the platform twice as far.
    wide = bent(plan, "leg_backlash at leg 4, gap_m 10 um")
    np.testing.assert_allclose(wide - plain, 2.0 * (play - plain), rtol=1e-9, atol=1e-15)


def test_several_and_forms_and_usual_sizes(tmp_path: Path) -> None:
    plan = history(tmp_path)
    plain = bent(plan)
    usual = bent(plan, "leg_backlash at leg 4")
    np.testing.assert_array_equal(usual, bent(plan, "leg_backlash at leg 4, 1.5 um, middle"))
    assert np.abs(usual - bent(plan, "leg_backlash at leg 4, short, 1.5 um")).max() > 1e-8
    two = bent(plan, "leg_backlash at leg 4, 5 um", "leg_backlash at leg 1, 5 um") - plain
    each = [bent(plan, f"leg_backlash at leg {leg}, 5 um") - plain for leg in (1, 4)]
    np.testing.assert_allclose(two, sum(each), rtol=1e-9, atol=1e-15)
    assert np.abs(bent(plan, "creep at leg 2, creep_ratio 0.05, tau_s 600 s") - plain).max() > 1e-9
    weighed = np.abs(bent(plan, "payload_mass_error at payload, 98.0665 newton, 0.1") - plain).max(axis=1)
    assert np.flatnonzero(weighed > 1e-12).tolist() == [1]  # the row of 10 kg


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("leg_backlash at leg 4, tall, 5 um", "Forms: `middle`, `short`, `long`. Parameters: `gap_m`."),
        ("leg_backlash at leg 9", "It can be at leg 1, leg 2"),
        ("leg_backlsh at leg 4", "Did you mean `leg_backlash`?"),
        ("leg_backlash", "names no place"),
        ("leg_backlash at leg 4, 5 mrad", "mrad is a unit of angle"),
        ("leg_backlash at leg 4, gap_m 5 m", "5 is not possible. It is from 0 to 0.01."),
        ("payload_com_offset at payload, 1 mm", "Parameters: `com_dx_m`, `com_dy_m`, `com_dz_m`."),
        ("creep at leg 1", "column time_s: the column is missing"),
    ],
)
def test_what_cannot_be_concealed(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as error:
        xd.simulate(CONFIG, plan_file(tmp_path), conceal=text)
    assert said in error.value.message


def test_the_commands(tmp_path: Path, capsys: Printed) -> None:
    assert call("physics", ROBOT) == 0
    printed = capsys.readouterr().out
    assert '--conceal "leg_backlash at leg 1, middle, 1.5 um"' in printed
    assert "forms: middle, short, long" in printed
    assert call("physics", ROOT / "configs/robots/ur5.yaml", "--json") == 0
    record = json.loads(capsys.readouterr().out)
    assert {"joint_backlash", "link_compliance"} <= {entry["physics"] for entry in record["physics"]}
    plan, out = plan_file(tmp_path), tmp_path / "rows.csv"
    hidden = ("--conceal", "leg_backlash at leg 4, 5 um", "--conceal", "load_direction_tilt at payload")
    assert call("simulate", CONFIG, plan, "--out", out, *hidden) == 0
    assert len(pd.read_csv(out)) == 4
