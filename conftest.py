"""Settings that all tests share."""

import os
import signal

import pytest
from hypothesis import HealthCheck, settings

from tests.proofs import proof_of

# Two processes of tests with threads for their linear algebra wait for each other several times as long as they
# compute. NumPy reads this when it is imported, which nothing has done yet.
for _library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{_library}_NUM_THREADS", "1")

# The same examples every time, so that a failure on one machine is a failure on every machine.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, max_examples=20, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")

# A shell that starts tests in the background ignores Ctrl-C, which some of them press.
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark proofs, which `make proof` runs."""
    for item in items:
        if proof_of(item.nodeid.removeprefix("tests/")) is not None:
            item.add_marker(pytest.mark.slow)
