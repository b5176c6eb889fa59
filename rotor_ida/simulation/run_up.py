"""Run a rotor up or down: along a ramp of its speed, piece by piece, or as a torque drives it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Watch
from rotor_ida.checks import (
    AT_REST,
    check_instance,
    check_progress,
)
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress, Stop, interruptible, percentage, shows_progress
from rotor_ida.results.in_si import takes_si
from rotor_ida.simulation.course import DISC_LIMITS, check_can_wait, course_of
from rotor_ida.simulation.dataset import run_dataset
from rotor_ida.simulation.event_errors import EventErrors, estimate_event_errors
from rotor_ida.simulation.options import (
    Backend,
    Method,
    Options,
    check_can_be_followed,
)
from rotor_ida.simulation.orbit import Orbit
from rotor_ida.simulation.run import run
from rotor_ida.simulation.sampling import FEWEST, sample_times
from rotor_ida.simulation.simulate import END_SLACK, MOST_SLACK
from rotor_ida.simulation.starts import Start, state_of


@takes_si
@shows_progress
def run_up(
    rotor: Rotor,
    *,
    start: Start = AT_REST,
    to: float | None = None,
    rate: float | None = None,
    ramp_time: float | None = None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None = None,
    torque: tuple[float, float] | npt.ArrayLike | None = None,
    inertia: float | None = None,
    duration: float | None = None,
    samples: int | npt.ArrayLike | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method = "adams",
    backend: Backend = "auto",
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Simulate a rotor whose speed changes, and locate every event by root finding.

    Specify the change of speed in one of three ways: a ramp `to` another speed, at a constant
    `rate` or within a `ramp_time`; `speeds` at given times, linear in between; or a `torque` that
    accelerates the `inertia` of the rotor against damping, shaft and stator.

    Parameters
    ----------
    rotor : Rotor or DimensionalRotor
        The rotor. Its ``omega`` or ``speed`` is that at time 0, when the unbalance points along x.
        For a `DimensionalRotor` numbers with a unit are in SI units, as for `simulate`: speeds in
        rad/s, the torque in N m and N m s, the inertia in kg m^2.
    start : array_like, shape (4,), "settled", "rest" or Dataset
        ``(x, y, vx, vy)`` at time 0 [1]; default: at rest on the axis, from which a load drops it.
        ``"rest"`` is where a load holds the rotor, ``"settled"`` the steady whirl without contact,
        around the place where the shaft holds the load. A result that ends in a state
        is continued, with the unbalance along x again: a run, a limit cycle, or one point of a
        sweep or of many run-ups.
    to : float
        Speed at the end of a ramp [1].
    rate : float
        Change of speed per unit time [1], negative in a run-down.
    ramp_time : float
        Duration of the ramp [1], instead of the rate.
    speeds : sequence of (float, float)
        Pairs of time and speed [1], with times that increase from 0. The first speed replaces the
        rotor's ``omega``.
    torque : tuple of float
        ``(tau0, slope)``: the drive's torque is ``tau0 - slope speed`` [1].
    inertia : float
        Moment of inertia about the centre of mass, over mass times eccentricity squared [1].
    duration : float, optional
        Time to simulate [1]; required with a torque. Default: the time that the change of speed
        takes. After that the last speed is kept.
    samples : int or array_like, shape (n,), optional
        Increasing times at which the motion is reported [1], or the number of equally spaced times,
        both ends included. Default: as many as `simulate` takes at the largest speed of the run;
        with a torque a first run finds that speed.
    rtol, atol : float
        Relative and absolute tolerance [1], as in `simulate`.
    method : {"adams", "bdf", "ida", "taylor"}
        Solver of the contacts, as in `simulate`: CVODE with Adams or BDF, IDA, or Taylor series.
        Flight has no closed form at a changing speed: the compiled core integrates it by Taylor
        series, the reference by the method itself.
    backend : {"auto", "python", "compiled"}
        As in `simulate`.
    progress : callable or bool, optional
        As for `simulate`.

    Returns
    -------
    Dataset
        As from `simulate`, with ``speed`` and ``angle`` on ``t``, ``event_speed`` and
        ``event_angle`` on ``event``, and ``revolutions``, their number in the run. ``omega`` is the
        speed at time 0. Attributes record how the speed changed: ``to`` and ``rate``, ``speeds``
        (alternating time and speed), or ``torque`` and ``inertia``.

    Raises
    ------
    InputError
        If an argument cannot be used, or the speed would pass through zero.
    SimulationError
        If the solver gives up, or the torque lets the speed fall through zero; reports time and
        state.
    InvariantError
        If the result contradicts the mechanics; reports time and state.

    Notes
    -----
    With the angle theta of the unbalance,
    ``z'' + 2 zeta z' + kappa z + (N + i T) z/|z| = (theta'**2 - i theta'') exp(i theta)
    - i gamma``. The rim moves at ``rho theta'``. With a torque
    ``j theta'' = tau0 - slope theta' - T (rho - cos(theta - phi))
    + Im(exp(-i theta) (2 zeta z' + kappa z + N z/|z|))``. The reaction acts about the centre of
    mass; the load acts there and does not contribute. See ``docs/run_up.md``.
    ``event_time_error`` comes from a second run, as in `simulate`.

    References
    ----------
    A. Sommerfeld, "Beiträge zum dynamischen Ausbau der Festigkeitslehre", Zeitschrift des Vereines
    deutscher Ingenieure 46, 1902; F. M. Lewis, "Vibration during acceleration through a critical
    speed", Transactions of the ASME 54, 1932.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> rotor = Rotor(omega=0.2, zeta=0.07, delta0=0.8)
    >>> run = run_up(rotor, start=(0, 0, 0, 0), to=2.0, rate=0.05, samples=5)
    >>> run.t.values, run.speed.values.round(12)
    (array([ 0.,  9., 18., 27., 36.]), array([0.2 , 0.65, 1.1 , 1.55, 2.  ]))
    >>> run.event_kind.values, run.event_speed.values.round(6)
    (array([1], dtype=int8), array([0.440496]))
    >>> run = run_up(rotor, start=(0, 0, 0, 0), torque=(1, 0), inertia=20, duration=40, samples=5)
    >>> run.speed.values.round(6)
    array([0.2     , 0.622213, 0.626802, 0.790485, 0.867413])
    """
    check_instance("rotor", rotor, Rotor)
    progress = check_progress(progress)
    options = Options(rtol=rtol, atol=atol, method=method, backend=backend)
    given = {"to": to, "rate": rate, "ramp_time": ramp_time, "speeds": speeds, "torque": torque,
             "inertia": inertia}  # fmt: skip
    course = course_of(rotor.omega, given, duration, DISC_LIMITS)
    check_can_wait(course, rotor, options.backend)
    if course.speed != rotor.omega:
        rotor = replace(rotor, omega=course.speed)
    first = state_of("start", start, rotor)
    check_can_be_followed(rotor, first)
    end = course.end
    slack = min(END_SLACK * options.rtol, MOST_SLACK) * end

    watch: Watch = []

    def sampled(samples: object, fastest: float, stop: Stop | None) -> Orbit:
        return run(
            rotor, first, end, sample_times(samples, end, rotor, fastest), options,
            slack=slack, stop=stop, profile=course.profile, watch=watch,
        )  # fmt: skip

    def run_twice(stop: Stop | None = None) -> tuple[Orbit, EventErrors]:
        fastest = course.largest_speed
        if samples is None and course.profile.is_driven:  # the largest speed is not known before
            fastest = max(fastest, float(np.max(sampled(FEWEST, fastest, stop).speeds)))
            watch.clear()
        orbit = sampled(samples, fastest, stop)
        return orbit, estimate_event_errors(orbit, first, slack=slack, stop=stop, watch=watch)

    orbit, errors = interruptible(run_twice, told=percentage(progress, watch, 2.0 * end))
    if progress is not None:
        progress(100, 100)
    return run_dataset(orbit, first, errors, course.told)
