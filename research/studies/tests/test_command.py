"""`python -m research.studies` as it is called."""

from pathlib import Path

import pytest

from research.studies.__main__ import main
from tests.commands.calls import ROOT

CONFIGURATIONS = ROOT / "configs" / "studies"


def test_a_study_is_made_again_as_it_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bipod-feir", "--out", str(tmp_path), "--configurations", str(CONFIGURATIONS)]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "bipod-feir" / "README.md")
    for path in (ROOT / "results" / "studies" / "bipod-feir").iterdir():
        if path.suffix != ".svg":  # drawn with another version of the plotting library they are other text
            assert (tmp_path / "bipod-feir" / path.name).read_bytes() == path.read_bytes(), path.name


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bipod-durr"], "there is no study `bipod-durr`"),
        (["bipod-duir", "--configurations", "nowhere"], "there is no such file"),
    ],
)
def test_wrong_arguments(tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str) -> None:
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_wrong_key_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (CONFIGURATIONS / "bipod-feir.yaml").read_text(encoding="utf-8")
    (tmp_path / "bipod-feir.yaml").write_text(text.replace("map_step:", "map_stop:"), encoding="utf-8")
    assert main(["bipod-feir", "--out", str(tmp_path / "out"), "--configurations", str(tmp_path)]) == 2
    assert "Did you mean `map_step`?" in capsys.readouterr().err
