"""Settings that all tests share."""

import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# The same examples every time, so that a failure on one machine is a failure on every machine.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")

# A shell that starts tests in the background ignores Ctrl-C, which some of them press.
signal.signal(signal.SIGINT, signal.default_int_handler)

BESIDE_THE_PACKAGE = ("benchmarks", "studies", "virtual_laboratory", "release")
"""Folders of tests of what stands beside the package: they are proofs, which `make proof` runs."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of benchmarks, studies, laboratory and distribution as proofs."""
    root = Path(__file__).parent
    for item in items:
        if item.path.relative_to(root).parts[0] in BESIDE_THE_PACKAGE:
            item.add_marker(pytest.mark.slow)
