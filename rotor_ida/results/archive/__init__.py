"""Datasets kept in netCDF files: wholly written or not at all, and checked when read back.

This package sees labelled datasets only, so that a file can be read, compared and plotted where
no solver is installed.
"""

from rotor_ida.results.archive.reading import load, open_archive
from rotor_ida.results.archive.writing import save

__all__ = ["load", "open_archive", "save"]
