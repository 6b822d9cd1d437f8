"""What an instrument reads of a platform that moves: strategies that a chain ends with, chosen once for recordings."""
