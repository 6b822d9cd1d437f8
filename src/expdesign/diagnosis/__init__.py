"""Diagnosis: where recordings and model differ, which physics was left out, and whether adding it helps."""
