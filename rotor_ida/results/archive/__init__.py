"""Save datasets in netCDF files: written atomically, and checked when read back.

This package needs labelled datasets only, so files can be read, compared and plotted without a
solver.
"""

from rotor_ida.results.archive.reading import load, open_archive
from rotor_ida.results.archive.writing import save

__all__ = ["load", "open_archive", "save"]
