"""The dataset of one simulated run."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import State
from rotor_ida.dataset.contacts import contact_variables
from rotor_ida.dataset.provenance import provenance
from rotor_ida.schema import labelled
from rotor_ida.simulator.orbit import Orbit
from rotor_ida.simulator.trust import Trust


def run_dataset(orbit: Orbit, start: State, trust: Trust) -> xr.Dataset:
    """Return a simulated orbit as a labelled dataset.

    Parameters
    ----------
    orbit : Orbit
        The orbit.
    start : tuple of float
        Its start ``(x, y, vx, vy)`` [1].
    trust : Trust
        What is known of its error.
    """
    rotor = orbit.rotor
    variables = {
        **_columns(("x", "y", "vx", "vy"), "time", orbit.states),
        "starts_in_contact": labelled("starts_in_contact", (), np.int8(orbit.starts_in_contact)),
        **event_variables(orbit.event_times, orbit.event_kinds, orbit.event_states),
        "event_time_error": labelled("event_time_error", "event", trust.event_time_errors),
        "horizon": labelled("horizon", (), trust.horizon),
        **contact_variables(orbit),
    }
    parameters = {"omega": rotor.omega, "zeta": rotor.zeta, "delta0": rotor.delta0}
    coordinates = {name: labelled(name, (), value) for name, value in parameters.items()}
    coordinates["time"] = labelled("time", "time", orbit.times)
    attributes = provenance("Rotor in a clearance: one simulated run", orbit.options)
    attributes |= {
        **parameters,
        "start": np.array(start),
        "duration": orbit.duration,
        "evaluations": orbit.evaluations,
    }
    return xr.Dataset(variables, coordinates, attributes)


def event_variables(
    times: npt.NDArray[np.float64],
    kinds: npt.NDArray[np.int8],
    states: npt.NDArray[np.float64],
) -> dict[str, xr.Variable]:
    """Return the table of events as variables on the dimension ``event``."""
    return {
        "event_time": labelled("event_time", "event", times),
        "event_kind": labelled("event_kind", "event", kinds),
        **_columns(("event_x", "event_y", "event_vx", "event_vy"), "event", states),
    }


def _columns(
    names: tuple[str, ...], dim: str, table: npt.NDArray[np.float64]
) -> dict[str, xr.Variable]:
    return {
        name: labelled(name, dim, np.ascontiguousarray(column))
        for name, column in zip(names, table.T, strict=True)
    }
