"""What is there, by evidence: laws and effects as columns, weighed together."""
