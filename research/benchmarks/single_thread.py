"""Linear algebra in one thread: small matrices are slower in several, and times cannot be compared.

The concealed cases know nothing of the package, so that its own (`app/sweeps/engine.py`) is not called here.
"""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final

ONE_THREAD: Final = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment of a process whose linear algebra has one thread."""


@contextmanager
def single_threaded() -> Iterator[None]:
    """Processes started in here do their linear algebra in one thread."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(ONE_THREAD)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
