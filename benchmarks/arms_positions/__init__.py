"""Calibration of arms from positions, against what people use: errors of left-out fifths of the poses, and times."""
