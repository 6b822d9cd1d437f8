"""Geometric calibration of a hexapod against forward kinematics of its own; `python -m benchmarks.geometry`."""
