"""Limit cycles, branches and bifurcation curves as labelled datasets."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, ComplexValues, Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch import CLOSED, Side, SpecialBehind
from rotor_ida.cycles.guess import CLOSING_RTOL, Guess
from rotor_ida.cycles.multipliers import (
    is_stable,
    multipliers_near,
    multipliers_of,
    symplectic_defect,
    trivial_defect,
)
from rotor_ida.cycles.orbit import Orbit, disc_of
from rotor_ida.cycles.shooting import close_orbit, periods_of
from rotor_ida.model.contact import contact_force
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.model.whirl import steps_of_turning, whirl_over_spin
from rotor_ida.results.archived_system import OF_CONTACTS, described_problem
from rotor_ida.results.provenance import provenance
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import (
    LINE_KIND,
    QUANTITIES,
    RESPONSE,
    SPECIAL,
    STABILITY,
    WHIRL_DIRECTION,
    labelled,
    labelled_dataset,
)
from rotor_ida.schema.quantities import SPECIAL_VALUES
from rotor_ida.simulation.flow import RTOL, Flow
from rotor_ida.simulation.system_flow import SystemFlow
from rotor_ida.steady.follow import features_of_system

# The error of a cycle is estimated from further solutions with a tolerance looser by
LOOSER = 30.0
# begun at these fractions of the period, where rounding differs too:
ELSEWHERE = (0.23, 0.52, 0.81)
# this multiple of their largest difference.
ERROR_SAFETY = 5.0
# If these begin where the period allows, with tolerances looser still by
LOOSER_STILL = (1.0, 3.0, 10.0)
# Samples of one period of one disc, for the spectrum and plots: a power of two.
SAMPLES = 1024
# Lines at less than this part of the speed stand still; and those below this part of the largest
# are rounding, or what has not quite settled.
STANDS_STILL, NO_LINE = 1e-6, 1e-6
# Smallest spectral line that is reported, relative to the strongest.
WEAKEST_LINE = 1e-6
AXES = {True: "turning", False: "fixed"}
# Title and kind of what is followed over one parameter, and over two.
TITLES = {1: ("Branch of limit cycles", "branch"), 2: ("Bifurcation of limit cycles", "curve")}
Dims = dict[str, tuple[str, ...]]
# Dimensions of the numbers of a cycle: of any, of one disc, and of a rotor system.
OF_ANY = {
    "period": (), "response": (), "stability": (), "residual": (), "trivial_defect": (),
    "multiplier_real": ("multiplier",), "multiplier_imag": ("multiplier",),
}  # fmt: skip
OF_DISC = dict.fromkeys(
    ("radius_min", "radius_max", "contact_count", "largest_force", "impulse_per_period", "trace",
     "symplectic_defect"), (),
)  # fmt: skip
OF_SYSTEM = {
    "radius_min": ("contact",), "radius_max": ("contact",), "contact_count": ("contact",),
    "largest_force": ("contact",), "touched": ("contact",), "node_radius_min": ("node",),
    "node_radius_max": ("node",), "final_state": ("component",),
}  # fmt: skip
OF_ERRORS = {"period_error": (), "multiplier_error": ("multiplier",)}
# The whirl of one disc on a cycle, and its spectrum.
OF_WHIRL: Dims = dict.fromkeys(("whirl_over_spin", "side_line_over_spin", "whirl_sense"), ())
OF_LINES: Dims = dict.fromkeys(("line", "frequency", "whirl_amplitude", "line_kind"), ("line",))
WHOLE = {"response": np.int8, "stability": np.int8, "touched": np.int8, "whirl_sense": np.int8,
         "line_kind": np.int8, "line": np.int64}  # fmt: skip


def dims_of(flow: Flow) -> Dims:
    """Return the numbers of a cycle, with their dimensions."""
    return OF_ANY | (OF_SYSTEM if isinstance(flow, SystemFlow) else OF_DISC)


def _size_of(flow: Flow) -> int:
    """Return the number of components of a state."""
    return flow.scales.size if isinstance(flow, SystemFlow) else len(COMPONENTS)


def numbers_of(cycle: Orbit) -> dict[str, Any]:
    """Return the numbers of a cycle, by the names of `dims_of`."""
    multipliers = multipliers_of(cycle)
    return {
        "period": cycle.duration,
        "response": RESPONSE[cycle.response],
        "stability": STABILITY["stable" if is_stable(cycle) else "unstable"],
        "residual": cycle.residual,
        "trivial_defect": trivial_defect(cycle),
        "multiplier_real": multipliers.real,
        "multiplier_imag": multipliers.imag,
    } | (_of_system(cycle, cycle.flow) if isinstance(cycle.flow, SystemFlow) else _of_disc(cycle))


def _of_disc(cycle: Orbit) -> dict[str, Any]:
    return {
        "radius_min": cycle.radius_min,
        "radius_max": cycle.radius_max,
        "contact_count": cycle.contacts,
        "largest_force": cycle.largest_force,
        "impulse_per_period": cycle.impulse,
        "trace": float(cycle.monodromy.trace()),
        "symplectic_defect": symplectic_defect(cycle),
    }


def _of_system(cycle: Orbit, flow: SystemFlow) -> dict[str, Any]:
    times = flow.sample_times(cycle.duration)
    features = features_of_system(flow.observed(cycle.start, times))
    return {
        "radius_min": features.contact_low,
        "radius_max": features.contact_high,
        "contact_count": cycle.contact_counts,
        "largest_force": features.largest_force,
        "touched": features.touches,
        "node_radius_min": features.node_low,
        "node_radius_max": features.node_high,
        "final_state": flow.in_q(cycle.start),
    }


def cycle_columns(cycles: Sequence[Orbit], *dim: str) -> dict[str, xr.Variable]:
    """Return the numbers of cycles, one after the other on a dimension; or of one alone."""
    rows = [numbers_of(cycle) for cycle in cycles]
    columns = {
        name: of_cycle(name, (*dim, *dims), [row[name] for row in rows] if dim else rows[0][name])
        for name, dims in dims_of(cycles[0].flow).items()
    }
    if dim and not isinstance(cycles[0].flow, SystemFlow):
        columns |= state_columns(np.array([cycle.start for cycle in cycles]), *dim)
    return columns


def state_columns(states: Values, dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return states on the rotating axes, shape (n, 4), as variables ``x y vx vy``."""
    return {
        f"{prefix}{name}": labelled(f"rotating_{name}", dim, np.ascontiguousarray(column))
        for name, column in zip(COMPONENTS, states.T, strict=True)
    }


