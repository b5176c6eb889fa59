"""Every plot of every kind of dataset: drawn, or refused in one line."""

from __future__ import annotations

import inspect
from functools import cache

import matplotlib.pyplot as plt
import pytest
import xarray as xr

from rotor_ida import RotorError, plot
from rotor_ida.plot.appearance import without_pyplot
from tests.kinds import KINDS

# What a plot needs beside its dataset.
BESIDE = {
    "plot_by_clearance": {"names": {"amplitude": "whirls"}, "label": "amplitude"},
    "plot_by_damping": {"quantity": "amplitude"},
    "plot_cuts": {"name": "x", "at": [0.0]},
    "plot_history": {"name": "x"},
    "plot_jumps": {"ax": plt.Figure().subplots()},
    "plot_node_history": {"node": "disc"},
    "plot_surface": {"name": "x"},
    "save_orbit_film": {"path": "film.gif", "frames": 2},
}
PLOTS = [
    name
    for name in plot.__all__
    if "Dataset" in str([*inspect.signature(getattr(plot, name)).parameters.values()][:1])
]


@cache
def made(kind: str) -> xr.Dataset:
    return KINDS[kind]()


@pytest.mark.parametrize("name", PLOTS)
def test_other_kinds_are_refused_in_one_line_or_drawn(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    troubles = []
    with without_pyplot():
        for kind in KINDS:
            try:
                getattr(plot, name)(made(kind), **BESIDE.get(name, {}))
            except RotorError as error:
                if "\n" in str(error):
                    troubles.append(f"{kind}: {error}")
            except Exception as error:
                troubles.append(f"{kind}: raw {type(error).__name__}: {error}")
    assert not troubles, "\n".join(troubles)


def test_the_plots_are_many():
    assert len(PLOTS) > 70
