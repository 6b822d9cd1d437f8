"""Plan and evaluate the calibration of robots that carry loads."""

__version__ = "0.1.0"
