"""Regressors: what is calibrated, and how each of its parameters moves the platform; one file each."""
