"""Follow many starts side by side, each until it enters a trapping region or its time is up.

The core does this on the rotating axes: ``core/lanes.c``. Its arguments are checked here.

Order of the labels: the whirls in contact, the whirls that never touch the stator again
(`free_label`), those with fading touches (`fading_label`), and the limit cycles.
"""

from __future__ import annotations

from ctypes import byref
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Stop, Values
from rotor_ida.core.interface import RotorStruct, library_of, pointer
from rotor_ida.model.rotor import Rotor

Labels = npt.NDArray[np.int16]
Times = npt.NDArray[np.float32]
Rows = npt.NDArray[np.void]

# Labels of starts that are not numbers of attractors; ROLLING is without a period.
ROLLING, QUASI_PERIODIC, CHAOTIC, NOT_COMPUTED, UNDECIDED = -5, -4, -3, -2, -1
# Label of starts still to be followed alone, as their discs do not slide forwards throughout.
NOT_FORWARDS = -6
# Number of orbits followed at a time: enough to keep the vector units busy.
LANES = 64
# A trapping region: its centre, and the upper triangle of R, where its form is ``R^T R``.
REGION = np.dtype([("centre", np.float64, 4), ("factor", np.float64, 10)])
# The contact-free whirl, with the squared radii within which its centre must stay, and from within
# which touches fade; the radii are negative where there is none.
CONTACT_FREE = np.dtype([("whirl", np.float64, 2), ("room", np.float64), ("fading", np.float64)])
NO_CONTACT_FREE = np.array(((0.0, 0.0), -1.0, -1.0), dtype=CONTACT_FREE)
# A section of a limit cycle: its state c, the unit normal, the rows of L, and the squared distance
# from c within which the set ``|L (s - c)| <= 1`` lies.
SECTION = np.dtype(
    [
        ("centre", np.float64, 4), ("normal", np.float64, 4), ("form", np.float64, (3, 4)),
        ("reach", np.float64),
    ]
)  # fmt: skip


def follow(
    states: Values,
    labels: Labels,
    times: Times,
    rotor: Rotor,
    regions: Rows,
    free: Rows,
    sections: Rows,
    duration: float,
    tolerance: float,
    stop: Stop,
) -> None:
    """Follow each start, in the core, until it enters a region or `duration` has passed.

    Parameters
    ----------
    states : ndarray, shape (4, n)
        Starts on the rotating axes [dimensionless]; overwritten by the states at the end.
    labels : ndarray of int16, shape (n,)
        Set to the number of the trapping region, ``len(regions)`` for contact-free whirls, one more
        for fading touches, two more and above for limit cycles, or UNDECIDED; with friction
        NOT_FORWARDS if the disc may not slide forwards throughout. Starts not finished when `stop`
        is set keep NOT_COMPUTED. Starts whose label is already zero or more are skipped.
    times : ndarray of float32, shape (n,)
        The time that each start took is added [dimensionless].
    rotor : Rotor
        The rotor; without damping it must have no contact-free whirl.
    regions : ndarray of REGION, shape (m,)
        The trapping regions.
    free : ndarray of CONTACT_FREE, shape ()
        The contact-free whirl.
    sections : ndarray of SECTION, shape (k,)
        A section of each limit cycle with its trapping set.
    duration, tolerance : float
        Longest time to follow, and tolerance of a step [dimensionless]. Under a load a time of
        whole revolutions, at whose ends alone regions are tested: a motion that takes too many
        steps is then NOT_FORWARDS.
    stop : ndarray of uint8, shape (1,)
        Set to 1 by another thread to end early.

    Raises
    ------
    TypeError, ValueError
        If an array has another type or shape, or its numbers do not lie one after the other.
    """
    count, region_count, section_count = labels.size, len(regions), len(sections)
    _check_shapes(
        states=(states, (4, count)), labels=(labels, (count,)), times=(times, (count,)),
        regions=(regions, (region_count,)), free=(free, ()), sections=(sections, (section_count,)),
        stop=(stop, (1,)),
    )  # fmt: skip
    # the labels are those of regions, of a whirl in flight, of fading touches, and of cycles
    most, highest = np.iinfo(np.int16).max, region_count + section_count + 1
    if highest > most:
        raise ValueError(f"labels of attractors must be at most {most}, got {highest}")
    # the labels show whether it was stopped
    library_of(rotor).core_follow_lanes(
        byref(RotorStruct.of(rotor)), pointer(states, np.float64, writeable=True),
        pointer(labels, np.int16, writeable=True), pointer(times, np.float32, writeable=True),
        count, pointer(regions, REGION), region_count, pointer(free, CONTACT_FREE),
        pointer(sections, SECTION), section_count, duration, tolerance,
        pointer(stop, np.uint8),
    )  # fmt: skip


def measure_returns(
    states: Values,
    rotor: Rotor,
    section: Rows,
    times: tuple[float, float],
    tolerance: float,
    values: Values,
    stop: Stop,
) -> None:
    """Compute, in the core, the least ``|L (s - c)|**2`` with which states pass a section.

    Parameters
    ----------
    states : ndarray, shape (4, n)
        States on the rotating axes [dimensionless].
    rotor : Rotor
        The rotor.
    section : ndarray of SECTION, shape ()
        The section.
    times : tuple of float
        Earliest and latest time [dimensionless].
    tolerance : float
        Tolerance of a step [dimensionless].
    values : ndarray, shape (n,)
        Set to the values [dimensionless]; infinite if a state does not pass the section, or if with
        friction the disc may not slide forwards until then.
    stop : ndarray of uint8, shape (1,)
        Set to 1 by another thread to end early.

    Raises
    ------
    TypeError, ValueError
        If an array has another type or shape, or its numbers do not lie one after the other.
    """
    count = values.size
    _check_shapes(states=(states, (4, count)), section=(section, ()), values=(values, (count,)),
                  stop=(stop, (1,)))  # fmt: skip
    # a caller that stops it does not read the values
    library_of(rotor).core_measure_returns(
        byref(RotorStruct.of(rotor)), pointer(states, np.float64), values.size,
        pointer(section, SECTION), *times, tolerance,
        pointer(values, np.float64, writeable=True), pointer(stop, np.uint8),
    )  # fmt: skip


def _check_shapes(**given: tuple[npt.NDArray[Any], tuple[int, ...]]) -> None:
    """Raise unless arrays have their shapes: the core would read past their ends."""
    for name, (array, shape) in given.items():
        if array.shape != shape:
            raise ValueError(f"{name} must have the shape {shape}, got {array.shape}")
