"""The figure that suits a dataset."""

from __future__ import annotations

import xarray as xr
from matplotlib.figure import Figure

from rotor_ida.cli.describe import kind_of
from rotor_ida.errors import InputError
from rotor_ida.plot.figures import FIGURES


def figure_of(dataset: xr.Dataset) -> Figure:
    """Return the figure of a dataset; of a sweep with the exact curve behind it."""
    kind = kind_of(dataset)
    if kind not in FIGURES:
        raise InputError(
            "figure must be of a run, of whirls, their folds or Hopf points, of a sweep, run-ups, "
            "a basin or atlas, of limit cycles, of signals, their orders or spectra, or of a fit, "
            f"got {kind!r}"
        )
    return FIGURES[kind](dataset)
