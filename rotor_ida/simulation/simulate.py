"""Simulate one rotor from one start."""

from __future__ import annotations

import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import (
    AT_REST,
    check_duration,
    check_instance,
    check_state,
)
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Stop, interruptible
from rotor_ida.simulation.dataset import run_dataset
from rotor_ida.simulation.event_errors import EventErrors, estimate_event_errors
from rotor_ida.simulation.options import Backend, Flight, Method, Options, check_can_be_followed
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.sampling import sample_times

# An event so many tolerances behind the end of a run may as well lie at it, and belongs to it.
END_SLACK = 100.0
MOST_SLACK = 1e-8
# Samples and radians, of spin, decay and contact, that Taylor series pass in some 20 ms.
SOON_PASSED = 1e4


def simulate(
    rotor: Rotor,
    *,
    start: npt.ArrayLike = AT_REST,
    duration: float,
    samples: int | npt.ArrayLike | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    flight: Flight = "exact",
    backend: Backend = "auto",
) -> xr.Dataset:
    """Simulate a rotor, with every contact entry and exit found by root finding.

    Parameters
    ----------
    rotor : Rotor
        The rotor.
    start : array_like, shape (4,)
        ``(x, y, vx, vy)`` at time 0 [1]; by default at rest on the axis.
    duration : float
        Time to simulate [1], as long as the spacing of doubles at its end is below
        ``1e-6/max(omega, 1)``.
    samples : int or array_like, shape (n,), optional
        Number of equally spaced times at which the motion is reported, both ends included, at
        most 10 million, or the times themselves, increasing [1]. By default at least 1001, with at
        least 32 in each revolution and each period of the shaft, ``2 pi/sqrt(kappa)``, and 8 in a
        period of the contact, ``2 pi/sqrt(1 + kappa)``; where these are more than 2 million,
        `samples` must be given.
    rtol, atol : float
        Relative and absolute tolerance [1].
    method : {"adams", "bdf", "ida", "taylor"}
        CVODE with Adams (nonstiff) or BDF (stiff), or IDA as a second opinion, with `rtol` from
        1e-13 (IDA 1e-12) to 1e-3; or Taylor series, about ten times as fast as CVODE at equal
        error, with `rtol` from 1e-15 to 1e-4. ``docs/events.md`` says how each finds events.
    flight : {"exact", "cvode"}
        Whether motion inside the clearance is solved in closed form or integrated; with Taylor
        series it is solved, with ``backend="python"`` it is integrated.
    backend : {"auto", "python", "compiled"}
        The plain-Python reference, which restarts the solvers of scikit-sundae at each root of
        ``|z| = delta0``, or the compiled core, many times as fast. ``"auto"`` is ``"compiled"``
        wherever it can be had; IDA is the reference's alone.

    Returns
    -------
    Dataset
        ``x y vx vy`` on ``t``; ``event_time event_kind event_time_error event_x event_y
        event_vx event_vy`` on ``event``; on ``contact`` ``entry_time exit_time peak_time
        peak_indentation peak_force contact_duration impulse entry_speed entry_angle
        energy_lost whirl_direction``, with friction ``heat slip_distance rolling_time`` too, NaN
        where the run began or ended inside the contact, or samples are too far apart; the
        scalars ``starts_in_contact`` and ``horizon``; ``omega zeta delta0`` as coordinates.
        With friction ``mode``, ``slip_speed`` and ``normal_force`` on ``t``, ``heat`` on
        ``contact``, and three more kinds of event: ``roll``, ``slip`` and ``reverse``.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the solver gave up, with time and state.
    InvariantError
        If the result contradicts the mechanics, with the place.

    Notes
    -----
    ``z'' + 2 zeta z' + max(|z| - delta0, 0)**1.5 z/|z| = omega**2 exp(i omega t)``. An event
    within ``min(100 rtol, 1e-8) duration`` behind the end belongs to the run. A start
    exactly on the ring is in contact if it moves outwards, or is about to. Grazes
    below an indentation of about 1e-13 of the lengths involved may be missed or invented.
    ``event_time_error`` comes from a second run, with looser tolerances or, by Taylor series, with
    tighter ones, and includes the spacing of doubles. It is infinite beyond ``horizon``: from there
    on the start no longer determines the orbit at these tolerances.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> orbit = simulate(Rotor(omega=1.2, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0),
    ...                  duration=20.0, samples=3)
    >>> orbit.event_time.values.round(9)
    array([0.86301317])
    >>> orbit.event_kind.values
    array([1], dtype=int8)
    """
    check_instance("rotor", rotor, Rotor)
    first = check_state("start", start)
    check_can_be_followed(rotor, first)
    end = check_duration("duration", duration, rotor.omega)
    times = sample_times(samples, end, rotor, rotor.omega)
    options = Options(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)
    slack = min(END_SLACK * options.rtol, MOST_SLACK) * end

    def run_twice(stop: Stop | None = None) -> tuple[Orbit, EventErrors]:
        orbit = run(rotor, first, end, times, options, slack=slack, stop=stop)
        return orbit, estimate_event_errors(orbit, first, slack=slack, stop=stop)

    # a thread costs 0.2 ms, half as much as a short run: Ctrl-C may wait for the end of such a one
    rate = 1.0 + rotor.omega + rotor.zeta + max(map(abs, first))
    soon = options.method == "taylor" and rate * end + times.size <= SOON_PASSED
    orbit, errors = run_twice() if soon else interruptible(run_twice)
    return run_dataset(orbit, first, errors)