def of_cycle(name: str, dims: Hashable | Sequence[Hashable], values: npt.ArrayLike) -> xr.Variable:
    """Return a variable of limit cycles, with its separate label if the name has other uses."""
    known_as = f"cycle_{name}" if f"cycle_{name}" in QUANTITIES else name
    return labelled(known_as, dims, np.asarray(values, WHOLE.get(name)))


# ---- One cycle ----


def cycle_dataset(guess: Guess, cycle: Orbit | None, response: str) -> xr.Dataset:
    """Return a limit cycle, or the response found instead, as a labelled dataset."""
    flow = guess.flow
    variables = _none(flow, response) if cycle is None else cycle_columns([cycle])
    if cycle is not None:
        period_error, errors = _errors_of(cycle)
        variables["period_error"] = of_cycle("period_error", (), period_error)
        variables["multiplier_error"] = of_cycle("multiplier_error", "multiplier", errors)
    if isinstance(flow, SystemFlow):
        variables |= _period_of_system(flow, cycle)
        attributes: dict[str, Any] = {"rtol": CLOSING_RTOL}
    else:
        variables |= _period_of_disc(cycle)
        attributes = {"flight": "exact", "rtol": RTOL, **disc_of(flow).given, "start": guess.state}
        attributes |= {} if guess.period is None else {"start_period": guess.period}
    attributes = provenance({"method": "taylor", **attributes})
    return labelled_cycles("Limit cycle", flow, variables, {}, attributes, kind="cycle")


def _period_of_disc(cycle: Orbit | None) -> dict[str, xr.Variable]:
    """Return one period of one disc, and its spectrum."""
    if cycle is None:
        return state_columns(np.empty((0, 4)), "t") | {"t": of_cycle("t", "t", np.empty(0))}
    times = np.linspace(0.0, cycle.duration, SAMPLES + 1)
    states = cycle.flow.states(cycle.start, times)
    columns = {"t": of_cycle("t", "t", times)} | state_columns(states, "t")
    columns |= _lines(cycle, times, states)
    if cycle.rotor.delta0 == 0.0:  # the integral of a smooth periodic function
        radii = np.hypot(states[:-1, 0], states[:-1, 1])
        force = contact_force(radii, 0.0, cycle.rotor.contact_exponent)
        impulse = float(force.mean()) * cycle.duration
        columns["impulse_per_period"] = of_cycle("impulse_per_period", (), impulse)
    return columns


