"""The instrument that measures deflections: its noise, and what its readings have in common."""
