"""Summary of a run-up: touches, largest force and ending, as scalars and in a sentence.

read the facts of the run-up: touches, largest radius and force, first roll;
keep the last speed and follow the rotor to its steady state, as `run_ups` does;
put both into words, with a warning outside the validity of the model.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import COMPONENTS, check_instance
from rotor_ida.errors import InputError
from rotor_ida.model.contact import bounds_exceeded
from rotor_ida.model.disc_starts import hanging
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.parallel import interruptible
from rotor_ida.results.contact_facts import run_up_facts
from rotor_ida.results.depths import beyond_in_words
from rotor_ida.results.run import check_run, rotor_of
from rotor_ida.results.si_units import dimensional, dimensionless, is_in_si, machine_of
from rotor_ida.schema import (
    ENDING,
    RESPONSE,
    WHIRL_DIRECTION,
    Column,
    labelled_dataset,
    origin_of,
)
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import FAILED
from rotor_ida.steady.grid import EXPECTED, reason_of
from rotor_ida.steady.response import CONTACT_FREE
from rotor_ida.steady.run_up_outcome import ONLY_WITH, RUB, WHIP, Outcome, ending_at, failed
from rotor_ida.units import quantity

NEEDED = (
    "t", "speed", "angle", *COMPONENTS, "event_speed", "event_kind", "peak_force", "peak_time",
)  # fmt: skip
# Attributes of a run-up that its summary omits.
OF_CHANGE = ("to", "rate", "speeds", "torque", "inertia")
# Allowed distance of the last sample from the end, relative to the duration.
AT_END = 1e-9
# Allowed distance of a start from that at rest, relative to its size.
SAME_START = 1e-9
LIES = "at rest on the stator"
RUBS = {
    "synchronous": "full annular rub, forwards with the unbalance",
    "full_contact": "full annular rub, with a radius that pulsates",
    "bouncing": "intermittent rub, in and out of contact",
    "quasi_periodic": "rub that never repeats itself",
    "chaotic": "chaotic rub",
    "rolling": "backward rub, rolling on the stator at times",
}


def summary(run: xr.Dataset) -> xr.Dataset:
    """Summarise a run-up: first touch, largest radius and force, first roll, and how it ends.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.run_up`, dimensionless or in SI units.

    Returns
    -------
    Dataset
        Scalars, in the units of the run: ``first_touch_speed``, ``last_exit_speed``,
        ``largest_radius``, ``largest_radius_speed``, ``smallest_gap`` (clearance less the largest
        radius, negative in contact), ``largest_force``, ``largest_force_speed``,
        ``contact_count``, ``contact_time``, with friction ``first_roll_speed`` and ``total_heat``,
        with contact damping ``total_contact_loss``, and as flags
        ``ending`` (``contact_free``, ``rub``, ``whip``, ``unresolved`` or ``failed``) and
        ``response``, the settled response at the constant last speed, as from `run_ups`. The speed
        of an event that did not occur is NaN. The attribute ``sentence`` is the summary in words.

    Raises
    ------
    InputError
        If the dataset is not a run-up, or was not sampled at its end.

    Notes
    -----
    Without a contact the largest radius is that of the samples. The sentence warns where the
    contact law is invalid: if the indentation exceeds a tenth of the disc's radius or, for a
    machine in SI units, the clearance.

    Examples
    --------
    >>> from rotor_ida import Rotor, run_up
    >>> rotor = Rotor(omega=0.2, zeta=0.1, delta0=8.0, shaft_stiffness=1.0)
    >>> found = summary(run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.01))
    >>> print(found.attrs["sentence"])
    No rub: closest to the stator at a speed of 1.149, where 3.11 of the clearance of 8 are left.
    Held at a speed of 2 it stays off the stator.
    """
    machine = None
    plain = check_instance("run", run, xr.Dataset)
    if is_in_si(plain):
        machine, plain = machine_of(plain), dimensionless(plain)
        if machine is None:
            raise InputError("run must have its machine's parameters, got one in SI units without")
    if "event_speed" not in plain:
        raise InputError("run must be a run of run_up, whose speed changes")
    check_run(plain, NEEDED)
    rotor = rotor_of(plain)
    facts, ended = run_up_facts(plain, rotor.delta0), _ending(plain, rotor)
    for parameter, names in ONLY_WITH.items():
        if not getattr(rotor, parameter):
            facts = {name: each for name, each in facts.items() if name not in names}
    values = facts | {"ending": ENDING[ended.ending], "response": RESPONSE[ended.response]}
    columns: dict[str, Column] = {name: ((), value) for name, value in values.items()}
    coordinates = {name: plain[name].variable for name in rotor.given}
    attributes = {name: each for name, each in origin_of(plain).items() if name not in OF_CHANGE}
    backward = int((plain["whirl_direction"] == WHIRL_DIRECTION["backward"]).sum())
    last = float(plain["speed"][-1])
    sentence = _in_words(facts, ended, rotor, last, machine, backward, start_in_words(run))
    attributes["sentence"] = sentence
    found = labelled_dataset(
        "Summary of a run-up", columns, coordinates, attributes, kind="run_up_summary"
    )
    return found if machine is None else dimensional(found, machine)


def _ending(run: xr.Dataset, rotor: Rotor) -> Outcome:
    """Return the settled outcome at the constant last speed."""
    last, duration = run.isel(t=-1), float(run.attrs["duration"])
    if not math.isclose(float(last["t"]), duration, rel_tol=AT_END):
        raise InputError(
            f"run must be sampled at its end {duration:g}, got the last sample at "
            f"{float(last['t']):g}"
        )
    state: Values = np.array([float(last[name]) for name in COMPONENTS])
    options = Options(
        rtol=float(run.attrs["rtol"]), atol=float(run.attrs["atol"]), method=run.attrs["method"]
    )
    held = replace(rotor, omega=float(last["speed"]))
    angle = float(last["angle"])
    try:
        return interruptible(lambda stop: ending_at(held, state, angle, options, stop))
    except EXPECTED as error:
        return failed(reason_of(error))


# ---- In words ----


def start_in_words(run: xr.Dataset) -> str:
    """Return a clause about where one disc is at rest under its load when a run begins, or "".

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=0.5, zeta=0.1, delta0=1.0, shaft_stiffness=2.0, load=0.5)
    >>> start_in_words(simulate(rotor, duration=1.0))
    'it starts hanging 0.25 below the axis'
    >>> start_in_words(simulate(rotor, start=(0, 0, 0, 0), duration=1.0))
    ''
    """
    machine, plain = (machine_of(run), dimensionless(run)) if is_in_si(run) else (None, run)
    rotor, start = rotor_of(plain), np.asarray(plain.attrs.get("start", ()), float)
    if rotor.load == 0.0 or start.size != len(COMPONENTS):
        return ""
    at_rest = np.array(hanging(rotor))
    if np.abs(start - at_rest).max() > SAME_START * np.abs(at_rest).max():
        return ""
    how = f"{LIES}," if np.hypot(*start[:2]) > rotor.delta0 else "hanging"
    return f"it starts {how} {_length(-start[1], machine)} below the axis"


def _in_words(
    facts: dict[str, float],
    ended: Outcome,
    rotor: Rotor,
    last: float,
    machine: DimensionalRotor | None,
    backward: int,
    start: str,
) -> str:
    """Return a summary in sentences, the verdict first.

    Given are the number of contacts that whirl backward, and a clause about the start.
    """
    held = f"Held at {_speed(last, machine)} it"
    lies = LIES in start  # it has touched the stator before
    sentences = [contact_in_words(facts, ended.ending, rotor, machine, start if lies else "")]
    if start and not lies:
        sentences.append(f"{start[0].upper()}{start[1:]}.")
    if facts["contact_count"] and "first_roll_speed" in facts:
        rolls = facts["first_roll_speed"]
        sentences.append(
            "No dry whip: the disc never rolls on the stator."
            if math.isnan(rolls)
            else f"The disc first rolls on the stator at {_speed(rolls, machine)}."
        )
        if backward and math.isnan(rolls):
            sentences.append(
                f"But friction makes it whirl backward, slipping, in {backward:,} of its "
                f"{facts['contact_count']:,} contacts."
            )
    if ended.ending == CONTACT_FREE:
        sentences.append(f"{held} {'runs clear of' if facts['contact_count'] else 'stays off'} "
                         "the stator.")  # fmt: skip
    elif ended.ending == WHIP:
        sentences.append(
            f"{held} stays in dry whip: it whirls backwards, rolling on the stator, driven by "
            "friction and not by the unbalance, until the speed is brought down."
        )
    elif ended.ending == RUB:
        sentences.append(f"{held} keeps rubbing: {RUBS[ended.response]}.")
    elif ended.ending == FAILED:
        sentences.append(f"{held} could not be followed: {ended.message}.")
    else:
        rubs = "still rubs, and " if ended.features.radius_max > rotor.delta0 else ""
        sentences.append(f"{held} {rubs}had not settled: {ended.message}.")
    beyond = beyond_model(-facts["smallest_gap"], rotor, machine)
    return " ".join([*sentences, beyond]).rstrip()


def contact_in_words(
    facts: Mapping[str, float], ending: str, rotor: Rotor, machine: DimensionalRotor | None,
    lies: str = "",
) -> str:  # fmt: skip
    """Return the verdict, with the closest approach to the stator or the largest force on it.

    Of a rotor that lies on the stator before, the words for that are given.

    Examples
    --------
    >>> facts = {"first_touch_speed": math.nan, "smallest_gap": 0.5, "largest_radius_speed": 1.1}
    >>> contact_in_words(facts, CONTACT_FREE, Rotor(omega=0.5, zeta=0.07, delta0=3.0), None)
    'No rub: closest to the stator at a speed of 1.1, where 0.5 of the clearance of 3 are left.'
    """
    if math.isnan(facts["first_touch_speed"]):
        gap, clearance = _length(facts["smallest_gap"], machine), _length(rotor.delta0, machine)
        return (
            f"No rub: closest to the stator at {_speed(facts['largest_radius_speed'], machine)}, "
            f"where {gap} of the clearance of {clearance} are left."
        )
    verdicts = {CONTACT_FREE: "Rub on the way, none at the end", WHIP: "Dry whip"}
    touch = f"it first touches the stator at {_speed(facts['first_touch_speed'], machine)}"
    return (
        f"{verdicts.get(ending, 'Rub')}: {lies or touch}, and presses up to "
        f"{_length(-facts['smallest_gap'], machine)} into it, with up to "
        f"{_force(facts['largest_force'], machine)} at "
        f"{_speed(facts['largest_force_speed'], machine)}."
    )


def beyond_model(indentation: float, rotor: Rotor, machine: DimensionalRotor | None) -> str:
    """Return a warning if a dimensionless indentation is too large for the contact law, else "".

    Examples
    --------
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.2, disc_radius=10.0)
    >>> beyond_model(0.9, rotor, None), beyond_model(1.1, rotor, None).partition(":")[0]
    ('', 'Beyond the model')
    """
    bounds = bounds_exceeded(
        indentation, rotor.disc_radius, None if machine is None else rotor.delta0
    )
    if not bounds:
        return ""
    return beyond_in_words(_length(indentation, machine), bounds)


def _speed(speed: float, machine: DimensionalRotor | None) -> str:
    if machine is None:
        return f"a speed of {quantity(speed)}"
    return quantity(speed * machine.reference_frequency, "rad/s")


def _length(length: float, machine: DimensionalRotor | None) -> str:
    if machine is None:
        return quantity(length, digits=3)
    return quantity(length * machine.length_scale, "m", 3)


def _force(force: float, machine: DimensionalRotor | None) -> str:
    if machine is None:
        return f"a force of {quantity(force, digits=3)}"
    return quantity(force * machine.force_scale, "N", 3)
