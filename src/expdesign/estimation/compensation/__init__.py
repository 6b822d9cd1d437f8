"""Prediction and compensation: what an identified robot does under a load, and the commands that undo it."""
