"""Settings that all tests share."""

from hypothesis import HealthCheck, settings

# The same examples every time, so that a failure on one machine is a failure on every machine.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, max_examples=40, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")
