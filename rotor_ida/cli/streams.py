"""Reserve standard output for results.

SUNDIALS, a C library, prints its messages to file descriptor 1. While a command runs, that
descriptor leads to standard error, and a copy of the original one receives the results.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
from typing import TextIO

OUTPUT, ERRORS = 1, 2


@contextmanager
def results_only() -> Iterator[TextIO]:
    """Yield the stream for results; other writes to standard output go to standard error.

    The caller must flush the stream, and then gets the error of a full disk or a closed pipe.
    """
    _fill_closed_descriptors()
    kept = os.dup(OUTPUT)
    stream, ours = _stream_of(kept)
    os.dup2(ERRORS, OUTPUT)
    try:
        with redirect_stdout(sys.stderr):
            yield stream
    finally:
        if ours:
            with suppress(OSError):
                stream.close()
        _flush_c_library()
        os.dup2(kept, OUTPUT)
        os.close(kept)


def _stream_of(descriptor: int) -> tuple[TextIO, bool]:
    """Return a stream for results, and whether it was opened here."""
    current = sys.stdout
    if current is None:  # closed by the caller
        return open(os.dup(descriptor), "w", encoding="utf-8"), True
    current.flush()
    try:
        captured = current.fileno() != OUTPUT
    except (OSError, AttributeError):
        captured = True
    if captured:
        return current, False
    return open(os.dup(descriptor), "w", encoding=current.encoding, errors="backslashreplace"), True


def _fill_closed_descriptors() -> None:
    """Keep files opened later from replacing a standard stream that the caller closed.

    Writing results to a closed output raises an error, since they would be lost.
    """
    for descriptor in (0, OUTPUT, ERRORS):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDONLY if descriptor == OUTPUT else os.O_RDWR)


def _flush_c_library() -> None:
    """Flush the buffers of C while its standard output still leads to standard error."""
    with suppress(OSError, AttributeError):
        library = ctypes.CDLL("ucrtbase" if os.name == "nt" else None)
        library.fflush(None)
