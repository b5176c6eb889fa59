"""Verdict, sentences and sheets that describe a run and its settled response."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.results.sheets import Line, facts, sheets_shown
from rotor_ida.steady.response import CONTACT_FREE
from rotor_ida.steady.run_up_summary import beyond_model, contact_in_words
from rotor_ida.units import quantity

# Words for each kind of response, with its meaning on a machine.
KINDS = {
    "contact_free": "a contact-free whirl: it stays inside the clearance",
    "synchronous": "a synchronous whirl in contact: it turns with the unbalance at constant radius",
    "bouncing": "a bouncing limit cycle (intermittent rub): it enters and leaves contact often",
    "full_contact": "a limit cycle in full contact (full annular rub): its radius pulsates",
    "rolling": "dry whip: it rolls backwards on the stator",
    "touching": "a contact-free whirl, through ever lighter contacts",
    "quasi_periodic": "a torus: it never repeats itself, but neighbouring motions stay together",
    "chaotic": "chaos: it never repeats itself, and neighbouring motions diverge",
    "unresolved": "no known kind of motion within the longest simulated time",
}
HELD = "the contact-free whirl, which is the only one with a shaft: it stays inside the clearance"
INSIDE = "inside the clearance"
# A rotor at rest counts as centred if its distance is below this fraction of the eccentricity.
CENTRE = 1e-6
# SI units of quantities by the names of their scales.
UNITS = {"length": "m", "time": "s", "force": "N", "energy": "J", "rate": "rad/s"}
DIGITS = 4
# Rows of a sheet on a motion: the name of the number, in words, and its scale.
ROWS = {
    "radius_min": ("smallest radius", "length"), "radius_max": ("largest radius", "length"),
    "sag": ("centre below the axis", "length"), "period": ("repeats after", "time"),
    "contacts_per_revolution": ("contacts a revolution", ""),
    "largest_force": ("largest force", "force"), "contact_fraction": ("time in contact", "%"),
    "rolling_fraction": ("of it rolling", "%"),
    "slipping_forward_fraction": ("of it slipping forwards", "%"),
    "slipping_backward_fraction": ("of it slipping backwards", "%"),
    "heat_per_revolution": ("heat a revolution", "energy"),
    "loss_per_contact": ("loss of a contact", "energy"),
    "loss_per_revolution": ("loss of contacts a revolution", "energy"),
    "releases": ("releases before leaving the stator", ""),
    "parting_time": ("neighbours part e-fold in", "time"),
    "digits": ("digits that agree with the exact one", ""),
}  # fmt: skip


Scales = Mapping[str, float]


def sheet_of(title: str, scales: Scales, told: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the sheet on a motion, for the page; what is not known, or 0, has no row, but lengths.

    Parameters
    ----------
    title : str
        What the numbers are of.
    scales : mapping
        SI units in each dimensionless 1, by the names of `UNITS`; empty without dimensions.
    told : mapping
        Numbers by the names of `ROWS`, dimensionless.

    Examples
    --------
    >>> (sheet,) = sheet_of("Run", {"length": 1e-6}, {"radius_max": 2.0, "contact_fraction": 0.25})
    >>> sheet["rows"][1:]
    [['largest radius', '2', 'µm'], ['time in contact', '25', '%']]
    """
    lines = []
    for name, (words, scale) in ROWS.items():
        value = float(told.get(name, math.nan))
        if math.isnan(value) or (value == 0.0 and scale != "length"):
            continue
        if scale == "%":
            lines.append(Line(words, [100.0 * value], "%", DIGITS))
        elif scale and scales:
            lines.append(Line(words, [value * scales[scale]], UNITS[scale], DIGITS))
        else:
            lines.append(Line(words, [value], "1", DIGITS))
    return sheets_shown([facts(title, lines)])


def words_of_run(told: Mapping[str, float]) -> list[str]:
    """Return in a sentence that a run does not touch the stator, or no longer does."""
    if not told["contacts_in_all"]:
        return ["It never touches the stator."]
    return [] if told["contact_fraction"] else ["It has touched the stator, but no longer does."]


