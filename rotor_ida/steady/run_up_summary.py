"""Summary of a run-up: touches, largest force and ending, as scalars and in a sentence.

read the facts of the run-up: touches, largest radius and force, first roll;
keep the last speed and follow the rotor to its steady state, as `run_ups` does;
put both into words, with a warning outside the validity of the model.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import COMPONENTS, check_instance, check_positive
from rotor_ida.errors import InputError, InstallationError
from rotor_ida.model.contact import bounds_exceeded
from rotor_ida.model.disc_starts import hanging
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.parallel import interruptible
from rotor_ida.results.archived_system import system_of
from rotor_ida.results.checked_run import check_run, check_system_run, is_of_system, rotor_of
from rotor_ida.results.contact_facts import run_up_facts
from rotor_ida.results.depths import beyond_in_words
from rotor_ida.results.depths import beyond_model as beyond_of_system
from rotor_ida.results.growth_words import BEGINS, RATE, stability_words
from rotor_ida.results.si_units import (
    dimensional,
    dimensionless,
    is_in_si,
    machine_of,
    with_system_units,
)
from rotor_ida.schema import (
    ENDING,
    RESPONSE,
    WHIRL_DIRECTION,
    Column,
    by_number,
    labelled_dataset,
    origin_of,
)
from rotor_ida.simulation.options import Options
from rotor_ida.steady.grid import EXPECTED, reason_of
from rotor_ida.steady.response import CONTACT_FREE
from rotor_ida.steady.run_up_outcome import (
    ONLY_WITH,
    RUB,
    WHIP,
    ending_at,
    facts_of_contacts,
    settled_system,
)
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
LIES, FAILED = "at rest on the stator", "failed"
RUBS = {
    "synchronous": "full annular rub, forwards with the unbalance",
    "full_contact": "full annular rub, with a radius that pulsates",
    "bouncing": "intermittent rub, in and out of contact",
    "quasi_periodic": "rub that never repeats itself",
    "chaotic": "chaotic rub",
    "rolling": "backward rub, rolling on the stator at times",
}


def summary(run: xr.Dataset, *, running_speed: float | None = None) -> xr.Dataset:
    """Summarise a run-up: first touch, largest radius and force, first roll, and how it ends.

    Parameters
    ----------
    run : Dataset
        A run of `rotor_ida.run_up`, dimensionless or in SI units, of any rotor.
    running_speed : float, optional
        Speed of the machine in service, in the unit of the run: the sentence tells how far above
        or below it the rotor first touches.

    Returns
    -------
    Dataset
        Scalars, in the units of the run: ``first_touch_time``, ``first_touch_speed``,
        ``last_exit_speed``, ``largest_radius``, ``largest_radius_speed``, ``smallest_gap``
        (clearance less the largest radius, negative in contact), ``largest_force``,
        ``largest_force_speed``,
        ``contact_count``, ``contact_time``, with friction ``first_roll_speed`` and ``total_heat``,
        with contact damping ``total_contact_loss``, and as flags
        ``ending`` (``contact_free``, ``rub``, ``whip``, ``unresolved`` or ``failed``) and
        ``response``, the settled response at the constant last speed, as from `run_ups`. The speed
        of an event that did not occur is NaN. Of a rotor system what belongs to a contact is along
        ``contact``. The attribute ``sentence`` is the summary in words.

    Raises
    ------
    InputError
        If the dataset is not a run-up, or was not sampled at its end.

    Notes
    -----
    Without a contact the largest radius is that of the samples. With contact damping
    ``largest_force_speed`` of one disc is the speed at the largest indentation of that contact,
    shortly after the largest force. The sentence warns where the
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
    if running_speed is not None:
        running_speed = check_positive("running_speed", running_speed)
    plain = check_instance("run", run, xr.Dataset)
    if is_of_system(plain):
        return _of_system(plain, running_speed)
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
    columns: dict[str, Column] = {name: ((), value) for name, value in facts.items()}
    coordinates = {name: plain[name].variable for name in rotor.given}
    backward = int((plain["whirl_direction"] == WHIRL_DIRECTION["backward"]).sum())
    last = float(plain["speed"][-1])
    scales = None if machine is None else scales_of(machine)
    start = start_in_words(run)
    lies = start if LIES in start else ""  # it has touched the stator before
    verdict = contact_in_words(facts, ended.ending, rotor, machine, running_speed, lies)
    hangs = "" if lies or not start else f"{start[0].upper()}{start[1:]}."
    beyond = beyond_model(-facts["smallest_gap"], rotor, machine)
    told = [beyond, verdict, hangs, *_in_words([facts], ended, last, scales, backward),
            _after_horizon(run, ended)]  # fmt: skip
    found = _dataset(plain, columns, coordinates, ended, told)
    return found if machine is None else dimensional(found, machine)