def _period_of_system(flow: SystemFlow, cycle: Orbit | None) -> dict[str, xr.Variable]:
    """Return one period of the nodes of a rotor system."""
    assembly = flow.problem.assembly
    times, orbits = np.zeros(0), np.zeros((4, 0, len(assembly.system.nodes)))
    if cycle is not None:
        times = flow.sample_times(cycle.duration)
        rows = flow.problem.found.rows_in_y(assembly.node_rows())
        moved = flow.motion_of(flow.states(cycle.start, times))  # (t, 2, n), where it closes
        place, velocity = (moved @ (rows[:, 0] + 1j * rows[:, 1]).T).transpose(1, 0, 2)
        orbits = np.stack([place.real, place.imag, velocity.real, velocity.imag])
    turns = "rotating_" if flow.period is None else ""
    columns = {
        name: labelled(f"{turns}{name}", ("t", "node"), values)
        for name, values in zip(COMPONENTS, orbits, strict=True)
    }
    return columns | {"t": of_cycle("t", "t", times)}


def _errors_of(cycle: Orbit) -> tuple[float, Values]:
    """Return the estimated errors of the period and of the multipliers."""
    looser, multipliers = _solved_again(cycle), multipliers_of(cycle)
    apart = np.abs([multipliers_near(multipliers, other) - multipliers for other in looser]).max(
        axis=0
    )
    errors = ERROR_SAFETY * (apart + np.spacing(np.abs(multipliers)))
    if cycle.is_autonomous:
        errors[multipliers == 1.0] = 0.0
    period_apart = max(abs(other.duration - cycle.duration) for other in looser)
    return ERROR_SAFETY * float(period_apart + np.spacing(cycle.duration)), errors


def _solved_again(cycle: Orbit) -> list[Orbit]:
    """Return further solutions with looser tolerances, begun elsewhere on the cycle.

    Rounding differs there too. They may be able to begin after whole revolutions only.
    """
    flow, found = cycle.flow, []
    times = periods_of(flow, cycle.duration)
    rtol = LOOSER * (CLOSING_RTOL if isinstance(flow, SystemFlow) else RTOL)
    for part, factor in zip(ELSEWHERE, LOOSER_STILL, strict=True):
        is_free = flow.period is None
        begins = part * cycle.duration if is_free else round(part * times) * flow.revolution
        begun = flow.after(cycle.start, begins) if begins else cycle.start
        looser = flow.but(rtol=rtol * (1.0 if is_free else factor))
        found.append(close_orbit(looser, begun, cycle.duration))
    return found


def _lines(cycle: Orbit, times: Values, states: Values) -> dict[str, xr.Variable]:
    """Return whirl and spectrum of one period: on fixed axes lines at omega + k 2 pi/T."""
    spin = cycle.rotor.omega * times
    z, is_loaded = states[:, 0] + 1j * states[:, 1], cycle.flow.period is not None
    whirl = whirl_of((z * np.exp(1j * spin))[:, np.newaxis], spin, stands=is_loaded)
    sizes = np.abs(np.fft.fft(z[:-1])) / (z.size - 1)
    orders = np.fft.fftfreq(sizes.size, 1.0 / sizes.size)
    chosen = np.flatnonzero(sizes >= WEAKEST_LINE * sizes.max())
    chosen = chosen[np.argsort(orders[chosen])]
    frequency = cycle.rotor.omega + 2.0 * math.pi / cycle.duration * orders[chosen]
    kinds = np.where(orders[chosen] == 0.0, LINE_KIND["spin"], np.sign(frequency)).astype(np.int8)
    if is_loaded:
        static = orders[chosen] == -float(periods_of(cycle.flow, cycle.duration))
        frequency[static], kinds[static] = 0.0, LINE_KIND["static"]
    return {
        "line": of_cycle("line", "line", np.arange(chosen.size)),
        "frequency": of_cycle("frequency", "line", frequency),
        "whirl_amplitude": of_cycle("whirl_amplitude", "line", sizes[chosen]),
        "line_kind": of_cycle("line_kind", "line", kinds),
        **{name: of_cycle(name, (), each[0]) for name, each in whirl.items()},
    }


