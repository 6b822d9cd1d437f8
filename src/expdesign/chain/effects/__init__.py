"""Physics that the base model leaves out, by where it acts (see `chain/effect.py` for how to add one)."""
