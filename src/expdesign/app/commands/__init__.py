"""The command line: one file per command, found by its place."""

import os
import time

# The matrices of this program are small, and threads of the linear algebra library cost more than they give. This
# stands before NumPy is first imported; whoever uses the package as a library decides for themselves.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

BEGUN = time.perf_counter() - time.process_time()
"""s of the clock at which the program began, but for what it waited for the machine until here."""
