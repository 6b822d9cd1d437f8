"""Identification: from recordings to compliances, with an honest account of how well they are known."""
