"""Limit cycles, branches and bifurcation curves as labelled datasets."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop, Values
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.branch import CLOSED, Side, SpecialBehind
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.multipliers import (
    defects_of,
    is_stable,
    multipliers_near,
    multipliers_of,
)
from rotor_ida.cycles.problems import PLACE
from rotor_ida.cycles.shooting import (
    Cycle,
    checked_cycle,
    close_orbit,
    period_of,
    revolutions_of,
    sampled_orbit,
)
from rotor_ida.model.contact import contact_force
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.whirl import steps_of_turning, whirl_over_spin
from rotor_ida.results.provenance import provenance
from rotor_ida.schema import (
    LINE_KIND,
    QUANTITIES,
    RESPONSE,
    SPECIAL,
    STABILITY,
    WHIRL_DIRECTION,
    Column,
    labelled,
    labelled_dataset,
)
from rotor_ida.simulation.neighbours import RTOL, Shot

# The error of a cycle is estimated from further solutions with a looser tolerance,
LOOSER_RTOL = 30.0 * RTOL
# begun at these fractions of the period, where rounding differs too:
ELSEWHERE = (0.23, 0.52, 0.81)
# this multiple of their largest difference.
ERROR_SAFETY = 5.0
# Under a load these begin where the period allows, with tolerances looser by
LOOSER_STILL = (1.0, 3.0, 10.0)
# Samples of one period, for the spectrum and plots: a power of two.
SAMPLES = 1024
# Below this fraction of the spin speed a motion is stationary, up to rounding.
STANDS_STILL = 1e-9
# Smallest spectral line that is reported, relative to the strongest.
WEAKEST_LINE = 1e-6


def cycle_columns(cycles: Sequence[Cycle], dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return the numbers of cycles, one after the other on a dimension; names get the prefix."""
    multipliers = np.array([multipliers_of(cycle.shot) for cycle in cycles]).reshape(len(cycles), 4)
    defects = np.array([defects_of(cycle.shot) for cycle in cycles]).reshape(len(cycles), 2)
    stable = [STABILITY["stable" if is_stable(cycle.shot) else "unstable"] for cycle in cycles]
    columns: dict[str, Column] = {
        "period": (dim, _of(cycles, "period")),
        "radius_min": (dim, _of(cycles, "radius_min")),
        "radius_max": (dim, _of(cycles, "radius_max")),
        "response": (dim, np.array([RESPONSE[cycle.response] for cycle in cycles], dtype=np.int8)),
        "stability": (dim, np.array(stable, dtype=np.int8)),
        "contact_count": (dim, np.array([cycle.contacts for cycle in cycles], dtype=np.int64)),
        "largest_force": (dim, _of(cycles, "largest_force")),
        "impulse_per_period": (dim, _of(cycles, "impulse")),
        "multiplier_real": ((dim, "multiplier"), multipliers.real),
        "multiplier_imag": ((dim, "multiplier"), multipliers.imag),
        "trace": (dim, np.array([float(cycle.shot.monodromy.trace()) for cycle in cycles])),
        "residual": (dim, _of(cycles, "residual")),
        "trivial_defect": (dim, defects[:, 0]),
        "symplectic_defect": (dim, defects[:, 1]),
    }
    states = np.array([cycle.state for cycle in cycles]).reshape(len(cycles), 4)
    return {
        f"{prefix}{name}": of_cycle(name, *column) for name, column in columns.items()
    } | state_columns(states, dim, prefix)


def state_columns(states: Values, dim: str, prefix: str = "") -> dict[str, xr.Variable]:
    """Return states on the rotating axes, shape (n, 4), as variables ``x y vx vy``."""
    return {
        f"{prefix}{name}": xr.Variable(
            dim, np.ascontiguousarray(column), QUANTITIES[f"rotating_{name}"].attributes()
        )
        for name, column in zip(COMPONENTS, states.T, strict=True)
    }