class Ended(NamedTuple):
    """The ending of a run-up and the response at its last speed, in words.

    `rubs` tells whether an unresolved motion is in contact at times.
    """

    ending: str
    response: str
    message: str
    rubs: bool


def _ended(
    work: Callable[[Stop], tuple[dict[str, Any], str]], clearances: float | Values
) -> Ended:  # fmt: skip
    """Return how a run-up ends by the figures of the settled response, or that this failed."""
    try:
        found, message = interruptible(work)
    except (*EXPECTED, InputError, InstallationError) as error:  # the run may be by the reference
        return Ended(FAILED, FAILED, reason_of(error), rubs=False)
    words = (by_number(ENDING)[found["ending"]], by_number(RESPONSE)[found["response"]])
    return Ended(*words, message, rubs=bool(np.any(found["radius_max"] > clearances)))


def _dataset(
    run: xr.Dataset, columns: dict[str, Column], coordinates: dict[str, xr.Variable], ended: Ended,
    told: Sequence[str],
) -> xr.Dataset:  # fmt: skip
    """Return a summary as a labelled dataset."""
    flags: dict[str, Column] = {
        "ending": ((), ENDING[ended.ending]), "response": ((), RESPONSE[ended.response]),
    }  # fmt: skip
    attributes = {name: each for name, each in origin_of(run).items() if name not in OF_CHANGE}
    attributes["sentence"] = " ".join(filter(None, told))
    return labelled_dataset(
        "Summary of a run-up", columns | flags, coordinates, attributes, kind="run_up_summary"
    )


def _ending(run: xr.Dataset, rotor: Rotor) -> Ended:
    """Return how a run-up of one disc ends."""
    _check_end(run)
    last = run.isel(t=-1)
    state: Values = np.array([float(last[name]) for name in COMPONENTS])
    options = Options(
        rtol=float(run.attrs["rtol"]), atol=float(run.attrs["atol"]), method=run.attrs["method"]
    )
    held = replace(rotor, omega=float(last["speed"]))
    angle = float(last["angle"])
    return _ended(lambda stop: ending_at(held, state, angle, options, stop), rotor.delta0)


def _check_end(run: xr.Dataset) -> None:
    """Raise `InputError` for a run that was not sampled at its end."""
    last, duration = float(run["t"][-1]), float(run.attrs["duration"])
    if not math.isclose(last, duration, rel_tol=AT_END):
        raise InputError(
            f"run must be sampled at its end {duration:g}, got the last sample at {last:g}"
        )


# ---- Of a rotor system ----


def _of_system(run: xr.Dataset, running_speed: float | None) -> xr.Dataset:
    """Return the summary of a run-up of a rotor system."""
    check_system_run(run)
    if "event_speed" not in run or "speed" not in run:
        raise InputError("run must be a run of run_up, whose speed changes")
    _check_end(run)
    contacts, rtol = facts_of_contacts(run), float(run.attrs["rtol"])
    system, last = system_of(run), float(run["speed"][-1])
    ended = _ended(
        lambda stop: settled_system(system, run, last, 0.0, rtol, stop), run["clearance"].values
    )
    for parameter, names in ONLY_WITH.items():
        if not (run[f"law_{parameter.removeprefix('contact_')}"] > 0.0).any():
            contacts = [{name: each for name, each in facts.items() if name not in names}
                        for facts in contacts]  # fmt: skip
    columns: dict[str, Column] = (
        {name: ("contact", np.array([each[name] for each in contacts])) for name in contacts[0]}
        if contacts
        else {"smallest_gap": ("contact", np.empty(0))}
    )
    columns |= {name: ("contact", run[name].values) for name in ("contact_node", "clearance")}
    scales = SI if system.units == "SI" else None
    after = _in_words(contacts, ended, last, scales, 0) if contacts else []
    told = [beyond_of_system(run), *_self_excited(run, ended, last, scales),
            *_of_contacts(run, contacts, ended.ending, scales, running_speed),
            *after, _after_horizon(run, ended)]  # fmt: skip
    return with_system_units(_dataset(run, columns, {}, ended, told), system)


def _self_excited(
    run: xr.Dataset, ended: Ended, last: float, scales: Scales | None
) -> list[str]:  # fmt: skip
    """Return that the motion grows at the last speed by itself, and from which speed on."""
    begins = run.attrs.get(BEGINS, 0.0)
    grows = RATE in run.attrs and begins <= last < math.nextafter(run["speed"].max(), math.inf)
    if not grows or ended.ending == CONTACT_FREE:
        return []
    where = f" beyond the threshold of instability at {_speed(begins, scales)}" if begins else ""
    return [f"Self-excited whirl{where}.", *stability_words(run.attrs, "SI" if scales else "1")]


