"""Exact derivatives of the criteria, and what they make possible: a polished front, its optimality, and its bounds."""
