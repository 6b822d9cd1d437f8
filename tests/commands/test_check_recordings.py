"""`expdesign check` on recordings."""

from pathlib import Path

import pandas as pd
import pytest
from tests.commands.calls import ROBOT, call, plan_file, recordings_file, refusal


def test_what_is_wrong_or_not_identifiable_ends_with_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recordings = recordings_file(tmp_path)
    frame = pd.read_csv(recordings)
    frame.drop(columns=[name for name in frame if name[0] == "d" and name != "dz_m"]).iloc[:3].to_csv(
        recordings, index=False
    )
    capsys.readouterr()
    assert call("check", recordings) == 0
    assert "3 readings cannot determine 6 compliances" in refusal(capsys, "check", recordings, "--robot", ROBOT)
    assert "no measured column" in refusal(capsys, "check", plan_file(tmp_path))
