"""Criteria of a design: of accuracy in `accuracy.py`, O1 to O5 in `observability.py`; the rest is what they share.

A new criterion is a file of its own here, where it is found (`criterion.py`, docs/extending.md).

MEIR, which needs the physics that a model leaves out, lies in `assurance/model_error` (`ELSEWHERE` in `plugins.py`).
"""
