"""Design of experiments: what can be measured, what is wanted, and the search for the best plans."""