def whirl_of(
    places: ComplexValues, angles: Values, *, stands: bool, at_the_spin: bool = False
) -> dict[str, Any]:
    """Return sense and speed of the whirl of each node, and its strongest line other than 1X.

    Parameters
    ----------
    places : ndarray of complex, shape (n + 1, node)
        Displacements at equal times, over which the motion repeats itself on rotating axes.
    angles : ndarray, shape (n + 1,)
        Angles by which the rotor has turned [rad].
    stands : bool
        Whether the motion may have a part that stands still, which is no whirl.
    at_the_spin : bool
        Whether it moves at the speed of the unbalance alone.
    """
    if at_the_spin or stands:
        places = places - places[:-1].mean(axis=0)
    sizes = np.abs(np.fft.fft((places * np.exp(-1j * angles)[:, np.newaxis])[:-1], axis=0))
    orders = 1.0 + np.fft.fftfreq(len(sizes), 1.0 / len(sizes)) * (2.0 * math.pi / angles[-1])
    sizes[np.abs(orders) < STANDS_STILL] = 0.0
    forward, backward = (np.linalg.norm(sizes[part], axis=0) for part in (orders > 0, orders < 0))
    turned = np.array([steps_of_turning(each).sum() for each in places.T])
    ratio, sense = whirl_over_spin(turned, angles[-1], forward, backward)
    largest = sizes.max(axis=0)
    sizes[0] = 0.0  # 1X, which is all of a motion that stands still on rotating axes
    sizes *= stands or not at_the_spin
    lines = orders[sizes.argmax(axis=0)]
    strongest = np.where(sizes.max(axis=0) > NO_LINE * largest, lines, math.nan)
    return {"whirl_over_spin": ratio, "whirl_sense": sense, "side_line_over_spin": strongest}


def _none(flow: Flow, response: str) -> dict[str, xr.Variable]:
    """Return the variables of a result without a limit cycle."""
    count, names = _size_of(flow), dims_of(flow) | OF_ERRORS
    sizes = {"multiplier": count, "component": count, "contact": flow.clearances.size, "line": 0}
    if isinstance(flow, SystemFlow):
        sizes["node"] = len(flow.problem.assembly.system.nodes)
    else:
        names |= OF_WHIRL | OF_LINES
    told: dict[str, int] = {
        "response": RESPONSE[response], "stability": STABILITY["absent"], "contact_count": 0,
        "touched": 0, "whirl_sense": WHIRL_DIRECTION["none"],
    }  # fmt: skip
    return {
        name: of_cycle(name, dims, np.full([sizes[dim] for dim in dims], told.get(name, math.nan)))
        for name, dims in names.items()
    }


def labelled_cycles(
    title: str, flow: Flow, variables: dict[str, Any], coordinates: dict[str, Any],
    attributes: Mapping[str, Any], *, kind: str,
) -> xr.Dataset:  # fmt: skip
    """Return cycles as a dataset with what their rotor is; `coordinates` are what varies."""
    multipliers = {"multiplier": ("multiplier", np.arange(_size_of(flow)))}
    if not isinstance(flow, SystemFlow):
        numbers = {name: ((), value) for name, value in disc_of(flow).given.items()}
        coordinates = numbers | coordinates | multipliers
        return labelled_dataset(title, variables, coordinates, attributes, kind=kind)
    assembly = flow.assembly
    held: dict[str, Any] = dict(described_problem(assembly))
    if OF_CONTACTS in variables:  # the clearance is what varies
        del held["clearance"]
    nodes = {"node": ("node", np.array(list(assembly.system.nodes), str))}
    aside = {name: held.pop(name) for name in ("axial_position",) if name in held}
    coordinates = {SPEED: ((), flow.speed)} | coordinates | nodes | multipliers | aside
    dataset = labelled_dataset(
        f"{title} of a rotor system", {**variables, **held}, coordinates,
        {**attributes, "axes": AXES[flow.period is None]}, kind=f"system_{kind}",
    )  # fmt: skip
    return in_words(dataset, assembly.system)


def in_words(dataset: xr.Dataset, system: RotorSystem) -> xr.Dataset:
    """Return cycles of a rotor system with their own words and units."""
    where = "distance of the contact from the centre of its stator"
    words = {
        "radius_min": f"smallest {where}", "radius_max": f"largest {where}",
        "special_radius_min": f"smallest {where} at the special point",
        "special_radius_max": f"largest {where} at the special point",
        "node_radius_min": "smallest distance of the node from the axis",
        "node_radius_max": "largest distance of the node from the axis",
        "touched": "whether the contact is touched",
        "final_state": "displacement and velocity of all coordinates, and speeds of races, at the "
        "start of the period, with the unbalance at angle 0",
    }  # fmt: skip
    for name in words.keys() & dataset.variables.keys():
        dataset[name].attrs["long_name"] = words[name]
    return with_system_units(dataset, system)


