"""The small arm of `tests.chain.arms`, read once for all tests."""

import pytest

from expdesign.mechanics.robots.serial import SerialRobot
from tests.chain.arms import read_arm


@pytest.fixture(scope="session")
def arm(tmp_path_factory: pytest.TempPathFactory) -> SerialRobot:
    return read_arm(tmp_path_factory.mktemp("arm"))