def _of_contacts(
    run: xr.Dataset, contacts: Sequence[Mapping[str, float]], ending: str, scales: Scales | None,
    running_speed: float | None,
) -> list[str]:  # fmt: skip
    """Return the verdict on the contact that is touched first, or is nearest, then the others."""
    if not contacts:
        return [f"The system has no contacts.{_largest_vibration(run, scales)}"]
    clearances, own = run["clearance"].values, run["episode_contact"].values
    times = [np.nan_to_num(run["entry_time"].values[own == number]).min(initial=math.inf)
             for number in range(len(contacts))]  # fmt: skip
    left = [facts["smallest_gap"] / gap if gap else 1.0
            for facts, gap in zip(contacts, clearances, strict=True)]  # fmt: skip
    touched = [number for number in np.argsort(times).tolist() if math.isfinite(times[number])]
    first = touched[0] if touched else int(np.argmin(left))
    nodes = run["contact_node"].values.tolist()
    where = [f"contact {number} at {node!r}" for number, node in enumerate(nodes)]
    gap = float(clearances[first])
    said = [_verdict(contacts[first], ending, gap, scales, where[first], running_speed)]
    return said + [
        f"It also touches {where[number]}, first at "
        f"{_speed(contacts[number]['first_touch_speed'], scales)}, with up to "
        f"{_force(contacts[number]['largest_force'], scales)} at "
        f"{_speed(contacts[number]['largest_force_speed'], scales)}."
        for number in touched[1:]
    ]


def _largest_vibration(run: xr.Dataset, scales: Scales | None) -> str:
    """Return where a sampled run is farthest from the axis, and how far it is at its end."""
    radii = np.hypot(*(run[name].transpose("t", "node").values for name in ("x", "y")))
    if not radii.size:
        return ""
    when, node = np.unravel_index(int(radii.argmax()), radii.shape)
    last = _speed(float(run["speed"][-1]), scales)
    return (
        f" Of the samples {_length(radii[when, node], scales)} at node "
        f"{str(run['node'].values[node])!r} is farthest from the axis, at "
        f"{_speed(float(run['speed'][when]), scales)}; at the end, at {last}, it is "
        f"{_length(radii[-1, node], scales)} there."
    )


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
    scales = None if machine is None else scales_of(machine)
    how = f"{LIES}," if np.hypot(*start[:2]) > rotor.delta0 else "hanging"
    return f"it starts {how} {_length(-start[1], scales)} below the axis"


def _in_words(
    contacts: Sequence[Mapping[str, float]],
    ended: Ended,
    last: float,
    scales: Scales | None,
    backward: int,
) -> list[str]:
    """Return sentences after the verdict: of `backward` whirls, and how it ends."""
    held = f"Held at {_speed(last, scales)} it" if last else "At standstill it"
    count = sum(int(each["contact_count"]) for each in contacts)
    rolls = [each["first_roll_speed"] for each in contacts if "first_roll_speed" in each]
    sentences = []
    if count and rolls:
        first = next((each for each in rolls if not math.isnan(each)), None)
        sentences.append(
            "No dry whip: the disc never rolls on the stator."
            if first is None
            else f"The disc first rolls on the stator at {_speed(first, scales)}."
        )
        if backward and first is None:
            sentences.append(
                f"But friction makes it whirl backward, slipping, in {backward:,} of its "
                f"{count:,} contacts."
            )
    if ended.ending == CONTACT_FREE:
        clear = ("runs clear of" if last else "rests clear of") if count else "stays off"
        return [*sentences, f"{held} {clear} the stator."]
    if ended.ending == RUB and not last:
        return [*sentences, f"{held} rests on the stator."]
    if not count and ended.ending in (RUB, WHIP):
        held += " touches at last, and"
    if ended.ending == WHIP:
        said = (
            "stays in dry whip: it whirls backwards, rolling on the stator, driven by friction and "
            "not by the unbalance, until the speed is brought down."
        )
    elif ended.ending == RUB:
        said = f"keeps rubbing: {RUBS[ended.response]}."
    elif ended.ending == FAILED:
        said = f"could not be followed: {ended.message}."
    else:
        said = f"{'still rubs, and ' * ended.rubs}had not settled: {ended.message}."
    return [*sentences, f"{held} {said}"]


