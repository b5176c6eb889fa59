"""Archives as input: a file that cannot be used is a mistake in the input."""

from __future__ import annotations

from typing import TYPE_CHECKING

import rotor_ida
from rotor_ida.errors import ArchiveError, InputError

if TYPE_CHECKING:
    import xarray as xr


def read(file: str) -> xr.Dataset:
    """Return the dataset in an archive."""
    try:
        return rotor_ida.load(file)
    except ArchiveError as error:
        raise InputError(str(error)) from error
