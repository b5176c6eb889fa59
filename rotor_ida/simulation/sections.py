"""Sections through a motion: its states once a revolution, or at each contact event."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values, Watch
from rotor_ida.checks import (
    AT_REST,
    State,
    check_choice,
    check_count,
    check_duration,
    check_instance,
    check_nonnegative,
    check_progress,
)
from rotor_ida.errors import InputError
from rotor_ida.model.equations import rotated
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Stop, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_si
from rotor_ida.results.provenance import provenance
from rotor_ida.results.run import parameter_coordinates
from rotor_ida.schema import Column, labelled_dataset
from rotor_ida.simulation.extrema import MAXIMUM, check_knots, radius_extrema
from rotor_ida.simulation.options import Method, Options, check_can_be_followed
from rotor_ida.simulation.orbit import ENTRY, EXIT, REVERSE, ROLL, SLIP
from rotor_ida.simulation.run import run
from rotor_ida.simulation.starts import Start, state_of

At = Literal["revolution", "entry", "exit", "peak", "roll", "slip", "reverse"]

# Events of a run by name; the last ones need friction.
RUBS = {"roll": ROLL, "slip": SLIP, "reverse": REVERSE}
EVENTS = {"entry": ENTRY, "exit": EXIT, **RUBS}
PLACES = ("revolution", "entry", "exit", "peak", *RUBS)
NAMES = ("rotating_x", "rotating_y", "rotating_vx", "rotating_vy")


@takes_si
@shows_progress
def poincare_section(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    revolutions: int,
    skip: int = 0,
    at: At = "revolution",
    phase: float = 0.0,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Return the states at which a motion crosses a section, in the rotating frame.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor, with a speed above 0. For a `DimensionalRotor` numbers with a unit are in SI
        units, as for `simulate`.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1]; default: at rest on the axis. Or a word, or a result that
        ends in a state, as for `rotor_ida.simulate`.
    revolutions : int
        Number of revolutions in the section, at most 10 million.
    skip : int
        Number of earlier revolutions to skip as a transient, at most 10 million.
    at : {"revolution", "entry", "exit", "peak", "roll", "slip", "reverse"}
        Once a revolution, when the unbalance points along x; at each contact entry or exit; at
        each local maximum of the distance from the bearing axis; or, with friction, where the disc
        begins to roll or to slip, or reverses its sliding.
    phase : float
        Angle of the unbalance from x at the section by revolutions, below 2 pi [rad]. Under a load
        the section depends on it.
    rtol, atol : float
        Relative and absolute tolerance [1].
    method : {"adams", "bdf", "ida", "taylor"}
        Solver of the contacts, as for `rotor_ida.simulate`. Peaks are found by Taylor series.
    progress : callable or bool, optional
        As for `rotor_ida.simulate`.

    Returns
    -------
    Dataset
        ``crossing_time``, counted from the start, and ``rotating_x rotating_y rotating_vx
        rotating_vy`` on ``crossing`` [1].

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the solver gives up.

    Notes
    -----
    In the rotating frame the motion is autonomous. A synchronous whirl is one point of the
    section by revolutions. A response of period n revolutions is n points, a quasi-periodic one
    a closed curve. Events and peaks lie on a surface of the phase space: there a motion that is
    periodic in the rotating frame is a few points, whatever its period.
    A load rotates in this frame. Under a load only the section by revolutions is a map, the
    stroboscopic one, whose fixed points and cycles are the periodic motions; sections at events
    and peaks ignore the angle of the load. While the disc rolls on the stator the section has at
    most three dimensions, since the tangential velocity is that of the rim.
    Revolutions are sampled at exactly ``(phase + 2 pi n)/omega``. Entries, exits and the like are
    the events of the simulation. Peaks are roots of ``x vx + y vy``, polished to about 1e-12 of the
    state. A constant radius has no peaks.

    References
    ----------
    F. C. Moon, "Chaotic and Fractal Dynamics", Wiley, 1992, chapter 2.

    Examples
    --------
    >>> section = poincare_section(Rotor(omega=2.0, zeta=0.07, delta0=0.0), start=(0, 0, 0, 0),
    ...                            revolutions=3, skip=150)
    >>> section.rotating_x.values.round(6)
    array([-1.40959, -1.40959, -1.40959, -1.40959])
    """
    check_instance("rotor", rotor, Rotor)
    progress = check_progress(progress)
    first = state_of("start", start, rotor)
    check_can_be_followed(rotor, first)
    if rotor.omega == 0.0:
        raise InputError(
            "{name} must be positive for a section, got {value}", name="omega", value=0.0
        )
    count = check_count("revolutions", revolutions)
    left_out = check_count("skip", skip, minimum=0)
    check_choice("at", at, PLACES)
    if check_nonnegative("phase", phase) >= 2.0 * math.pi:
        raise InputError(f"phase must be below 2 pi, got {phase!r}")
    if at != "revolution" and phase:
        raise InputError(f"phase must be 0 for a section at each {at}, got {phase!r}")
    if at in RUBS and rotor.friction == 0.0:
        raise InputError(f"friction must be positive for a section at each {at}, got 0.0")
    if at in EVENTS and rotor.delta0 == 0.0:
        raise InputError(
            "{name} must be positive for a section at each {at}, got {value}",
            name="delta0", at=at, value=0.0,
        )  # fmt: skip
    options = Options(rtol=rtol, atol=atol, method=method)
    period = 2.0 * math.pi / rotor.omega
    check_duration("the time of skip and revolutions", (left_out + count) * period, rotor.omega)
    if at == "peak":
        check_knots("the time of revolutions", rotor, count * period)

    watch: Watch = []

    def follow(stop: Stop) -> tuple[Values, Values]:
        state = first
        if left_out:
            lead = left_out * period
            end = run(rotor, first, lead, np.empty(0), options, stop=stop, watch=watch).end
            x, y, vx, vy = rotated(end, -rotor.omega * left_out * period).tolist()
            state = (x, y, vx, vy)
        return _crossings(rotor, state, count, at, float(phase), options, stop, watch)

    told = percentage(progress, watch, (left_out + count) * period)
    times, states = interruptible(follow, told=told)
    if progress is not None:
        progress(100, 100)
    columns: dict[str, Column] = {"crossing_time": ("crossing", left_out * period + times)}
    columns |= {
        name: ("crossing", np.ascontiguousarray(column))
        for name, column in zip(NAMES, states.T, strict=True)
    }
    coordinates = parameter_coordinates(rotor) | {"crossing": ("crossing", np.arange(times.size))}
    attributes = provenance(options.attributes()) | {
        "section": at, "start": np.array(first), "revolutions": count, "skip": left_out,
    }  # fmt: skip
    if at == "revolution":
        attributes["phase"] = float(phase)
    return labelled_dataset(
        "Section through one motion", columns, coordinates, attributes, kind="section"
    )


def _crossings(
    rotor: Rotor,
    start: State,
    count: int,
    at: str,
    phase: float,
    options: Options,
    stop: Stop,
    watch: Watch,
) -> tuple[Values, Values]:
    """Return the times of the crossings after `start`, and the states in the rotating frame."""
    period = 2.0 * math.pi / rotor.omega
    duration = count * period
    if at == "peak":
        extrema = radius_extrema(rotor, start, duration, options.step_rtol, stop, watch)
        chosen = extrema.kinds == MAXIMUM
        return extrema.times[chosen], extrema.states[chosen]
    if at == "revolution":
        passed = count if phase else count + 1
        times = np.minimum(period * np.arange(passed) + phase / rotor.omega, duration)
        orbit = run(rotor, start, duration, times, options, stop=stop, watch=watch)
        # turning by whole revolutions would only add rounding
        return times, rotated(orbit.states, np.float64(-phase)) if phase else orbit.states
    orbit = run(rotor, start, duration, np.empty(0), options, stop=stop, watch=watch)
    chosen = orbit.event_kinds == EVENTS[at]
    times = orbit.event_times[chosen]
    return times, rotated(orbit.event_states[chosen], -rotor.omega * times)
