"""Studies on the command line: whatever ends one, say how to go on."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import contextmanager

import rotor_ida
from rotor_ida.errors import ArchiveError, InputError, RotorError, SimulationError


@contextmanager
def studied(folder: str | None) -> Iterator[None]:
    """Add to what breaks a study off how much is kept, and how to go on."""
    try:
        yield
    except InputError:
        raise
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted{going_on(folder)}") from None
    except SimulationError as error:
        raise RotorError(f"{error}{going_on(folder)}") from error
    except (ArchiveError, MemoryError) as error:
        raise RotorError(f"{error or 'not enough memory'}{going_on(folder)}") from error


def going_on(folder: str | None) -> str:
    """Return how to go on with a study; nothing if there is none."""
    if folder is None:
        return ""
    try:
        found = rotor_ida.status(folder)
    except RotorError:
        return ""
    word = f"./{folder}" if folder.startswith("-") else folder  # else it would be an option
    return (
        f"; {found['done']} of {found['points']} points are kept in {folder}: go on with "
        f"rotor-ida resume {shlex.quote(word)}"
    )
