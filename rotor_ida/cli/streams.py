"""Standard output kept for results.

SUNDIALS, a C library, prints its complaints to file descriptor 1. While a command runs, that
descriptor leads to standard error, and a copy of the old one takes the results.
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
    """Yield where results go; whatever else is written to standard output is an aside.

    The one who writes to the stream flushes it, and meets the error of a full disk or a closed
    pipe there.
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
    """Let no file that is opened later become a standard stream that the caller closed.

    A closed output takes nothing: who writes results there meets an error, as they would be lost.
    """
    for descriptor in (0, OUTPUT, ERRORS):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDONLY if descriptor == OUTPUT else os.O_RDWR)


def _flush_c_library() -> None:
    """Empty C's own buffers while its standard output still leads to standard error."""
    with suppress(OSError, AttributeError):
        library = ctypes.CDLL("ucrtbase" if os.name == "nt" else None)
        library.fflush(None)
