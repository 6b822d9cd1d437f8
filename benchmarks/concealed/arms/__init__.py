"""Concealed physics of serial arms, by the mechanics of pinocchio."""
