"""What touching the ring does to a machine: a line of numbers for each of its attractors."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.atlas.cells import Cell, CellJob, Member, fill_cell
from rotor_ida.atlas.dataset import RISK
from rotor_ida.basins.fractions import drawn_from, range_of
from rotor_ida.basins.labelling import LOOSEST, RTOL, TIGHTEST, check_rotor
from rotor_ida.checks import (
    COMPONENTS,
    check_array,
    check_between,
    check_count,
    check_seed,
    shown,
)
from rotor_ida.cycles.limit_cycle import follow, whirl_beside
from rotor_ida.cycles.shooting import close_orbit
from rotor_ida.equations.contact import contact_force
from rotor_ida.errors import InputError
from rotor_ida.parallel import interruptible
from rotor_ida.parameters import PARAMETERS, DimensionalRotor, Rotor
from rotor_ida.provenance import provenance
from rotor_ida.schema import RESPONSE, TRAPPING, WHIRL_DIRECTION, Column, labelled_dataset
from rotor_ida.si_units import dimensional
from rotor_ida.simulation.dataset import parameter_coordinates
from rotor_ida.simulation.options import LARGEST, Options
from rotor_ida.stability.orbit import ENTRY, EXIT, Shot
from rotor_ida.sweeps import response

Values = npt.NDArray[np.float64]

SAMPLES = 2048
MOST_STARTS = 1_000_000
OWN = ("amplitude", "radius_min", "radius_max", "period", "lifetime", "lifetime_low")
NUMBERS = (
    "largest_force", "mean_force", "contacts_per_revolution", "contact_fraction",
    "dissipation_per_revolution", "whirl_ratio", "excursion",
)  # fmt: skip


def touchdown_report(
    machine: DimensionalRotor | Rotor,
    *,
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    vx: npt.ArrayLike = 0.0,
    vy: npt.ArrayLike = 0.0,
    starts: int = 1000,
    seed: int = 0,
    rtol: float = RTOL,
) -> xr.Dataset:
    """Return what each attractor of a machine does to it, and how likely it is.

    Parameters
    ----------
    machine : DimensionalRotor or Rotor
        The machine. For a `DimensionalRotor` starts and results are in SI units; for a `Rotor`
        they are dimensionless.
    x, y, vx, vy : float or array_like, shape (2,)
        Components of the start [m], [m/s] or [1]: numbers, or ranges ``(low, high)`` from which
        they are drawn, independently and uniformly.
    starts : int
        Number of starts.
    seed : int
        Seed of the random numbers: the same seed gives the same starts.
    rtol : float
        As for `rotor_ida.basin`.

    Returns
    -------
    Dataset
        On ``attractor``: ``kind``; ``fraction`` and ``fraction_error`` of the starts that end
        there, ``settling_median`` and ``settling_95`` [s]; ``largest_force`` and its mean over the
        time, ``mean_force`` (the impulse a second) [N]; ``contacts_per_revolution`` and
        ``contact_fraction``, the share of time in contact; ``dissipation_per_revolution``, the
        energy that damping takes [J]; ``whirl_ratio`` and ``whirl_direction`` of the strongest
        whirl beside the spin; ``radius_min``, ``radius_max``, ``period`` [m], [s]; ``excursion``,
        the largest distance from the bearing axis over the clearance. Of chaos what needs a period
        is NaN.

    Raises
    ------
    InputError
        If an argument cannot be used, or the machine does not turn.

    Notes
    -----
    Energy comes from the drive and leaves through damping alone, ``2 zeta |z'|**2``: the Hertz
    contact gives back all that it takes.

    Examples
    --------
    >>> machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
    ...                            eccentricity=1e-6, clearance=2e-6, speed=1000.0)
    >>> report = touchdown_report(machine, x=(-1e-5, 1e-5), y=(-1e-5, 1e-5), starts=100)
    >>> report.largest_force.dims, report.largest_force.attrs["units"]
    (('attractor',), 'N')
    """
    rotor, length, velocity = _scales(machine)
    check_rotor(rotor)
    if rotor.omega == 0.0:
        raise InputError("speed must be above 0 for a report on touching, got 0.0")
    count = check_count("starts", starts, maximum=MOST_STARTS)
    chosen, tolerance = check_seed(seed), check_between("rtol", rtol, TIGHTEST, LOOSEST)
    given = {"x": x, "y": y, "vx": vx, "vy": vy}
    box = np.array([range_of(name, given[name]) for name in COMPONENTS])
    scaled = box / np.array([length, length, velocity, velocity])[:, None]
    check_array("x, y, vx and vy, in eccentricities,", scaled, largest=LARGEST)
    job = CellJob(rotor, drawn_from(scaled, chosen, 0, count), tolerance)
    cell = interruptible(lambda stop: fill_cell(job, stop))
    told = {"starts": count, "seed": chosen, "labelling_rtol": tolerance}
    ranges = {f"range_{name}": ends for name, ends in zip(COMPONENTS, box, strict=True)}
    report = _dataset(cell, count, {**told, **ranges})
    return dimensional(report, machine) if isinstance(machine, DimensionalRotor) else report


def _dataset(cell: Cell, starts: int, attributes: Mapping[str, object]) -> xr.Dataset:
    """Return what each attractor does, dimensionless, as a labelled dataset."""
    members = cell.members
    rows = [_numbers(cell.rotor, each) for each in members]
    part = np.array([each.count for each in members]) / starts
    settling = np.array([each.settling for each in members]).reshape(-1, 2)
    columns: dict[str, npt.ArrayLike] = {
        **{name: np.array([row[name] for row in rows], float) for name in NUMBERS},
        **{name: np.array([getattr(each.attractor, name) for each in members]) for name in OWN},
        "kind": np.array([RESPONSE[each.attractor.kind] for each in members], np.int8),
        "trapping": np.array([TRAPPING[each.attractor.trapping] for each in members], np.int8),
        "whirl_direction": np.array([_direction(row) for row in rows], np.int8),
        "fraction": part,
        "fraction_error": np.sqrt(part * (1.0 - part) / starts),
        "settling_median": settling[:, 0],
        "settling_95": settling[:, 1],
    }
    variables: dict[str, Column] = {
        name: ("attractor", np.asarray(column)) for name, column in columns.items()
    }
    variables["undecided_fraction"] = ((), cell.undecided / starts)
    variables["missed_fraction"] = ((), 1.0 - RISK ** (1.0 / starts))
    coordinates = parameter_coordinates(cell.rotor)
    coordinates["attractor"] = ("attractor", np.arange(len(members)))
    told = {**provenance(Options().attributes()), **attributes}
    told |= {name: getattr(cell.rotor, name) for name in PARAMETERS}
    return labelled_dataset("What touching the ring does", variables, coordinates, told)


def _scales(machine: object) -> tuple[Rotor, float, float]:
    """Return the rotor of a machine, and what a dimensionless length and velocity of 1 are."""
    if isinstance(machine, DimensionalRotor):
        return machine.rotor(), machine.length_scale, machine.velocity_scale
    if isinstance(machine, Rotor):
        return machine, 1.0, 1.0
    raise InputError(f"machine must be a DimensionalRotor or a Rotor, got {shown(machine)}")


def _numbers(rotor: Rotor, member: Member) -> dict[str, float]:
    """Return what one attractor does, dimensionless."""
    attractor = member.attractor
    numbers = dict.fromkeys(NUMBERS, math.nan)
    if rotor.delta0 > 0.0:  # NaN where the radius hangs on the start
        numbers["excursion"] = attractor.radius_max / rotor.delta0
    if attractor.kind == response.CHAOTIC:
        numbers["largest_force"] = float(contact_force(attractor.radius_max, rotor.delta0))
        return numbers
    if attractor.period > 0.0:
        return numbers | _of_cycle(rotor, member)
    force = 0.0
    if attractor.kind == response.SYNCHRONOUS:
        force = float(contact_force(attractor.amplitude, rotor.delta0))
    numbers["largest_force"] = numbers["mean_force"] = force
    numbers["contact_fraction"] = float(attractor.kind == response.SYNCHRONOUS)
    # the touches of a motion that fades come once a revolution, and are nothing in the limit
    numbers["contacts_per_revolution"] = float(attractor.kind == response.TOUCHING)
    speed = rotor.omega * attractor.amplitude
    numbers["dissipation_per_revolution"] = 4.0 * math.pi * rotor.zeta * speed**2 / rotor.omega
    return numbers


def _of_cycle(rotor: Rotor, member: Member) -> dict[str, float]:
    """Return what a limit cycle does, from one period of it."""
    stop, period = np.zeros(1, np.uint8), member.attractor.period
    cycle = close_orbit(rotor, member.state, period, stop)
    states = follow(rotor, cycle.state, cycle.period / SAMPLES, SAMPLES + 1, stop)[:-1]
    revolution = 2.0 * math.pi / rotor.omega
    impulse = cycle.impulse
    if math.isnan(impulse):  # without clearance: the integral of a smooth periodic function
        force = contact_force(np.hypot(states[:, 0], states[:, 1]), rotor.delta0)
        impulse = float(force.mean()) * cycle.period
    # velocities read on the rotating axes are those of the fixed ones, turned
    power = 2.0 * rotor.zeta * float((states[:, 2] ** 2 + states[:, 3] ** 2).mean())
    return {
        "largest_force": cycle.largest_force,
        "mean_force": impulse / cycle.period,
        "contacts_per_revolution": cycle.contacts * revolution / cycle.period,
        "contact_fraction": _time_in_contact(cycle.shot) / cycle.period if cycle.contacts else 1.0,
        "dissipation_per_revolution": power * revolution,
        "whirl_ratio": whirl_beside(cycle, states)[0],
    }


def _time_in_contact(shot: Shot) -> float:
    """Return for how long a closed orbit is in contact; one contact may go on over its end."""
    entry = np.nan_to_num(shot.contacts[:, ENTRY], nan=0.0)
    leaving = np.nan_to_num(shot.contacts[:, EXIT], nan=shot.duration)
    return float((leaving - entry).sum())


def _direction(numbers: dict[str, float]) -> int:
    ratio = numbers["whirl_ratio"]
    if math.isnan(ratio):
        return WHIRL_DIRECTION["none"]
    return WHIRL_DIRECTION["forward" if ratio > 0.0 else "backward"]