def of_cycle(name: str, dims: Hashable | Sequence[Hashable], values: npt.ArrayLike) -> xr.Variable:
    """Return a variable of limit cycles, with its separate label if the name has other uses."""
    quantity = QUANTITIES[f"cycle_{name}" if f"cycle_{name}" in QUANTITIES else name]
    return xr.Variable(dims, np.asarray(values), quantity.attributes())


def _of(cycles: Sequence[Cycle], name: str) -> Values:
    return np.array([getattr(cycle, name) for cycle in cycles], dtype=np.float64)


# ---- One cycle ----


def cycle_dataset(rotor: Rotor, guess: Guess, cycle: Cycle | None, response: str) -> xr.Dataset:
    """Return a limit cycle, or the response found instead, as a labelled dataset."""
    coordinates: dict[str, Column] = {name: ((), value) for name, value in rotor.given.items()}
    coordinates["multiplier"] = ("multiplier", np.arange(4))
    attributes = provenance({"method": "taylor", "flight": "exact", "rtol": RTOL}) | {
        **rotor.given,
        "start": guess.state,
    }
    if guess.period is not None:
        attributes["start_period"] = guess.period
    variables = _none(response) if cycle is None else _columns(cycle)
    title = "Limit cycle on the rotating axes"
    return labelled_dataset(title, variables, coordinates, attributes, kind="cycle")


def _columns(cycle: Cycle) -> dict[str, xr.Variable]:
    """Return the numbers, one period and the spectrum of a cycle as variables."""
    columns = {
        name: variable.isel(cycle=0) for name, variable in cycle_columns([cycle], "cycle").items()
    }
    stop = np.zeros(1, np.uint8)
    states = sampled_orbit(cycle.rotor, cycle.state, cycle.period / SAMPLES, SAMPLES + 1, stop)
    looser = _solved_again(cycle, states, stop)
    multipliers = multipliers_of(cycle.shot)
    apart = np.abs(
        [multipliers_near(multipliers, other.shot) - multipliers for other in looser]
    ).max(axis=0)
    errors = ERROR_SAFETY * (apart + np.spacing(np.abs(multipliers)))
    if cycle.rotor.load == 0.0:
        errors[multipliers == 1.0] = 0.0
    period_apart = max(abs(other.period - cycle.period) for other in looser)
    period_error = ERROR_SAFETY * (period_apart + np.spacing(cycle.period))
    columns["period_error"] = of_cycle("period_error", (), period_error)
    columns["multiplier_error"] = of_cycle("multiplier_error", "multiplier", errors)
    if cycle.rotor.delta0 == 0.0:  # the integral of a smooth periodic function
        radii = np.hypot(states[:-1, 0], states[:-1, 1])
        force = contact_force(radii, 0.0, cycle.rotor.contact_exponent)
        impulse = float(force.mean()) * cycle.period
        columns["impulse_per_period"] = of_cycle("impulse_per_period", (), impulse)
    times = np.linspace(0.0, cycle.period, SAMPLES + 1)
    return (
        columns
        | {"t": of_cycle("t", "t", times)}
        | state_columns(states, "t")
        | _lines(cycle, states)
    )


def _solved_again(cycle: Cycle, states: Values, stop: Stop) -> list[Cycle]:
    """Return further solutions with looser tolerances, begun elsewhere on the cycle.

    Rounding differs there too. Under a load they can begin only after whole revolutions.
    """
    rotor, period = cycle.rotor, cycle.period
    if rotor.load == 0.0:
        return [
            close_orbit(rotor, states[round(part * SAMPLES)], period, stop, LOOSER_RTOL)
            for part in ELSEWHERE
        ]
    revolutions = revolutions_of(rotor, period)
    begun = sampled_orbit(rotor, cycle.state, period_of(rotor, 1), revolutions + 1, stop)
    return [
        close_orbit(rotor, begun[round(part * revolutions)], period, stop, factor * LOOSER_RTOL)
        for part, factor in zip(ELSEWHERE, LOOSER_STILL, strict=True)
    ]


