"""The command line: one file per command, found by its place."""

import os

# The matrices of this program are small, and threads of the linear algebra library cost more than they give. This
# stands before NumPy is first imported; whoever uses the package as a library decides for themselves.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
