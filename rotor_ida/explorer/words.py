"""Sentences that describe a run and its settled response."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

from rotor_ida.model.rotor import DimensionalRotor, Rotor
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
NO_CURVE = "Under a static load there is no synchronous whirl, so no exact curve."
HELD = "the contact-free whirl, which is the only one with a shaft: it stays inside the clearance"
# A rotor at rest counts as centred if its distance is below this fraction of the eccentricity.
CENTRE = 1e-6
# Words for rolling of a disc that does not rotate.
STILL = "does not slide"
# A radius that varies by at most this fraction belongs to a whirl.
STEADY = 1e-6


class InUnits(NamedTuple):
    """The scales of a rotor system, whose numbers are in SI units; and its speed."""

    speed: float
    length_scale: float = 1.0
    time_scale: float = 1.0
    force_scale: float = 1.0
    reference_frequency: float = 1.0


# A rotor, or the scales of a rotor system; None for one without dimensions.
Scaled = Rotor | DimensionalRotor | InUnits | None


def words_of_run(machine: Scaled, facts: Mapping[str, float]) -> list[str]:
    """Describe the last half of a run, in sentences."""
    if not facts["contacts_in_all"]:
        return ["It never touches the stator."]
    if facts["contact_fraction"] == 0.0:
        return ["It has touched the stator, but no longer does."]
    peak = _force(machine, facts["largest_force"])
    damped = [*_damped(machine, facts), *_rubbing(machine, facts)]
    if facts["contact_fraction"] >= 1.0:
        always = f"Over the last half it is always in contact, with a force of up to {peak}."
        return [always, *damped]
    each = facts["contacts_per_revolution"]
    counted = f"{each:.3g} contact" + ("" if f"{each:.3g}" == "1" else "s")
    often = "" if math.isnan(each) else f"{counted} a revolution, "
    share = 100.0 * facts["contact_fraction"]
    half = f"Over the last half: {often}in contact {share:.3g} % of the time, peak force {peak}."
    return [half, *damped]


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
    known = machine if isinstance(machine, DimensionalRotor) else None
    rotor = machine if isinstance(machine, Rotor) else machine.rotor()
    ending = CONTACT_FREE if passed["now"] == "clear" else passed["now"]
    told = contact_in_words(passed, ending, rotor, known)
    too_deep = _too_deep(machine, rotor.delta0 - passed["smallest_gap"])
    return f"From {begin} to {end}. {told}{too_deep}".replace(" um", " µm")


def _gap(machine: Rotor | DimensionalRotor, radius: float) -> str:
    """Return a radius inside the clearance and the gap, in words."""
    clearance = (machine if isinstance(machine, Rotor) else machine.rotor()).delta0
    gap = _length(machine, max(clearance - radius, 0.0))
    return f"radius {_length(machine, radius)}, gap {gap} left of the clearance " + _length(
        machine, clearance
    )


def _too_deep(machine: Rotor | DimensionalRotor, radius: float) -> str:
    """Return a warning if the indentation is too large for the contact law."""
    known = machine if isinstance(machine, DimensionalRotor) else None
    rotor = machine if isinstance(machine, Rotor) else machine.rotor()
    warning = beyond_model(radius - rotor.delta0, rotor, known)
    return f" {warning}" if warning else ""


def words_of_response(machine: Rotor | DimensionalRotor, facts: Mapping[str, Any]) -> list[str]:
    """Describe the settled response, in sentences.

    Examples
    --------
    >>> rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.0)
    >>> facts = {"response": "synchronous", "lies_on": "whirl", "digits": 11.38,
    ...         "exact_amplitude": 3.36, "radius_min": 3.36, "radius_max": 3.36,
    ...         "largest_force": 6.17, "contact_fraction": 1.0, "rotor": {"omega": 1.2}}
    >>> words_of_response(rotor, facts)[2]
    'The simulated whirl and the exact one agree to 11 digits.'
    """
    kind = facts["response"]
    if kind == "failed":
        return [f"It could not be followed: {facts['message']}."]
    if facts["rotor"]["omega"] == 0.0 and kind in {"contact_free", "synchronous"}:
        return _at_rest(machine, facts)
    held = kind == "contact_free" and machine.shaft_stiffness > 0.0 and machine.load == 0.0
    sentences = [f"It settles on {HELD if held else KINDS[kind]}."]
    if kind == "chaotic":
        apart = _time(machine, 1.0 / facts["lyapunov_exponent"])
        sentences.append(f"The distance between neighbours grows e-fold every {apart}.")
    sentences.append(_radii(machine, facts))
    if kind == "contact_free" and machine.load > 0.0 and machine.shaft_stiffness > 0.0:
        sag = _length(machine, facts["rotor"]["load"] / facts["rotor"]["shaft_stiffness"])
        sentences.append(f"Its centre hangs {sag} below the axis of the bearing.")
    if facts["lies_on"] != "nothing":
        what = "whirl" if facts["lies_on"] == "whirl" else "cycle"
        digits = math.floor(facts["digits"])
        sentences.append(f"The simulated {what} and the exact one agree to {digits} digits.")
    if facts.get("contact_fraction", 0.0) > 0.0:
        sentences += [_contact(machine, facts), *_damped(machine, facts), *_rubbing(machine, facts)]
    return sentences


def words_of_transient(
    machine: Rotor | DimensionalRotor, omega: float, drawn: float, settled: float
) -> str:
    """Return a sentence that a run ends before the rotor has settled.

    Parameters
    ----------
    machine : Rotor or DimensionalRotor
        The rotor.
    omega : float
        Its speed [1].
    drawn, settled : float
        Times at which the drawn run ends, and at which the rotor has settled [1].

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
        Radii of the slipping backward whirl and of dry whip [1]; NaN if there is none.
    birth : float
        Speed from which both exist [1]; NaN if friction is too weak at any speed.

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