def verdict_of(machine: Rotor | DimensionalRotor, facts: Mapping[str, Any]) -> str:
    """Return in one sentence whether the settled response rubs, and at which force.

    Examples
    --------
    >>> rotor = Rotor(omega=1.2, zeta=0.07, delta0=3.0)
    >>> verdict_of(rotor, {"response": "contact_free", "radius_max": 2.5, "contact_fraction": 0.0})
    'No contact: radius 2.5, gap 0.5 left of the clearance 3.'
    """
    if facts["response"] == "failed":
        return f"Not known: {facts['message']}."
    if facts["contact_fraction"] == 0.0:
        return f"No contact: {_gap(machine, facts['radius_max'])}."
    force = _force(machine, facts["largest_force"])
    if facts["response"] == "rolling":
        what = f"Dry whip: the disc rolls backwards on the stator, with a force of up to {force}"
    elif facts["contact_fraction"] >= 1.0:
        what = f"Rub: contact without a break, with a force of up to {force}"
    else:
        share = 100.0 * facts["contact_fraction"]
        what = f"Rub: in contact {share:.3g} % of the time, with a force of up to {force}"
    return f"{what}.{_too_deep(machine, facts['radius_max'])}"


def words_of_run_up(machine: Rotor | DimensionalRotor, passed: Mapping[str, Any]) -> str:
    """Describe a run-up so far, in the words of its summary.

    Parameters
    ----------
    machine : Rotor or DimensionalRotor
        The rotor.
    passed : mapping
        Speeds ``begin`` and ``end``; of `rotor_ida.summary` the speed of the first
        contact, the smallest gap and the largest force, each with its speed; all dimensionless.
        ``now`` is "clear", "rub" or "whip".

    Examples
    --------
    >>> words_of_run_up(Rotor(omega=1.2, zeta=0.07, delta0=3.0), {
    ...     "begin": 0.5, "end": 1.2, "first_touch_speed": math.nan, "smallest_gap": 0.5,
    ...     "largest_radius_speed": 1.1, "now": "clear"})
    'From 0.5 to 1.2. No rub: closest to the stator at a speed of 1.1, where 0.5 of the clearance
    of 3 are left.'
    """
    begin, end = (_rate(machine, passed[name]) for name in ("begin", "end"))
    rotor, known = _both(machine)
    ending = CONTACT_FREE if passed["now"] == "clear" else passed["now"]
    told = contact_in_words(passed, ending, rotor, known)
    too_deep = _too_deep(machine, rotor.delta0 - passed["smallest_gap"])
    return f"From {begin} to {end}. {told}{too_deep}".replace(" um", " µm")


def _gap(machine: Rotor | DimensionalRotor, radius: float) -> str:
    """Return a radius inside the clearance and the gap, in words."""
    clearance = _both(machine)[0].delta0
    gap = _length(machine, max(clearance - radius, 0.0))
    return f"radius {_length(machine, radius)}, gap {gap} left of the clearance " + _length(
        machine, clearance
    )


def _too_deep(machine: Rotor | DimensionalRotor, radius: float) -> str:
    """Return a warning if the indentation is too large for the contact law."""
    rotor, known = _both(machine)
    warning = beyond_model(radius - rotor.delta0, rotor, known)
    return f" {warning}" if warning else ""


def words_of_response(machine: Rotor | DimensionalRotor, told: Mapping[str, Any]) -> str:
    """Return in a sentence on what kind of motion the rotor settles.

    Examples
    --------
    >>> rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.0)
    >>> words_of_response(rotor, {"response": "synchronous"})
    'It settles on a synchronous whirl in contact: it turns with the unbalance at constant radius.'
    """
    kind = told["response"]
    if kind == "failed":
        return f"It could not be followed: {told['message']}."
    rotor, _ = _both(machine)
    if rotor.omega == 0.0 and kind in {"contact_free", "synchronous"}:
        inside = "at the centre of the stator" if told["radius_max"] < CENTRE else INSIDE
        return f"It comes to rest {'on the stator' if kind == 'synchronous' else inside}."
    held = kind == "contact_free" and machine.shaft_stiffness > 0.0 and machine.load == 0.0
    return f"It settles on {HELD if held else KINDS[kind]}."


