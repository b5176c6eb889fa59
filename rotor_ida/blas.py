"""How many threads linear algebra takes.

The matrices of a rotor have tens of rows. Threads for a product of them wait for each other longer
than they compute, and on busy processors several times as long.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

# Read when NumPy and SciPy are imported: OpenBLAS is in their wheels, MKL in some of conda.
VARIABLES = ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def one_thread() -> Iterator[None]:
    """Let programs that begin meanwhile, and this one if it is new, compute in one thread each.

    What the environment says already stays.

    Examples
    --------
    >>> with one_thread():
    ...     "OPENBLAS_NUM_THREADS" in os.environ
    True
    """
    missing = [name for name in VARIABLES if name not in os.environ]
    os.environ |= dict.fromkeys(missing, "1")
    try:
        yield
    finally:
        for name in missing:
            os.environ.pop(name, None)
