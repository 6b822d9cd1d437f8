"""What is misspelt in a file of any kind is answered with the nearest name that is known there."""

from pathlib import Path

import pytest

from tests.commands.calls import ROOT, call

CONFIGS = ROOT / "configs"
SLIPS = {
    "robots/hexapod-h1.yaml": [("actuator_stiffness:", "actuator_stifness:"), ("kind: hexapod", "kind: hexpod")],
    "robots/ur5.yaml": [("base_link:", "bas_link:")],
    "bipod.yaml": [
        ("measurements:", "measurments:"),
        ("duir, feir", "duri, feir"),
        ("source: wrench", "source: wrenc"),
        ("fy_N:", "fyN:"),
        ("bounds: {x_m", "bounds: {xm"),
        ("std: {dx_m", "std: {dx_mm"),
        ("optimiser:", "optimizer:"),
    ],
    "sweep-bipod.yaml": [("vary:", "vry:"), ("optimiser.seed", "optimizer.seed"), ("from:", "form:")],
}


@pytest.mark.parametrize(("file", "right", "wrong"), [(f, *pair) for f, pairs in SLIPS.items() for pair in pairs])
def test_the_nearest_name_is_suggested(
    file: str, right: str, wrong: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (CONFIGS / file).read_text(encoding="utf-8")
    assert right in text
    for name in ("robots/bipod.yaml", "ur5.urdf", "config: bipod.yaml"):
        folder = CONFIGS / "robots" if name == "ur5.urdf" else CONFIGS
        key, _, plain = name.rpartition(": ")
        text = text.replace(name, f"{key}: {folder / plain}" if key else str(folder / plain))
    path = tmp_path / "file.yaml"
    path.write_text(text.replace(right, wrong), encoding="utf-8")
    assert call("check", path) == 2
    message = capsys.readouterr().err.strip().splitlines()[-1]
    assert "Did you mean `" in message
    suggested = message.split("Did you mean `")[1].split("`")[0]
    assert suggested in right, message
