"""Many runs of one program with other values: what they are, where they run, and where their results are kept."""
