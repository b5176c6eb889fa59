"""Whether a run contradicts the mechanics, by the core."""

from __future__ import annotations

from ctypes import byref, c_int64
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.interface import RotorStruct, RunStruct, address, library_of
from rotor_ida.core.runs import CONTACT, Rows
from rotor_ida.model.rotor import Rotor

# Contradictions of a run to the mechanics, by the names of `enum fault` and in its order.
MESSAGE_OF_FAULT = {
    "SOUND": "",
    "EVENT_NOT_FINITE": "the state is not finite",
    "BACKWARDS": "event times do not increase",
    "NOT_IN_TURN": "entry and exit, or press and release, do not alternate",
    "OFF_THE_RING": "an event does not lie at |z| = delta0, or lies off the stator",
    "SAMPLE_NOT_FINITE": "the state is not finite",
    "WRONG_SIDE_OF_THE_RING": "a sample lies on the wrong side of the stator",
    "TENSILE": "the normal force of a sample is below 0, or missing where it is not",
    "SLIDES_ASTRAY": "surfaces slide in a sense that contradicts the events",
    "SLIPS_WHILE_ROLLING": "the disc slips, or lacks grip, where it should roll",
    "PEAKS_OUTSIDE": "a contact peaks outside its own span",
}
FAULTS = tuple(MESSAGE_OF_FAULT.values())
# The first fault of samples, after those of events; and the first of contacts.
FIRST_OF_SAMPLES = [*MESSAGE_OF_FAULT].index("SAMPLE_NOT_FINITE")
OF_CONTACTS = [*MESSAGE_OF_FAULT].index("PEAKS_OUTSIDE")


class Samples(NamedTuple):
    """Times and states of samples, in either frame [dimensionless]."""

    times: Values
    states: Values


class Events(NamedTuple):
    """Times, kinds and states of events, in the frame of the samples [dimensionless]."""

    times: Values
    kinds: npt.NDArray[np.int8]
    states: Values


def fault_of(
    rotor: Rotor,
    samples: Samples,
    events: Events,
    contacts: Rows,
    *,
    began: int,
    allowed: float,
    modes: npt.NDArray[np.int8] | None = None,
) -> tuple[int, int]:
    """Return the first contradiction of a run to the mechanics, by `FAULTS`, and its row.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    samples, events : Samples, Events
        The data to check.
    contacts : ndarray of `CONTACT`
        The contacts [dimensionless].
    began : int
        Whether it began in contact.
    allowed : float
        How far a sample may lie on the wrong side of the stator [dimensionless].
    modes : ndarray, shape (m + 1,), optional
        With friction, the mode from the start, and from each event on.
    """
    run, row = RunStruct(rotor=RotorStruct.of(rotor), began=began), c_int64(0)
    sampled, happened = len(samples.times), len(events.times)
    tables = {
        "sample_times": _table(samples.times, np.float64, (sampled,)),
        "samples": _table(samples.states, np.float64, (sampled, 4)),
        "event_times": _table(events.times, np.float64, (happened,)),
        "event_kinds": _table(events.kinds, np.int8, (happened,)),
        "event_states": _table(events.states, np.float64, (happened, 4)),
        "contacts": _table(contacts, contacts.dtype, (len(contacts),)),
    }
    if contacts.dtype.itemsize != CONTACT.itemsize:
        raise ValueError(f"contacts must be rows of {CONTACT}, got {contacts.dtype}")
    if modes is not None:
        modes = _table(modes, np.int8, (happened + 1,))
        run.mode_began = int(modes[0])
        tables["event_modes"] = np.append(modes[1:], np.int8(0))
    for name, table in tables.items():
        setattr(run, name, address(table))
    run.sampled, run.events, run.contact_count = sampled, happened, len(contacts)
    return int(library_of(rotor).core_fault(byref(run), allowed, byref(row))), row.value


def _table(
    table: npt.NDArray[Any], dtype: npt.DTypeLike, shape: tuple[int, ...]
) -> npt.NDArray[Any]:
    """Return a table as the core reads it, or raise `ValueError` if its shape is wrong."""
    if table.shape != shape:
        raise ValueError(f"tables must fit together, got {table.shape} instead of {shape}")
    return np.ascontiguousarray(table, dtype)
