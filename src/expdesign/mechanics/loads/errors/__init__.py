"""Sources of error in the applied load, one per file (theory.md 5.2)."""
