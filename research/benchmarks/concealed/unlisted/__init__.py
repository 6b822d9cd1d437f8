"""Concealed physics outside the library: recipes, cases, the run and its score."""
