"""Measurements made ready: points registered to deflections, poses freed of thermal deflection."""
