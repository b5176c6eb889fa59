"""Simulate one rotor from one initial state."""

from __future__ import annotations

import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Watch
from rotor_ida.checks import AT_REST, check_duration, check_instance, check_progress
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Stop, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_si
from rotor_ida.simulation.dataset import run_dataset
from rotor_ida.simulation.event_errors import EventErrors, estimate_event_errors
from rotor_ida.simulation.options import Backend, Flight, Method, Options, check_can_be_followed
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.sampling import sample_times
from rotor_ida.simulation.starts import Start, state_of

# An event this many tolerances after the end of a run counts as part of the run.
END_SLACK = 100.0
MOST_SLACK = 1e-8
# Samples plus radians of spin, decay and contact that Taylor series cover in about 20 ms.
SOON_PASSED = 1e4


@takes_si
@shows_progress
def simulate(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    duration: float,
    samples: int | npt.ArrayLike | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    flight: Flight = "exact",
    backend: Backend = "auto",
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Simulate a rotor and locate every contact entry and exit by root finding.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. For a `DimensionalRotor` all numbers with a unit, given or returned, are in SI
        units, also in attributes and messages. Tolerances, and coordinates named ``omega``,
        ``zeta`` and so on, stay dimensionless.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1]; default: at rest on the axis, from which a load drops it.
        ``"rest"`` is where a load holds the rotor, ``"settled"`` the steady whirl without contact,
        around the place where the shaft holds the load. A result that ends in a state
        is continued, with the unbalance along x again: a run, a limit cycle, or one point of a
        sweep or of many run-ups.
    duration : float
        Time to simulate [1]. The spacing of doubles at its end must be below
        ``1e-6/max(omega, 1)``.
    samples : int or array_like, shape (n,), optional
        Increasing times at which the motion is reported [1], or the number of equally spaced times,
        both ends included, at most 10 million. Default: at least 1001, with at least 32 per
        revolution and per period of the shaft, ``2 pi/sqrt(kappa)``, and 8 per period of the
        contact, ``2 pi/sqrt(1 + kappa)``. `samples` is required where these exceed 2 million.
    rtol, atol : float
        Relative and absolute tolerance [1].
    method : {"adams", "bdf", "ida", "taylor"}
        CVODE with Adams (nonstiff) or BDF (stiff), or IDA as an independent check, with `rtol` from
        1e-13 (IDA 1e-12) to 1e-3; or Taylor series, about ten times as fast as CVODE at equal
        error, with `rtol` from 1e-15 to 1e-4. ``docs/events.md`` explains how each finds events.
    flight : {"exact", "cvode"}
        Motion inside the clearance in closed form, or integrated. Taylor series always use the
        closed form; ``backend="python"`` always integrates.
    backend : {"auto", "python", "compiled"}
        The plain-Python reference, which restarts the solvers of scikit-sundae at each root of
        ``|z| = delta0``, or the compiled core, which is many times faster. ``"auto"`` is
        ``"compiled"`` where available. Only the reference supports IDA.
    progress : callable or bool, optional
        Called from time to time with the percentage completed, and 100; True shows a bar on
        standard error.

    Returns
    -------
    Dataset
        ``x y vx vy`` on ``t``; ``event_time event_kind event_time_error event_x event_y
        event_vx event_vy`` on ``event``; on ``contact`` ``entry_time exit_time peak_time
        peak_indentation peak_force contact_duration impulse entry_speed entry_angle
        energy_lost whirl_direction``, and with friction ``heat slip_distance rolling_time``. Where
        the run began or ended inside the contact, what belongs to that end is NaN, and impulse,
        heat and slip distance are those during the run. Scalars ``starts_in_contact`` and
        ``horizon``; coordinates ``omega zeta delta0``.
        With friction also ``mode``, ``slip_speed`` and ``normal_force`` on ``t``, and three more
        kinds of event: ``roll``, ``slip`` and ``reverse``.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the solver gives up; reports time and state.
    InvariantError
        If the result contradicts the mechanics; reports time and state.

    Notes
    -----
    ``z'' + 2 zeta z' + max(|z| - delta0, 0)**1.5 z/|z| = omega**2 exp(i omega t)``. An event
    within ``min(100 rtol, 1e-8) duration`` after the end belongs to the run. A start
    exactly on the stator is in contact if it moves outwards, or is about to. Grazes
    below an indentation of about 1e-13 of the lengths involved may be missed or invented.
    ``event_time_error`` comes from a second run by Taylor series with tighter tolerances (of very
    long runs by CVODE with looser ones), and includes the spacing of doubles. It is infinite after
    ``horizon``, where the start no longer determines the orbit at these tolerances.

    References
    ----------
    Eq. (10) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> orbit = simulate(Rotor(omega=1.2, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0),
    ...                  duration=20.0, samples=3)
    >>> orbit.event_time.values.round(9)
    array([0.86301317])
    >>> orbit.event_kind.values
    array([1], dtype=int8)
    """
    check_instance("rotor", rotor, Rotor)
    progress = check_progress(progress)
    first = state_of("start", start, rotor)
    check_can_be_followed(rotor, first)
    end = check_duration("duration", duration, rotor.omega)
    times = sample_times(samples, end, rotor, rotor.omega)
    options = Options(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)
    slack = min(END_SLACK * options.rtol, MOST_SLACK) * end

    watch: Watch = []

    def run_twice(stop: Stop | None = None) -> tuple[Orbit, EventErrors]:
        orbit = run(rotor, first, end, times, options, slack=slack, stop=stop, watch=watch)
        return orbit, estimate_event_errors(orbit, first, slack=slack, stop=stop, watch=watch)

    # a thread costs 0.2 ms, half as much as a short run: Ctrl-C may wait until a short run ends
    rate = 1.0 + rotor.omega + rotor.zeta + max(map(abs, first))
    if options.method == "taylor" and rate * end + times.size <= SOON_PASSED:
        orbit, errors = run_twice()
    else:
        orbit, errors = interruptible(run_twice, told=percentage(progress, watch, 2.0 * end))
    if progress is not None:
        progress(100, 100)
    return run_dataset(orbit, first, errors)
