"""Robots: each kind is one file that gives its geometry file and one symbolic expression of its kinematics."""
