"""Calibration of arms from positions, by this program and by what people use, on the same rows."""
