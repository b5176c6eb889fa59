"""What is said of a rotor system without contact that grows, or that nothing holds: one place."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rotor_ida.units import number, quantity

RATE, WHIRL_SPEED, NOT_HELD, BEGINS = (
    "growth_rate_without_contact", "whirl_speed_of_growth", "nothing_holds", "growth_begins_at",
)  # fmt: skip


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
