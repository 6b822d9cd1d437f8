"""Criteria of a design, one per file; a new one is found by lying here (see `criterion.py`)."""
