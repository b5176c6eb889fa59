"""The times at which a run is reported: given, counted, or chosen per revolution."""

from __future__ import annotations

import math

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    SAMPLES_A_REVOLUTION,
    check_axis,
    check_count,
    check_increasing,
    is_scalar,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor import Rotor

# In a period of the contact, which is the shortest period of dry whip.
SAMPLES_A_CONTACT = 8
# Smallest number of samples, for a smooth plot of a short run.
FEWEST = 1001
# Limit on memory: about 160 MB in a run, and twice as much during the run.
MOST_CHOSEN = 2_000_000


def sample_times(samples: object, duration: float, rotor: Rotor, fastest: float) -> Values:
    """Return the times to report: as given, equally spaced, or chosen per revolution.

    Parameters
    ----------
    samples : int, array_like or None
        The times, their number, or None.
    duration : float
        The end of the run [dimensionless].
    rotor : Rotor
        The rotor.
    fastest : float
        The largest speed of the run [dimensionless].

    Examples
    --------
    >>> rotor = Rotor(omega=2.0, zeta=0.1, delta0=1.0)
    >>> sample_times(None, 1000.0, rotor, 2.0).size  # 318.3 revolutions
    10187
    >>> sample_times(None, 10.0, rotor, 2.0).size, sample_times(3, 10.0, rotor, 2.0).size
    (1001, 3)
    """
    return times_of(samples, duration, _chosen(duration, rotor, fastest))


def times_of(samples: object, duration: float, chosen: int) -> Values:
    """Return the times to report: as given, or equally spaced, by default as many as `chosen`."""
    if samples is None:
        return np.linspace(0.0, duration, chosen)
    if is_scalar("samples", samples):
        return np.linspace(0.0, duration, check_count("samples", samples, minimum=2))
    times = check_increasing("samples", check_axis("samples", samples))
    if times[-1] > duration:
        raise InputError(
            "{name} must lie from 0 to the {duration=}, got {value}",
            name="samples", duration=duration, value=float(times[-1]),
        )  # fmt: skip
    return times


def _chosen(duration: float, rotor: Rotor, fastest: float) -> int:
    """Return how many samples resolve revolutions, shaft and contact, as far as memory allows."""
    shaft = math.sqrt(rotor.shaft_stiffness)
    on_the_ring = math.sqrt(1.0 + rotor.shaft_stiffness)
    rate = max(
        SAMPLES_A_REVOLUTION * max(fastest, shaft), SAMPLES_A_CONTACT * on_the_ring
    ) / (2.0 * math.pi)  # fmt: skip
    return math.ceil(min(max(rate * duration + 1.0, FEWEST), MOST_CHOSEN))