def _at_rest(machine: Rotor | DimensionalRotor, facts: Mapping[str, Any]) -> list[str]:
    """Return the place of rest of a rotor without spin, in words."""
    if facts["response"] == "synchronous":
        return ["It comes to rest on the stator.", _radii(machine, facts), _contact(machine, facts)]
    if facts["radius_max"] < CENTRE:
        return ["It comes to rest at the centre of the stator."]
    return ["It comes to rest inside the clearance.", _radii(machine, facts)]


def _damped(machine: Scaled, facts: Mapping[str, Any]) -> list[str]:
    """Return the energy lost to contact damping, in words, if any.

    The loss is per contact or, if no contact ends, per revolution, if the radius varies.
    """
    loss = facts.get("loss_per_contact", math.nan)
    if math.isnan(loss):
        each = facts.get("loss_per_revolution", math.nan)
        if math.isnan(each) or facts["contact_fraction"] < 1.0 or _is_steady(facts):
            return []
        return [f"The contact loses {_energy(machine, each)} a revolution."]
    loose = ", and releases the rotor before it has left the stator" if facts["releases"] else ""
    return [f"A contact loses {_energy(machine, loss)} in the mean{loose}."]


def _rubbing(machine: Scaled, facts: Mapping[str, Any]) -> list[str]:
    """Return the fractions of contact time with slip and rolling, and the friction heat."""
    if "rolling_fraction" not in facts:
        return []
    turns = machine.omega if isinstance(machine, Rotor) else machine.speed if machine else 1.0
    rolls = "rolls" if turns > 0.0 else STILL
    ways = [
        (facts["rolling_fraction"], rolls),
        (facts["slipping_forward_fraction"], "slips forwards"),
        (facts["slipping_backward_fraction"], "slips backwards"),
    ]
    seen = [(part, word) for part, word in ways if part > 0.0]
    if len(seen) == 1 and seen[0][1] == STILL:
        return [f"In contact it {STILL}."]
    if len(seen) == 1:
        share = f"In contact it {seen[0][1]} all the time"
    else:
        parts = [f"{word} {100.0 * part:.3g} %" for part, word in seen]
        share = f"Of the time in contact it {', '.join(parts[:-1])} and {parts[-1]}"
    heat = facts.get("heat_per_revolution", math.nan)
    if math.isnan(heat) or all(word == rolls for _, word in seen):
        return [f"{share}."]
    return [f"{share}, with a heat of {_energy(machine, heat)} a revolution."]


def _is_steady(facts: Mapping[str, Any]) -> bool:
    """Return whether the radius is constant."""
    return bool(facts["radius_max"] - facts["radius_min"] <= STEADY * facts["radius_max"])


def _radii(machine: Rotor | DimensionalRotor, facts: Mapping[str, Any]) -> str:
    low, high = (_length(machine, facts[name]) for name in ("radius_min", "radius_max"))
    if facts["response"] == "synchronous":
        radius = _length(machine, facts["exact_amplitude"]) if "exact_amplitude" in facts else high
        return f"Its radius is {radius}."
    if facts["response"] == "contact_free":
        gap = _length(machine, max(facts["rotor"]["delta0"] - facts["radius_max"], 0.0))
        radius = f"is {high}" if low == high else f"goes from {low} to {high}"
        return f"Its radius {radius}, and leaves a gap of {gap} to the stator."
    period = facts.get("period", math.nan)
    again = ""
    if not math.isnan(period) and machine.load > 0.0:
        turns = round(period * facts["rotor"]["omega"] / (2.0 * math.pi))
        again = f", and repeats every {f'{turns} revolutions' if turns > 1 else 'revolution'}"
    elif not math.isnan(period):
        again = (
            f", and repeats every {_time(machine, period)} on axes that rotate with the unbalance"
        )
    return f"Its radius goes from {low} to {high}{again}."


def _contact(machine: Rotor | DimensionalRotor, facts: Mapping[str, Any]) -> str:
    peak = _force(machine, facts["largest_force"])
    if facts["contact_fraction"] >= 1.0:
        steady = facts["response"] == "synchronous"
        return f"It presses on the stator with {peak}." if steady else f"Peak force {peak}."
    each, share = facts["contacts_per_revolution"], 100.0 * facts["contact_fraction"]
    often = "once" if f"{each:.4g}" == "1" else f"{each:.4g} times"
    return (
        f"It touches the stator {often} a revolution, {share:.3g} % of the time, with a "
        f"peak force of {peak}."
    )


def _said(machine: Scaled, value: float, scale: str, unit: str) -> str:
    """Return a dimensionless number; for a machine as the quantity that has this scale."""
    if isinstance(machine, Rotor | None):
        return quantity(value)
    return quantity(value * float(getattr(machine, scale)), unit).replace(" u", " µ")


_length = partial(_said, scale="length_scale", unit="m")
_time = partial(_said, scale="time_scale", unit="s")
_force = partial(_said, scale="force_scale", unit="N")
_rate = partial(_said, scale="reference_frequency", unit="rad/s")


def _energy(machine: Scaled, value: float) -> str:
    length = 1.0 if isinstance(machine, Rotor | None) else machine.length_scale
    return _said(machine, length * value, "force_scale", "J")
