"""`expdesign study` as it is called."""

import builtins
from pathlib import Path
from typing import Any

import pytest
from tests.commands.calls import ROOT, call, refusal

CONFIGURATIONS = ROOT / "configs" / "studies"


def test_a_study_is_made_again_as_it_is_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("study", "bipod-feir", "--out", tmp_path, "--configurations", CONFIGURATIONS) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "bipod-feir" / "README.md")
    for path in (ROOT / "results" / "studies" / "bipod-feir").iterdir():
        if path.suffix != ".svg":  # drawn with another version of the plotting library they are other text
            assert (tmp_path / "bipod-feir" / path.name).read_bytes() == path.read_bytes(), path.name


def test_changed_configuration_changes_the_record(tmp_path: Path) -> None:
    text = (CONFIGURATIONS / "stiffness-mapping.yaml").read_text(encoding="utf-8")
    for name, content in (("same", text + "# a remark\n"), ("other", text.replace("0.75e-6 ", "0.76e-6 "))):
        folder = tmp_path / name
        folder.mkdir()
        shorter = content.replace("../robots", str(ROOT / "configs" / "robots"))
        (folder / "stiffness-mapping.yaml").write_text(shorter, encoding="utf-8")
        assert call("study", "stiffness-mapping", "--out", folder, "--configurations", folder) == 0
    records = [(tmp_path / name / "stiffness-mapping" / "study.json").read_text() for name in ("same", "other")]
    assert records[0] != records[1]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bipod-durr"], "there is no study `bipod-durr`"),
        (["bipod-duir", "--configurations", "nowhere"], "there is no such file"),
    ],
)
def test_wrong_arguments(tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str) -> None:
    assert said in refusal(capsys, "study", *arguments, "--out", tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_wrong_key_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (CONFIGURATIONS / "bipod-feir.yaml").read_text(encoding="utf-8")
    (tmp_path / "bipod-feir.yaml").write_text(text.replace("map_step:", "map_stop:"), encoding="utf-8")
    assert "Did you mean `map_step`?" in refusal(
        capsys, "study", "bipod-feir", "--out", tmp_path / "out", "--configurations", tmp_path
    )


def test_without_the_extra_the_remedy_is_said(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    load = builtins.__import__

    def without(name: str, *arguments: Any, **options: Any) -> Any:
        if name == "matplotlib":
            raise ImportError(name)
        return load(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", without)
    assert "pip install 'expdesign[studies]'" in refusal(capsys, "study", "bipod-feir", "--out", tmp_path)
