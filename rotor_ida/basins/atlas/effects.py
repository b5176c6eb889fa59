"""What an attractor does to a rotor: forces, losses and whirl, from a run along it.

A whirl of one disc has its numbers by closed forms. A limit cycle is followed for a period, a
motion without a period for many revolutions.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.basins.attractors import AT_THE_SPIN, CONTACT_FREE_FAMILY, has_period, kind_of
from rotor_ida.basins.subjects import KnockedSystem
from rotor_ida.core.runs import NO_STOP
from rotor_ida.cycles.dataset import whirl_of
from rotor_ida.model.contact import contact_force
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import WHIRL_DIRECTION
from rotor_ida.schema.flags import ENTRY, EXIT
from rotor_ida.signals.forces import contact_forces
from rotor_ida.simulation.contact_table import contact_summary
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady import response

# Length of a run without a period, in revolutions,
REVOLUTIONS = 64
# with this number of samples in each, of one disc at least these.
SAMPLES, FEWEST_SAMPLES = 256, 2048
# Numbers of an attractor of one disc that may be absent,
NUMBERS = (
    "largest_force", "mean_force", "contacts_per_revolution", "contact_fraction",
    "dissipation_per_revolution", "whirl_over_spin", "side_line_over_spin", "excursion",
)  # fmt: skip
# and with friction.
OF_FRICTION = ("heat_per_revolution", "slip_distance_per_revolution", "rolling_fraction")
LOSS = "contact_loss_per_revolution"


def effects_of(rotor: Rotor | KnockedSystem, row: np.void) -> dict[str, Any]:
    """Return what an attractor does to a rotor, by name: numbers, of a system arrays."""
    if isinstance(rotor, KnockedSystem):
        return _of_system(rotor, row)
    kind, numbers = kind_of(row), dict[str, Any](dict.fromkeys(NUMBERS, math.nan))
    numbers["whirl_sense"] = WHIRL_DIRECTION["none"]
    if rotor.contact_damping > 0.0:
        numbers[LOSS] = math.nan
    if rotor.friction > 0.0:
        numbers |= dict.fromkeys(OF_FRICTION, math.nan)
    if rotor.delta0 > 0.0:  # NaN where the radius depends on the start
        numbers["excursion"] = row["radius_max"] / rotor.delta0
    if kind in AT_THE_SPIN:
        return numbers | _of_whirl(rotor, row)
    if rotor.contact_damping == 0.0 and (has_period(row) or kind == response.CHAOTIC):
        # the force is largest where the radius is
        numbers["largest_force"] = _force(rotor, row["radius_max"])
    if kind == response.CHAOTIC:  # which a run may leave
        return numbers
    found = _of_run(rotor, row)
    return numbers | found | {name: value for name, value in numbers.items()
                              if name == "largest_force" and not math.isnan(value)}  # fmt: skip


def _force(rotor: Rotor, radius: float) -> float:
    return float(contact_force(radius, rotor.delta0, rotor.contact_exponent))


def _of_whirl(rotor: Rotor, row: np.void) -> dict[str, float]:
    """Return the numbers of a whirl of one disc, or of the limit of touches that fade."""
    kind, size = kind_of(row), float(row["amplitude"])
    rubs = kind == response.SYNCHRONOUS
    steady = _force(rotor, size) if rubs else 0.0
    numbers = {
        "largest_force": steady, "mean_force": steady, "contact_fraction": float(rubs),
        # fading touches occur once a revolution and vanish in the limit
        "contacts_per_revolution": float(kind == response.TOUCHING),
        "dissipation_per_revolution": 4.0 * math.pi * rotor.zeta * rotor.omega * size**2,
        "whirl_over_spin": 1.0, "whirl_sense": WHIRL_DIRECTION["forward"],
    }  # fmt: skip
    if rotor.contact_damping > 0.0:  # at a constant radius, or in touches that vanish
        numbers[LOSS] = 0.0
    if rotor.friction > 0.0:  # it slides forwards throughout
        distance = 2.0 * math.pi * (size + (rotor.disc_radius or 0.0)) if rubs else 0.0
        numbers["heat_per_revolution"] = rotor.friction * steady * distance
        numbers["slip_distance_per_revolution"] = distance
        numbers["rolling_fraction"] = 0.0 if rubs else math.nan
        numbers["dissipation_per_revolution"] += numbers["heat_per_revolution"]
    return numbers


def _of_run(rotor: Rotor, row: np.void) -> dict[str, Any]:
    """Return the numbers of a motion of one disc that is no whirl, from a run along it."""
    turns = row["period"] * rotor.omega / (2.0 * math.pi) if has_period(row) else REVOLUTIONS
    count = max(FEWEST_SAMPLES, math.ceil(SAMPLES * turns))
    run = simulate(
        rotor, start=row["final_state"], duration=turns * 2.0 * math.pi / rotor.omega,
        samples=count + 1, method="taylor",
    )  # fmt: skip
    told, forces = contact_summary(run), contact_forces(run)
    mean = float(told["total_impulse"]) / float(run.attrs["duration"])
    if math.isnan(mean):  # without clearance: of a smooth function, whose mean samples give
        mean = float(forces["normal_force" if rotor.friction > 0.0 else "force"][:-1].mean())
    kinds = run["event_kind"].values
    viscous = 2.0 * rotor.zeta * float((run["vx"] ** 2 + run["vy"] ** 2)[:-1].mean())
    names = (
        "largest_force", "contact_fraction", *((LOSS,) if rotor.contact_damping > 0.0 else ()),
        *(("heat_per_revolution", "rolling_fraction") if rotor.friction > 0.0 else ()),
    )  # fmt: skip
    numbers = {name: float(told[name]) for name in names}
    if rotor.friction > 0.0:
        numbers["slip_distance_per_revolution"] = float(told["total_slip_distance"]) / turns
    angles = rotor.omega * run["t"].values
    places = run["x"].values + 1j * run["y"].values
    whirl = whirl_of(places[:, np.newaxis], angles, stands=rotor.load > 0.0)
    return numbers | {name: each[0] for name, each in whirl.items()} | {
        "mean_force": mean,
        # at an event at the very start, rounding may omit one of these
        "contacts_per_revolution": max((kinds == ENTRY).sum(), (kinds == EXIT).sum()) / turns,
        "dissipation_per_revolution": viscous * 2.0 * math.pi / rotor.omega
        + numbers.get(LOSS, 0.0) + numbers.get("heat_per_revolution", 0.0),
    }  # fmt: skip


def _of_system(knocked: KnockedSystem, row: np.void) -> dict[str, Any]:
    """Return the numbers of an attractor of a rotor system, from a run along it."""
    flow, kind = knocked.flow(NO_STOP), kind_of(row)
    turns = float(row["period"]) / flow.revolution if has_period(row) else REVOLUTIONS
    if kind in AT_THE_SPIN:
        turns = 1.0
    duration, contacts = turns * flow.revolution, flow.problem.assembly.contacts
    times = np.linspace(0.0, duration, math.ceil(SAMPLES * turns) + 1)
    run = flow.sampled(flow.given_state(row["final_state"]), times)
    table, count = run.episodes, len(contacts)

    def summed(values: Values) -> Values:
        own = np.bincount(table["contact"].astype(np.int64), values, minlength=count)
        return own.astype(np.float64)  # of no episodes it has whole numbers

    # touches that fade last for no time in the limit
    lasting = 0.0 if kind in CONTACT_FREE_FAMILY else 1.0
    closed = lasting * summed(
        np.nan_to_num(table["exit"], nan=duration) - np.nan_to_num(table["entry"])
    )
    entries = run.event_contacts[run.event_kinds == ENTRY]
    heat, damped = summed(table["heat"]) / turns, [each.damping > 0.0 for each in contacts]
    loss = np.where(damped, summed(table["work"]) / turns, 0.0)
    of_friction = {
        "heat_per_revolution": heat,
        "slip_distance_per_revolution": summed(table["slip_distance"]) / turns,
        "rolling_fraction": summed(table["rolling_time"]) / np.where(closed > 0.0, closed, 1.0),
    } if any(each.friction > 0.0 for each in contacts) else {}  # fmt: skip
    size = 2 * flow.problem.assembly.size
    states = run.samples.reshape(len(times), -1) / flow.scales[:size]
    places = flow.places(states, nodes=True)[0, :, count:]
    places = places if flow.speed > 0.0 else places.conj()  # lines of forward whirls are positive
    whirl = whirl_of(
        places, abs(flow.speed) * times, stands=flow.period is not None,
        at_the_spin=kind in AT_THE_SPIN,
    )  # fmt: skip
    return {
        "excursion": row["radius_max"] / np.where(flow.clearances > 0.0, flow.clearances, np.nan),
        "mean_force": lasting * summed(table["impulse"]) / duration,
        "contacts_per_revolution": np.bincount(entries, minlength=count) / turns,
        "contact_fraction": closed / duration,
        "dissipation_per_revolution": run.ledger["damping"] / turns + float((heat + loss).sum()),
        **({LOSS: loss} if any(damped) else {}), **of_friction, **whirl,
    }  # fmt: skip
