"""Sentences on a rotor system that is unstable without contact, or that nothing holds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from rotor_ida.arrays import Flags, Values
from rotor_ida.model.assembly import Assembly, canonical
from rotor_ida.model.growth import growth_begins, growth_between, growth_of
from rotor_ida.units import number, quantity

RATE, WHIRL_SPEED, NOT_HELD, BEGINS, RANGES = (
    "growth_rate_without_contact", "whirl_speed_of_growth", "nothing_holds", "growth_begins_at",
    "unstable_speeds",
)  # fmt: skip

# Above this damping ratio the amplification factor, 1/(2 zeta), is below 2.5: API RP 684 calls
# such a critical speed critically damped, and asks no separation margin of it.
RESONANT = 0.2


def growth_over_speeds(assembly: Assembly, speeds: Values) -> dict[str, object]:
    """Return attributes that say where and how the motion grows over speeds; none if it does not.

    They are the rate and the whirl speed at the largest speed, and the ranges as pairs of ends.
    """
    found, low, high = canonical(assembly), float(speeds.min()), float(speeds.max())
    told: dict[str, object] = {}
    if growth := growth_of(found, high) if high > 0.0 else None:
        told |= {RATE: growth.rate, WHIRL_SPEED: growth.whirl_speed}
        begins = growth_begins(found, high)
        told |= {} if begins is None else {BEGINS: begins}
    ranges = growth_between(found, low, high) if low < high else []
    return told | ({RANGES: np.ravel(ranges)} if ranges else {})


def damped_words(speeds: Values, ratios: Values, units: str) -> list[str]:
    """Return a sentence on critical speeds that are damped too much for a resonance, if any are.

    `units` are SI or 1.

    Examples
    --------
    >>> damped_words(np.array([200.0, 500.0]), np.array([0.99, 0.05]), "SI")[0][:60]
    'At 1,910 rpm a whirl speed is the spin speed too, but damped'
    """
    damped = np.unique(np.abs(speeds[ratios > RESONANT]))
    if not damped.size:
        return []
    told = [quantity(each, "rad/s") if units == "SI" else number(each) for each in damped.tolist()]
    return [
        f"At {' and '.join(told)} a whirl speed is the spin speed too, but damped so much (damping "
        f"ratio above {RESONANT:g}, amplification factor below 2.5) that no resonance shows."
    ]


def grows_at(attributes: Mapping[str, Any], speeds: Values) -> Flags:
    """Return at which of the speeds of a result the motion without contact grows.

    Examples
    --------
    >>> grows_at({RANGES: [1.0, 2.0, 4.0, 5.0]}, np.array([0.5, 1.5, 3.0, 5.0]))
    array([False,  True, False,  True])
    """
    ends = np.ravel(attributes.get(RANGES, []))
    if not ends.size:
        return np.full(speeds.shape, RATE in attributes)
    inside = (speeds >= ends[::2, np.newaxis]) & (speeds <= ends[1::2, np.newaxis])
    return np.asarray(inside.any(axis=0))


def growing(rate: float, whirl_speed: float, units: str) -> str:
    """Return at which rate and as which whirl a motion grows.

    Examples
    --------
    >>> growing(1.245, 335.7, "SI")
    'grows at a rate of 1.245 per second, as a whirl at 3,206 rpm'
    >>> growing(0.1, 0.0, "1")
    'grows at a rate of 0.1, without a whirl'
    """
    si = units == "SI"
    speed = quantity(whirl_speed, "rad/s" if si else "1")
    whirl = f"as a whirl at {speed}" if whirl_speed else "without a whirl"
    return f"grows at a rate of {number(rate)}{' per second' if si else ''}, {whirl}"


def stability_words(attributes: Mapping[str, Any], units: str) -> list[str]:
    """Return sentences on the linear system of a run, by the attributes of that."""
    words = []
    if rate := attributes.get(RATE):
        whirl = float(attributes.get(WHIRL_SPEED, 0.0))
        words.append(
            f"Without contact the motion {growing(float(rate), whirl, units)}: the linear system "
            f"is unstable{_begins(attributes, units)}."
        )
    ends = np.reshape(attributes.get(RANGES, []), (-1, 2)).tolist()
    if ended := ends[:-1] if RATE in attributes else ends:
        unit = "rad/s" if units == "SI" else "1"
        told = " and ".join(f"from {quantity(low, unit)} to {quantity(high, unit)}"
                            for low, high in ended)  # fmt: skip
        words.append(
            f"Without contact the motion {'also ' if words else ''}grows at speeds {told}: the "
            "linear system is unstable there."
        )
    if attributes.get(NOT_HELD):
        words.append(
            "Neither supports nor contacts hold the system against its constant forces: it moves "
            "away without bound."
        )
    return words


def _begins(attributes: Mapping[str, Any], units: str) -> str:
    """Return from which speed on a motion grows, on bearings whose coefficients depend on it."""
    if BEGINS not in attributes:
        return ""
    return f" from {quantity(float(attributes[BEGINS]), 'rad/s' if units == 'SI' else '1')} on"
