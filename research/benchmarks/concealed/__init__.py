"""Proof of `expdesign diagnose` on recordings whose physics is concealed from it.

`python -m research.benchmarks.concealed.run` generates cases, diagnoses them and scores the answers. The cases come
from the virtual laboratory; nothing here imports the program that is put to the test.
"""
