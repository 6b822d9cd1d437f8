"""How fast, and how close to the best possible, the design search is: `python -m benchmarks.optimality.run_all`."""