def _after_horizon(run: xr.Dataset, ended: Ended) -> str:
    """Return that what follows a time is one of many possible motions, if it is.

    At standstill they all end clear of the stator if one does.
    """
    end = run["t"][-1]
    if "horizon" not in run or not run["horizon"] < end:
        return ""
    unit = str(run["t"].attrs.get("units", "1"))
    times = [quantity(float(each), unit, 3) for each in (run["horizon"], end)]
    rests = ended.ending == CONTACT_FREE and float(run["speed"][-1]) == 0.0
    follows = "what follows until it rests" if rests else "what follows, and how it ends,"
    return (
        f"After {times[0]} of {times[1]} this one motion depends on rounding: {follows} is one of "
        "many possible ones."
    )


def contact_in_words(
    facts: Mapping[str, float], ending: str, rotor: Rotor, machine: DimensionalRotor | None,
    running_speed: float | None = None, lies: str = "",
) -> str:  # fmt: skip
    """Return the verdict, with the closest approach to the stator or the largest force on it.

    Of a rotor that lies on the stator before, the words for that are given.

    Examples
    --------
    >>> facts = {"first_touch_speed": math.nan, "smallest_gap": 0.5, "largest_radius_speed": 1.1}
    >>> contact_in_words(facts, CONTACT_FREE, Rotor(omega=0.5, zeta=0.07, delta0=3.0), None)
    'No rub: closest to the stator at a speed of 1.1, where 0.5 of the clearance of 3 are left.'
    """
    scales = None if machine is None else scales_of(machine)
    return _verdict(facts, ending, rotor.delta0, scales, "the stator", running_speed, lies)


def _verdict(
    facts: Mapping[str, float], ending: str, clearance: float, scales: Scales | None, at: str,
    running_speed: float | None, lies: str = "",
) -> str:  # fmt: skip
    """Return the verdict on one contact at a place, with words for a rotor that lies there."""
    if math.isnan(facts["first_touch_speed"]):
        no_rub = "No rub on the way" if ending in (RUB, WHIP) else "No rub"
        gap, clearance_told = (_length(each, scales) for each in (facts["smallest_gap"], clearance))
        return (
            f"{no_rub}: closest to {at} at {_speed(facts['largest_radius_speed'], scales)}, "
            f"where {gap} of the clearance of {clearance_told} are left."
        )
    verdicts = {CONTACT_FREE: "Rub on the way, none at the end", WHIP: "Dry whip"}
    touch = facts["first_touch_speed"]
    margin = margin_in_words(touch * (scales.speed if scales else 1.0), running_speed)
    first = f"it first touches {at} at {_speed(touch, scales)}{margin}"
    if "first_touch_time" in facts:  # the explorer shows a run-up in pieces
        first += f", {_after(facts['first_touch_time'], scales)}"
    return (
        f"{verdicts.get(ending, 'Rub')}: {lies or first}, and presses up to "
        f"{_length(-facts['smallest_gap'], scales)} into it, with up to "
        f"{_force(facts['largest_force'], scales)} at "
        f"{_speed(facts['largest_force_speed'], scales)}."
    )


def margin_in_words(speed: float, running_speed: float | None) -> str:
    """Return how far a speed is above or below the running speed; empty without one.

    Examples
    --------
    >>> margin_in_words(5287.0, 3600.0), margin_in_words(2000.0, 3600.0)
    (', 47 % above the running speed', ', 44 % below the running speed')
    """
    if not running_speed:
        return ""
    percent = 100.0 * (abs(speed / running_speed) - 1.0)
    if abs(percent) < 0.5:
        return ", the running speed"
    return f", {abs(percent):.0f} % {'above' if percent > 0.0 else 'below'} the running speed"


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
    scales = None if machine is None else scales_of(machine)
    length = _length(indentation, scales)
    return beyond_in_words(f"an indentation of {length} is more than {bounds}")


class Scales(NamedTuple):
    """The SI values of a dimensionless 1 of speed, length and force."""

    speed: float
    length: float
    force: float


SI = Scales(1.0, 1.0, 1.0)


def scales_of(machine: DimensionalRotor) -> Scales:
    """Return the scales of a machine."""
    return Scales(machine.reference_frequency, machine.length_scale, machine.force_scale)


def _speed(speed: float, scales: Scales | None) -> str:
    if scales is None:
        return f"a speed of {quantity(speed)}"
    return quantity(speed * scales.speed, "rad/s")


def _after(time: float, scales: Scales | None) -> str:
    if time == 0.0:
        return "from the beginning"
    if scales is None:
        return f"after a time of {quantity(time, digits=3)}"
    return f"after {quantity(time / scales.speed, 's', 3)}"


def _length(length: float, scales: Scales | None) -> str:
    return quantity(length * (scales.length if scales else 1.0), "m" if scales else "1", 3)


def _force(force: float, scales: Scales | None) -> str:
    if scales is None:
        return f"a force of {quantity(force, digits=3)}"
    return quantity(force * scales.force, "N", 3)
