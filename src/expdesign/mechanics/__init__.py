"""Robots, loads, kinematics and elastostatics, as symbolic expressions with exact derivatives."""
