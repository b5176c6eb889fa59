"""The numbers of limit cycles as labelled columns: of one, of a branch, of a bifurcation curve."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.multipliers import defects_of, is_stable, multipliers_of
from rotor_ida.cycles.shooting import Cycle
from rotor_ida.schema import QUANTITIES, RESPONSE, STABILITY, Column


def cycle_columns(cycles: Sequence[Cycle], dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return the numbers of cycles, one after the other on a dimension; names get the prefix."""
    found = np.array([multipliers_of(cycle.shot) for cycle in cycles]).reshape(len(cycles), 4)
    defects = np.array([defects_of(cycle.shot) for cycle in cycles]).reshape(len(cycles), 2)
    stable = [STABILITY["stable" if is_stable(cycle.shot) else "unstable"] for cycle in cycles]
    columns: dict[str, Column] = {
        "period": (dim, _of(cycles, "period")),
        "radius_min": (dim, _of(cycles, "radius_min")),
        "radius_max": (dim, _of(cycles, "radius_max")),
        "response": (dim, np.array([RESPONSE[cycle.response] for cycle in cycles], dtype=np.int8)),
        "stability": (dim, np.array(stable, dtype=np.int8)),
        "contact_count": (dim, np.array([cycle.contacts for cycle in cycles], dtype=np.int64)),
        "largest_force": (dim, _of(cycles, "largest_force")),
        "impulse_per_period": (dim, _of(cycles, "impulse")),
        "multiplier_real": ((dim, "multiplier"), found.real),
        "multiplier_imag": ((dim, "multiplier"), found.imag),
        "trace": (dim, np.array([float(cycle.shot.monodromy.trace()) for cycle in cycles])),
        "residual": (dim, _of(cycles, "residual")),
        "trivial_defect": (dim, defects[:, 0]),
        "symplectic_defect": (dim, defects[:, 1]),
    }
    states = np.array([cycle.state for cycle in cycles]).reshape(len(cycles), 4)
    return {
        f"{prefix}{name}": of_cycle(name, *column) for name, column in columns.items()
    } | state_columns(states, dim, prefix)


def state_columns(states: Values, dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return states on the rotating axes, shape (n, 4), as variables ``x y vx vy``."""
    return {
        f"{prefix}{name}": xr.Variable(
            dim, np.ascontiguousarray(column), QUANTITIES[f"rotating_{name}"].attributes()
        )
        for name, column in zip(COMPONENTS, states.T, strict=True)
    }


def of_cycle(name: str, dims: Hashable | Sequence[Hashable], values: npt.ArrayLike) -> xr.Variable:
    """Return a variable of limit cycles, labelled so where its name serves other things too."""
    quantity = QUANTITIES[f"cycle_{name}" if f"cycle_{name}" in QUANTITIES else name]
    return xr.Variable(dims, np.asarray(values), quantity.attributes())


def _of(cycles: Sequence[Cycle], name: str) -> Values:
    return np.array([getattr(cycle, name) for cycle in cycles], dtype=np.float64)
