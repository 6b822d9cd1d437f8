"""Criteria of a design, one per file; a new one is found by lying here (see `criterion.py`).

MEIR, which needs the physics that a model leaves out, lies in `assurance/model_error` (`ELSEWHERE` in `plugins.py`).
"""
