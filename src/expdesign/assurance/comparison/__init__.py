"""Designs side by side: which criterion's design is accurate in the end, and how well each criterion foretells it."""
