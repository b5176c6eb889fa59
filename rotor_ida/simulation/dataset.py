"""The dataset of one simulated run: how it is built, and how it is recognised."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import COMPONENTS, State
from rotor_ida.model.contact import clipped_factor, contact_force
from rotor_ida.results.provenance import provenance
from rotor_ida.results.run import event_columns, parameter_coordinates
from rotor_ida.schema import (
    Column,
    labelled_dataset,
)
from rotor_ida.schema.flags import FLIES, IS_LOOSE, ROLLS
from rotor_ida.simulation.contact_table import contact_columns
from rotor_ida.simulation.event_errors import EventErrors
from rotor_ida.simulation.orbit import Orbit


def run_dataset(
    orbit: Orbit,
    start: State,
    errors: EventErrors,
    changes: Mapping[str, object] | None = None,
) -> xr.Dataset:
    """Return a simulated orbit as a labelled dataset.

    Parameters
    ----------
    orbit : Orbit
        The orbit.
    start : tuple of float
        Its start ``(x, y, vx, vy)`` [1].
    errors : EventErrors
        Errors of its events.
    changes : mapping, optional
        The requested change of speed, as attributes.
    """
    variables: dict[str, Column | xr.Variable] = {
        **_columns("", "t", orbit.states),
        "starts_in_contact": ((), np.int8(orbit.starts_in_contact)),
        **event_columns(orbit.event_times, orbit.event_kinds, orbit.rotor),
        **_columns("event_", "event", orbit.event_states),
        "event_time_error": ("event", errors.event_time_errors),
        "horizon": ((), errors.horizon),
        **motion_columns(orbit),
    }
    coordinates = parameter_coordinates(orbit.rotor) | {"t": ("t", orbit.times)}
    attributes = provenance(orbit.options.attributes()) | {
        **orbit.rotor.given,
        "start": np.array(start),
        "duration": orbit.duration,
        "evaluations": orbit.evaluations,
        **(changes or {}),
    }
    title = "Rotor in a clearance: one simulated run"
    if orbit.speed_record is not None:
        title = "Rotor in a clearance: one run at a speed that changes"
    return labelled_dataset(title, variables, coordinates, attributes, kind="run")


def motion_columns(orbit: Orbit) -> dict[str, Column]:
    """Return the samples of an orbit, with how fast it spins, and its contacts."""
    return {
        **_columns("", "t", orbit.states),
        **contact_columns(orbit),
        **_friction(orbit),
        **_spins(orbit),
    }


def arrays_of(orbit: Orbit) -> dict[str, npt.NDArray[Any]]:
    """Return samples, events and contacts of an orbit by their names in its dataset."""
    columns: dict[str, npt.NDArray[Any]] = {
        name: np.asarray(each[1]) for name, each in motion_columns(orbit).items()
    }
    columns |= {"event_time": orbit.event_times, "event_kind": orbit.event_kinds}
    return {"t": orbit.times, **columns}


def _friction(orbit: Orbit) -> dict[str, Column]:
    """Return how the rotor moves at each sample, its slip speed and its normal force."""
    if orbit.modes is None:
        return {}
    rotor, (x, y, vx, vy) = orbit.rotor, orbit.states.T
    modes = orbit.modes[np.searchsorted(orbit.event_times, orbit.times, side="right")]
    radius = np.hypot(x, y)
    along, across = (
        np.divide(part, radius, out=np.zeros_like(radius), where=radius > 0.0)
        for part in (x * vx + y * vy, x * vy - y * vx)
    )
    spring = contact_force(radius, rotor.delta0, rotor.contact_exponent)
    pushes = (modes != FLIES) & (modes != IS_LOOSE)
    force = np.where(pushes, spring * clipped_factor(along, rotor.contact_damping), 0.0)
    slip = np.where(modes == ROLLS, 0.0, across + (rotor.disc_radius or 0.0) * orbit.speeds)
    return {"mode": ("t", modes), "slip_speed": ("t", slip), "normal_force": ("t", force)}


def _spins(orbit: Orbit) -> dict[str, Column]:
    """Return how fast the rotor spins, and where its unbalance is, if the speed changes."""
    record = orbit.speed_record
    if record is None:
        return {}
    return {
        "speed": ("t", np.ascontiguousarray(record.samples["speed"])),
        "angle": ("t", np.ascontiguousarray(record.samples["angle"])),
        "event_speed": ("event", np.ascontiguousarray(record.events["speed"])),
        "event_angle": ("event", np.ascontiguousarray(record.events["angle"])),
        "revolutions": ((), record.end["angle"] / (2.0 * math.pi)),
    }


def _columns(prefix: str, dim: str, table: npt.NDArray[np.float64]) -> dict[str, Column]:
    columns = np.ascontiguousarray(table.T)
    return {
        f"{prefix}{name}": (dim, column) for name, column in zip(COMPONENTS, columns, strict=True)
    }