def numbers_of_response(rotor: Rotor, told: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a settled response for its sheet."""
    found = dict(told)
    if told["lies_on"] == "nothing":
        found.pop("digits", None)
    else:
        found["digits"] = math.floor(told["digits"])
    if told["response"] == "chaotic":
        found["parting_time"] = 1.0 / told["lyapunov_exponent"]
    if told["response"] == "contact_free" and rotor.load > 0.0 and rotor.shaft_stiffness > 0.0:
        found["sag"] = rotor.load / rotor.shaft_stiffness
    return found


def words_of_transient(
    machine: Rotor | DimensionalRotor, omega: float, drawn: float, settled: float
) -> str:
    """Return a sentence that a run ends before the rotor has settled.

    Parameters
    ----------
    machine : Rotor or DimensionalRotor
        The rotor.
    omega : float
        Its speed [dimensionless].
    drawn, settled : float
        Times at which the drawn run ends, and at which the rotor has settled [dimensionless].

    Examples
    --------
    >>> words_of_transient(Rotor(omega=2.0, zeta=0.01, delta0=1.0), 2.0, 188.5, 17_000.0)
    'The run that is drawn has not settled: it ends at t = 188.5 (60 revolutions), and the rotor
    had settled at t = 17000 (5,411 revolutions).'
    """

    def moment(time: float) -> str:
        turns = time * omega / (2.0 * math.pi)
        return _time(machine, time) + (f" ({turns:,.0f} revolutions)" if omega else "")

    return (
        f"The run that is drawn has not settled: it ends at t = {moment(drawn)}, and the rotor "
        f"had settled at t = {moment(settled)}."
    )


def words_of_whip(
    machine: Rotor | DimensionalRotor, saddle: float, whip: float, birth: float
) -> str:
    """Return in words whether friction alone, without unbalance, can sustain dry whip.

    Parameters
    ----------
    machine : Rotor or DimensionalRotor
        The rotor.
    saddle, whip : float
        Radii of the slipping backward whirl and of dry whip [dimensionless]; NaN if there is none.
    birth : float
        Speed from which both exist [dimensionless]; NaN if friction is too weak at any speed.

    Examples
    --------
    >>> rotor = Rotor(omega=0.5, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    >>> words_of_whip(rotor, 3.1479, 4.25, 0.31479)
    'Without unbalance dry whip would have a radius of 4.25, and a backward whirl beyond 3.148
    would grow into it.'
    >>> words_of_whip(rotor, math.nan, math.nan, 0.31479)
    'Without unbalance dry whip begins at a speed of 0.3148.'
    """
    if not math.isnan(whip):
        grown = "any backward whirl on the stator"
        if not math.isnan(saddle):
            grown = f"a backward whirl beyond {_length(machine, saddle)}"
        return (
            f"Without unbalance dry whip would have a radius of {_length(machine, whip)}, and "
            f"{grown} would grow into it."
        )
    if not math.isnan(birth):
        return f"Without unbalance dry whip begins at a speed of {_rate(machine, birth)}."
    return "Friction is too weak for dry whip at any speed."


def _both(machine: Rotor | DimensionalRotor) -> tuple[Rotor, DimensionalRotor | None]:
    """Return the rotor without dimensions, and the machine if it has any."""
    return (machine, None) if isinstance(machine, Rotor) else (machine.rotor(), machine)


def _said(machine: Rotor | DimensionalRotor, value: float, scale: str, unit: str) -> str:
    """Return a dimensionless number; for a machine as the quantity that has this scale."""
    if isinstance(machine, Rotor):
        return quantity(value)
    return quantity(value * float(getattr(machine, scale)), unit).replace(" u", " µ")


_length = partial(_said, scale="length_scale", unit="m")
_time = partial(_said, scale="time_scale", unit="s")
_force = partial(_said, scale="force_scale", unit="N")
_rate = partial(_said, scale="reference_frequency", unit="rad/s")
