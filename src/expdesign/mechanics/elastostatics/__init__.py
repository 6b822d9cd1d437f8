"""Elastostatics: what the loads do to the robot, linear in the compliances of its actuators."""
