"""A robot as it was found: its chain with values and covariance, and the file that holds it."""
