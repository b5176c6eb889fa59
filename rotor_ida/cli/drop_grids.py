"""Words for grids of drops: what varies, where a drop lies, and the cells."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from rotor_ida.schema import OF_DROP

if TYPE_CHECKING:
    import xarray as xr


def varying(drops: xr.Dataset, prefix: str = "drop") -> list[str]:
    """Return the names of what differs between drops, or between cells."""
    return [
        name for name in OF_DROP
        if f"{prefix}_{name}" in drops.variables and np.ptp(drops[f"{prefix}_{name}"].values) > 0.0
    ]  # fmt: skip


def place_of(drops: xr.Dataset, number: int) -> str:
    """Return where a drop lies on a grid, by the values of `places_in`.

    Examples
    --------
    >>> import xarray as xr
    >>> values = {"phase": [0.0, 1.0], "friction": [0.1, 0.3]}
    >>> drops = xr.Dataset({f"drop_{name}": ("drop", each) for name, each in values.items()})
    >>> place_of(drops, 1), place_of(drops, -1)
    ('57.3 deg, 0.3', '-')
    """
    if number < 0:
        return "-"
    values = {name: float(drops[f"drop_{name}"][number]) for name in varying(drops)}
    return ", ".join(
        f"{math.degrees(each):.4g} deg" if name == "phase" else f"{each:.4g}"
        for name, each in values.items()
    )


def places_in(drops: xr.Dataset) -> str:
    """Return what the numbers of a place are."""
    return ", ".join(OF_DROP[name] for name in varying(drops))


def count_of(drops: xr.Dataset, name: str) -> int:
    """Return the number of drops that have a figure: some bearings never whirl, roll or rest."""
    return int((drops[name].notnull() & (drops["status"] == 0)).sum())


def cells_in(drops: xr.Dataset) -> list[str]:
    """Return the names of the variables of cells, in the order of their table."""
    return [f"cell_{name}" for name in varying(drops, "cell")]
