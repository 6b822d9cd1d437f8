"""Fits of recordings: parameters, noise, intervals, what can be identified, prediction and compensation."""
