"""Recordings: what was measured, under which commands and loads, as a person wrote it down."""
