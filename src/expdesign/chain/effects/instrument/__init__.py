"""The instrument does not read what it seems to."""
