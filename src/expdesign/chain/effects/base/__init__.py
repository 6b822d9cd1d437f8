"""The base of a robot."""
