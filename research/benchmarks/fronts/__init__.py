"""Fronts and bounds on configurations that nobody tuned to: random ones, long searches, and what is missing."""