def _lines(cycle: Cycle, states: Values) -> dict[str, xr.Variable]:
    """Return the spectrum of one period: on fixed axes lines at omega + k 2 pi/T."""
    whirl, (orders, sizes) = whirl_of_cycle(cycle, states), lines_of(states)
    chosen = np.flatnonzero(sizes >= WEAKEST_LINE * sizes.max())
    chosen = chosen[np.argsort(orders[chosen])]
    frequency = cycle.rotor.omega + 2.0 * math.pi / cycle.period * orders[chosen]
    kinds = np.where(orders[chosen] == 0.0, LINE_KIND["spin"], np.sign(frequency)).astype(np.int8)
    if (static := static_order(cycle)) is not None:
        frequency[orders[chosen] == static] = 0.0
        kinds[orders[chosen] == static] = LINE_KIND["static"]
    return {
        "line": of_cycle("line", "line", np.arange(chosen.size)),
        "frequency": of_cycle("frequency", "line", frequency),
        "whirl_amplitude": of_cycle("whirl_amplitude", "line", sizes[chosen]),
        "line_kind": of_cycle("line_kind", "line", kinds),
        **{name: of_cycle(name, (), each) for name, each in whirl.items()},
        "whirl_sense": of_cycle("whirl_sense", (), np.int8(whirl["whirl_sense"])),
    }


def lines_of(states: Values) -> tuple[Values, Values]:
    """Return order k and amplitude of all lines at ``omega + k 2 pi/T``.

    `states`, shape (n + 1, 4), are one period on the rotating axes, at equal times, both ends
    included.
    """
    heights = np.fft.fft(states[:-1, 0] + 1j * states[:-1, 1]) / (len(states) - 1)
    orders = np.asarray(np.fft.fftfreq(heights.size, 1.0 / heights.size), dtype=np.float64)
    return orders, np.abs(heights)


def whirl_of_cycle(cycle: Cycle, states: Values) -> dict[str, float]:
    """Return sense and speed of the whirl on a cycle, and its strongest line other than 1X.

    `states` are one period as for `lines_of`. A stationary line is no whirl.
    """
    omega, period = cycle.rotor.omega, cycle.period
    orders, sizes = lines_of(states)
    frequency = omega + 2.0 * math.pi / period * orders
    moves = np.abs(frequency) > STANDS_STILL * omega
    if (static := static_order(cycle)) is not None:
        moves &= orders != static
    forward, backward = (
        math.sqrt(float((sizes[moves & chosen] ** 2).sum()))
        for chosen in (frequency > 0.0, frequency < 0.0)
    )
    times = np.linspace(0.0, period, len(states))
    z = (states[:, 0] + 1j * states[:, 1]) * np.exp(1j * omega * times)
    if static is not None:
        z -= z[:-1].mean()
    turned = float(steps_of_turning(z).sum())
    ratio, sense = whirl_over_spin(turned, omega * period, forward, backward)
    beside = np.flatnonzero(moves & (orders != 0.0))
    strongest = float(frequency[beside[np.argmax(sizes[beside])]])
    return {
        "whirl_over_spin": float(ratio),
        "whirl_sense": int(sense),
        "side_line_over_spin": strongest / omega,
    }


def static_order(cycle: Cycle) -> float | None:
    """Return the order of the line at frequency 0 under a load; None without a load."""
    return -float(revolutions_of(cycle.rotor, cycle.period)) if cycle.rotor.load > 0.0 else None


