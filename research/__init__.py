"""What proves the product and is no part of it: an independent laboratory, the thesis' studies, benchmarks."""