# ---- Branches, and curves of bifurcations ----


def start_attributes(guess: Guess) -> dict[str, object]:
    """Return, as attributes, the start from which a curve of cycles was followed."""
    flow, own = guess.flow, {"start_special": guess.special, "start_slope": guess.slope}
    if isinstance(flow, SystemFlow):
        told, state = {SPEED: flow.speed, **flow.given}, flow.in_q(guess.state)
        own["rtol"] = CLOSING_RTOL
    else:
        told, state = guess.rotor.given, guess.state
        own["flight"] = "exact"
    told = {f"start_{name}": value for name, value in told.items()}
    return {"start": state, "start_period": guess.period or math.nan, **told, **own}


def branch_dataset(sides: tuple[Side, Side], parameters: tuple[str, ...]) -> xr.Dataset:
    """Return both sides, forward and backward, of a curve of cycles, from end to end.

    `parameters` vary, in the order of the unknowns. One gives a branch, two a curve of
    bifurcations.
    """
    forward, backward = sides
    before = len(backward.points) - 1
    points = [point.reversed() for point in backward.points[:0:-1]] + forward.points
    specials = [SpecialBehind(before - place - 1, each) for place, each in backward.specials[::-1]]
    specials += [SpecialBehind(before + place, each) for place, each in forward.specials]
    place, flow = -len(parameters), forward.points[0].orbit.flow
    variables: dict[str, Any] = cycle_columns([point.orbit for point in points], "point")
    variables["slope"] = of_cycle("slope", "point", [point.tangent[place] for point in points])
    variables |= _special_columns(specials, parameters, flow)
    coordinates: dict[str, Any] = {
        name: ("point", np.array([point.unknowns[place + number] for point in points]))
        for number, name in enumerate(parameters)
    }
    closed, is_system = forward.end == CLOSED, isinstance(flow, SystemFlow)
    ends: dict[str, Any] = {
        "closed": int(closed),
        "first_end": CLOSED if closed else backward.end or "start",
        "last_end": forward.end or "start",
        "first_reason": backward.reason,
        "last_reason": forward.reason,
    }
    if is_system and "clearance" in parameters:
        gaps = np.array([point.orbit.flow.clearances for point in points])
        variables[OF_CONTACTS] = (("point", "contact"), gaps)
    title, kind = TITLES[len(parameters)]
    dataset = labelled_cycles(title, flow, variables, coordinates, ends, kind=kind)
    for name, value in zip(parameters, SPECIAL_VALUES, strict=False):
        attributes = dataset.variables[name].attrs
        if is_system and name in PARAMETERS_OF_SYSTEM:
            attributes["long_name"] = PARAMETERS_OF_SYSTEM[name].meaning
        words = f"{attributes['long_name']}, at the special point"
        dataset.variables[value].attrs |= {**attributes, "long_name": words}
    return dataset


def _special_columns(
    specials: Sequence[SpecialBehind], parameters: tuple[str, ...], flow: Flow
) -> dict[str, Column | xr.Variable]:
    """Return the special points, in order along the curve."""
    orbits, count = [each.point.orbit for _, each in specials], flow.clearances.size
    sizes = np.array([orbit.sizes for orbit in orbits]).reshape(-1, 2, count)
    columns: dict[str, Any] = {
        "special_kind": ("special", np.array([SPECIAL[e.name] for _, e in specials], np.int8)),
        "special_period": ("special", np.array([orbit.duration for orbit in orbits])),
        "special_point": ("special", np.array([number for number, _ in specials], np.int64)),
    }
    values = [
        ("special", np.array([each.point.unknowns[place] for _, each in specials]))
        for place in range(-len(parameters), 0)
    ]
    columns |= dict(zip(SPECIAL_VALUES, values, strict=False))
    is_system, starts = isinstance(flow, SystemFlow), [orbit.start for orbit in orbits]
    for name, each in (("special_radius_min", sizes[:, 0]), ("special_radius_max", sizes[:, 1])):
        columns[name] = (("special", "contact"), each) if is_system else ("special", each[:, 0])
    if isinstance(flow, SystemFlow):
        states = np.array([flow.in_q(start) for start in starts]).reshape(-1, _size_of(flow))
        return columns | {"special_state": (("special", "component"), states)}
    return columns | state_columns(np.array(starts).reshape(-1, 4), "special", "special_")