def _none(response: str) -> dict[str, xr.Variable]:
    """Return the variables of a result without a limit cycle."""
    numbers = (
        *("period", "period_error", "radius_min", "radius_max", "largest_force"),
        *("impulse_per_period", "trace", "residual", "trivial_defect", "symplectic_defect"),
        *("whirl_over_spin", "side_line_over_spin"),
    )
    columns = {name: of_cycle(name, (), math.nan) for name in numbers}
    columns |= {
        name: of_cycle(name, "multiplier", np.full(4, math.nan))
        for name in ("multiplier_real", "multiplier_imag", "multiplier_error")
    }
    columns["response"] = of_cycle("response", (), np.int8(RESPONSE[response]))
    columns["stability"] = of_cycle("stability", (), np.int8(STABILITY["absent"]))
    columns["contact_count"] = of_cycle("contact_count", (), 0)
    columns["whirl_sense"] = of_cycle("whirl_sense", (), np.int8(WHIRL_DIRECTION["none"]))
    none = np.empty(0)
    columns |= {name: of_cycle(name, "line", none) for name in ("frequency", "whirl_amplitude")}
    columns["line"] = of_cycle("line", "line", np.empty(0, dtype=np.int64))
    columns["line_kind"] = of_cycle("line_kind", "line", np.empty(0, dtype=np.int8))
    columns["t"] = of_cycle("t", "t", none)
    return columns | state_columns(np.empty((0, 4)), "t")


# ---- Branches, and curves of bifurcations ----


def start_attributes(guess: Guess) -> dict[str, object]:
    """Return, as attributes, the start from which a curve of cycles was followed."""
    return {
        "start": guess.state,
        "start_period": guess.period or math.nan,
        **{f"start_{name}": value for name, value in guess.rotor.given.items()},
    }


def branch_dataset(
    sides: tuple[Side[Shot], Side[Shot]],
    parameters: tuple[str, ...],
    rotor: Rotor,
    title: str,
    *,
    kind: str,
) -> xr.Dataset:
    """Return both sides, forward and backward, of a curve of cycles, from end to end.

    `parameters` vary, in the order of the unknowns; the others are those of `rotor`.
    """
    forward, backward = sides
    before = len(backward.points) - 1
    points = [point.reversed() for point in backward.points[:0:-1]] + forward.points
    specials = [SpecialBehind(before - place - 1, each) for place, each in backward.specials[::-1]]
    specials += [SpecialBehind(before + place, each) for place, each in forward.specials]
    variables = cycle_columns([checked_cycle(point.stretch) for point in points], "point")
    slopes = np.array([point.tangent[PLACE] for point in points])
    variables["slope"] = of_cycle("slope", "point", slopes)
    variables |= _special_columns(specials, parameters)
    coordinates = {
        name: labelled(name, (), value)
        for name, value in rotor.given.items()
        if name not in parameters
    }
    for place, name in enumerate(parameters, start=PLACE):
        values = np.array([point.unknowns[place] for point in points])
        coordinates[name] = labelled(name, "point", values)
    coordinates["multiplier"] = labelled("multiplier", "multiplier", np.arange(4))
    closed = forward.end == CLOSED
    ends = {
        "closed": int(closed),
        "first_end": CLOSED if closed else backward.end or "start",
        "last_end": forward.end or "start",
        "first_reason": backward.reason,
        "last_reason": forward.reason,
    }
    return labelled_dataset(title, variables, coordinates, ends, kind=kind)


def _special_columns(
    specials: Sequence[SpecialBehind[Shot]], parameters: tuple[str, ...]
) -> dict[str, xr.Variable]:
    """Return the special points, in order along the curve."""
    cycles = [checked_cycle(each.point.stretch) for _, each in specials]
    unknowns = np.array([each.point.unknowns for _, each in specials])
    unknowns = unknowns.reshape(-1, PLACE + len(parameters))
    columns: dict[str, npt.ArrayLike] = {
        "special_kind": np.array([SPECIAL[each.name] for _, each in specials], dtype=np.int8),
        "special_value": unknowns[:, PLACE],
        "special_period": unknowns[:, PLACE - 1],
        "special_radius_min": np.array([cycle.radius_min for cycle in cycles], dtype=np.float64),
        "special_radius_max": np.array([cycle.radius_max for cycle in cycles], dtype=np.float64),
        "special_point": np.array([place for place, _ in specials], dtype=np.int64),
    }
    if len(parameters) > 1:
        columns["special_second_value"] = unknowns[:, PLACE + 1]
    variables = {name: labelled(name, "special", column) for name, column in columns.items()}
    return variables | state_columns(unknowns[:, :4], "special", "special_")
