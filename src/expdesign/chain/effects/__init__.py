"""Physics that the base model leaves out, one effect per file (see `chain/effect.py` for how to add one)."""
