"""Every plot of every kind of dataset: drawn, or refused in one line."""

from __future__ import annotations

from functools import cache

import pytest
import xarray as xr

from rotor_ida import RotorError, plot
from rotor_ida.plot.appearance import without_pyplot
from tests.example_datasets import KINDS

# What a plot needs beside its dataset.
BESIDE = {"save_orbit_film": {"path": "film.gif", "frames": 2}}
PLOTS = [name for name in dir(plot) if name.startswith("plot_") or name in BESIDE]


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
