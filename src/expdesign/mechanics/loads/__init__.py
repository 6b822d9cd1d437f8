"""Loads on the platform, and the sources of error in them, as symbolic wrenches."""
