"""Whether a run contradicts the mechanics, by the core."""

from __future__ import annotations

from ctypes import byref, c_int64
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.core.interface import RotorStruct, RunStruct, address, library_of
from rotor_ida.core.runs import Rows
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


def fault_of(
    rotor: Rotor, samples: tuple[Values, Values],
    events: tuple[Values, npt.NDArray[np.int8], Values], contacts: Rows, *, began: int,
    allowed: float, modes: npt.NDArray[np.int8] | None = None,
) -> tuple[int, int]:  # fmt: skip
    """Return the first contradiction of a run to the mechanics, by `FAULTS`, and its row.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    samples : tuple of ndarray
        Times and states of samples, in either frame [dimensionless].
    events : tuple of ndarray
        Times, kinds and states of events, in the frame of the samples [dimensionless].
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
    names = ("sample_times", "samples", "event_times", "event_kinds", "event_states", "contacts")
    tables: dict[str, npt.NDArray[Any]] = {
        name: np.ascontiguousarray(each)
        for name, each in zip(names, (*samples, *events, contacts), strict=True)
    }
    if modes is not None:
        run.mode_began, tables["event_modes"] = int(modes[0]), np.append(modes[1:], np.int8(0))
    for name, table in tables.items():
        setattr(run, name, address(table))
    run.sampled, run.events, run.contact_count = len(samples[0]), len(events[0]), len(contacts)
    return int(library_of(rotor).core_fault(byref(run), allowed, byref(row))), row.value
