"""Run a rotor up or down: along a ramp of its speed, piece by piece, or as a torque drives it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Unpack

import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import check_progress
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.simulation.course import DISC_LIMITS, SYSTEM_LIMITS, check_can_wait, course_of
from rotor_ida.simulation.options import (
    Backend,
    Method,
    Options,
    check_can_be_followed,
    with_fallback,
)
from rotor_ida.simulation.runs import run_of_disc, run_of_system
from rotor_ida.simulation.simulate import DEFAULTS, OF_DISC, OF_SYSTEM
from rotor_ida.simulation.starts import Start, start_of


@shows_progress
@takes_rotors(disc=OF_DISC, system=OF_SYSTEM, needed=(), defaults=DEFAULTS)
def run_up(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    speed: float | None = None,
    start: Start = None,
    to: float | None = None,
    rate: float | None = None,
    ramp_time: float | None = None,
    speeds: Sequence[tuple[float, float]] | npt.ArrayLike | None = None,
    torque: tuple[float, float] | npt.ArrayLike | None = None,
    inertia: float | None = None,
    duration: float | None = None,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    backend: Backend = "auto",
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Simulate a rotor whose speed changes, and locate every event by root finding.

    Specify the change of speed in one of three ways: a ramp `to` another speed, at a constant
    `rate` or within a `ramp_time`; `speeds` at given times, linear in between; or a `torque` that
    accelerates the `inertia` of the rotor against damping, shaft and stator.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. The ``omega`` or ``speed`` of one disc is that at time 0, when the unbalance
        points along x. For a `DimensionalRotor` numbers with a unit are in SI units, as for
        `simulate`: speeds in rad/s, the torque in N m and N m s, the inertia in kg m^2.
    speed : float
        Speed of a `RotorSystem` at time 0, required with a ramp or a torque.
    to : float
        Speed at the end of a ramp [dimensionless]. Without it the ramp of a `RotorSystem` lasts for
        all of the `duration`.
    rate : float
        Change of speed per unit time [dimensionless], negative in a run-down.
    ramp_time : float
        Duration of the ramp [dimensionless], instead of the rate.
    speeds : sequence of (float, float)
        Pairs of time and speed [dimensionless], with times that increase from 0. The first speed
        replaces that of the rotor. Speeds of one disc must not be negative.
    torque : tuple of float
        ``(tau0, slope)``: the drive's torque is ``tau0 - slope speed`` [dimensionless].
    inertia : float
        Moment of inertia about the centre of mass, over mass times eccentricity squared
        [dimensionless]; of a `RotorSystem` about the centres of mass.
    duration : float, optional
        Time to simulate [dimensionless]; required with a torque. Default: the time that the change
        of speed takes. After that the last speed is kept.
    samples : int or array_like, shape (n,), optional
        Increasing times at which the motion is reported [dimensionless], or the number of equally
        spaced times, both ends included. Default: as many as `simulate` takes at the largest speed
        of the run; with a torque a first run of one disc finds that speed.
    start, modes, more_modes, rtol, atol, progress : optional
        As in `simulate`.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        Solver of the contacts, as in `simulate`: CVODE with Adams or BDF, IDA, or Taylor series.
        Flight has no closed form at a changing speed: the compiled core integrates it by Taylor
        series, the reference by the method itself.
    backend : {"auto", "python", "compiled"}
        As in `simulate`.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`, as in `simulate`.

    Returns
    -------
    Dataset
        As from `simulate`, with ``speed`` and ``angle`` on ``t``, ``event_speed`` and
        ``event_angle`` on ``event``, and for one disc ``revolutions``, their number in the run.
        ``omega`` is the speed at time 0. Attributes record how the speed changed: ``to`` and
        ``rate``, ``speeds`` (alternating time and speed), or ``torque`` and ``inertia``; of a
        `RotorSystem` also ``start_speed``, with a ramp or a torque.

        Of a `RotorSystem` with a torque also ``standstill_time`` and ``standstill_time_error``:
        since when the speed has stayed below one per cent of the first, NaN if it does not, as of a
        rotor that rocks.

    Raises
    ------
    InputError
        If an argument cannot be used, or the speed of one disc would pass through zero.
    SimulationError
        If the solver gives up, or the torque lets the speed of one disc fall through zero; reports
        time and state.
    InvariantError
        If the result contradicts the mechanics; reports time and state.

    Warns
    -----
    UserWarning
        As in `simulate`, at the largest speed.

    Notes
    -----
    With the angle theta of the unbalance,
    ``z'' + 2 zeta z' + kappa z + (N + i T) z/|z| = (theta'**2 - i theta'') exp(i theta)
    - i gamma``. The rim moves at ``rho theta'``. With a torque
    ``j theta'' = tau0 - slope theta' - T (rho - cos(theta - phi))
    + Im(exp(-i theta) (2 zeta z' + kappa z + N z/|z|))``. The reaction acts about the centre of
    mass; the load acts there and does not contribute. See ``docs/run_up.md``.
    ``event_time_error`` comes from a second run, as in `simulate`.

    For a `RotorSystem` with a torque ``J Omega' = tau0 - slope Omega - sum R_j T_j - (reaction of
    the unbalance) + sum m e x g``: the weight of each unbalance has a moment about the axis. The
    unbalances u, at the rows b and the angles a, add ``sum u_i u_j cos(a_i - a_j) b_i M**-1 b_j'``
    to J, as the mean along x and y; that of one disc adds ``u**2/m``. A
    `static_force` has none, but for the weight that `RotorSystem.gravity_in_static_force`
    describes.

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

    A rotor system:

    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> run = run_up(system, speed=0.2, to=1.5, rate=0.02, samples=3)
    >>> run.speed.values.round(3)
    array([0.2 , 0.85, 1.5 ])
    """
    given = {"to": to, "rate": rate, "ramp_time": ramp_time, "speeds": speeds, "torque": torque,
             "inertia": inertia}  # fmt: skip
    assert method is not None
    method, backend = with_fallback(method, backend)
    if isinstance(rotor, RotorSystem):
        return run_of_system(
            changed_system(run_up, rotor, changed),
            course_of(speed, given, duration, SYSTEM_LIMITS), start=start, samples=samples,
            modes=modes, more_modes=more_modes, rtol=rtol, method=method, progress=progress,
            backend=backend,
        )  # fmt: skip
    assert isinstance(rotor, Rotor)
    progress = check_progress(progress)
    options = Options(rtol=rtol, atol=atol, method=method, backend=backend)
    course = course_of(rotor.omega, given, duration, DISC_LIMITS)
    check_can_wait(course, rotor, options.backend)
    if course.speed != rotor.omega:
        rotor = replace(rotor, omega=course.speed)
    first = start_of(rotor, start)
    check_can_be_followed(rotor, first)
    return run_of_disc(rotor, first, course, samples, options, progress)
