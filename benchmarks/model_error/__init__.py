"""Machines with physics that the model leaves out, and what a plan is worth on them."""
