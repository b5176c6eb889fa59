"""Simulate a rotor from one initial state."""

from __future__ import annotations

from typing import Unpack

import numpy.typing as npt
import xarray as xr

from rotor_ida.checks import (
    check_duration,
    check_positive,
    check_progress,
    check_real,
)
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import takes_rotors
from rotor_ida.simulation.course import check_length, held
from rotor_ida.simulation.options import (
    Backend,
    Flight,
    Method,
    Options,
    adams_or_taylor,
    check_can_be_followed,
    with_fallback,
)
from rotor_ida.simulation.runs import run_of_disc, run_of_system
from rotor_ida.simulation.starts import Start, start_of

# Arguments that only one disc, or only a rotor system, takes, and defaults that differ.
OF_DISC, OF_SYSTEM = ("atol",), ("modes", "more_modes")
DEFAULTS = {"method": (adams_or_taylor, "taylor")}


@shows_progress
@takes_rotors(disc=(*OF_DISC, "flight"), system=OF_SYSTEM, defaults=DEFAULTS)
def simulate(
    rotor: Rotor | DimensionalRotor | RotorSystem,
    *,
    speed: float | None = None,
    start: Start = None,
    duration: float,
    samples: int | npt.ArrayLike | None = None,
    modes: int | None = None,
    more_modes: int | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
    method: Method | None = None,
    flight: Flight = "exact",
    backend: Backend = "auto",
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Simulate a rotor and locate every event of its contacts by root finding.

    Parameters
    ----------
    rotor : Rotor, DimensionalRotor or RotorSystem
        The rotor. For a `DimensionalRotor` all numbers with a unit, given or returned, are in SI
        units, also in attributes and messages. Tolerances, and coordinates named ``omega``,
        ``zeta`` and so on, stay dimensionless. A `RotorSystem` has its own units.
    speed : float
        Spin speed of a `RotorSystem`, required; one disc has its own.
    start : array_like, shape (4,), (q, velocity), "settled", "rest" or Dataset, optional
        ``(x, y, vx, vy)`` at time 0 [dimensionless], of a `RotorSystem` displacement and velocity
        of the rotor, or of rotor and stators. ``"rest"`` is where supports, contacts and shaft hold
        the rotor against its constant forces, ``"settled"`` the steady whirl without contact.
        Default: under a load ``"rest"``, hanging on the shaft or lying on the stator; without one,
        and in a `RotorSystem` that neither shaft nor supports hold, at rest on the axis. A result
        that ends in a state is continued, with the unbalance at angle 0 again: a run, a limit
        cycle, or one point of a sweep or of many run-ups.
    duration : float
        Time to simulate [dimensionless]. For one disc the spacing of doubles at its end must be
        below ``1e-6/max(omega, 1)``.
    samples : int or array_like, shape (n,), optional
        Increasing times at which the motion is reported [dimensionless], or the number of equally
        spaced times, both ends included, at most 10 million. Default: at least 1001, with at least
        32 per revolution; of one disc also 32 per period of the shaft, ``2 pi/sqrt(kappa)``, and 8
        per period of the contact, ``2 pi/sqrt(1 + kappa)``. `samples` is required where these
        exceed 2 million; of a `RotorSystem` they are at most 200,000.
    modes : int, optional
        Number of modes to which a `RotorSystem` is reduced first; the static flexibility of the
        contacts is kept (see `RotorSystem.reduced`).
    more_modes : int, optional
        Larger number of modes of a second run of a `RotorSystem`, which shows how far the events
        move with more modes.
    rtol, atol : float
        Relative and absolute tolerance [dimensionless]. A `RotorSystem` has no `atol`, and takes
        `rtol` from 1e-14 to 1e-4.
    method : {"adams", "bdf", "ida", "taylor"}, optional
        CVODE with Adams (nonstiff) or BDF (stiff), or IDA as an independent check, with `rtol` from
        1e-13 (IDA 1e-12) to 1e-3; or Taylor series, about ten times as fast as CVODE at equal
        error, with `rtol` from 1e-15 to 1e-4. ``docs/events.md`` explains how each finds events.
        Default: Adams, or Taylor series where scikit-sundae, which carries CVODE, is missing. A
        `RotorSystem` has no IDA, and Taylor series by default; CVODE integrates its
        contacts, and with the reference also its flight.
    flight : {"exact", "cvode"}
        Motion of one disc inside the clearance in closed form, or integrated. Taylor series always
        use the closed form; ``backend="python"`` always integrates.
    backend : {"auto", "python", "compiled"}
        The plain-Python reference, which restarts the solvers of scikit-sundae at each root of
        ``|z| = delta0``, or the compiled core, which is many times faster. ``"auto"`` is
        ``"compiled"`` where available. Only the reference supports IDA.
    progress : callable or bool, optional
        Called from time to time with the percentage completed, and 100; True shows a bar on
        standard error.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of a `RotorSystem`: ``simulate(system, contacts=[...], ...)`` is
        ``simulate(replace(system, contacts=[...]), ...)``.

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

        Of a `RotorSystem`: ``x y vx vy`` on ``(t, node)``; ``event_time event_kind event_contact
        event_time_error`` on ``event`` and ``event_state`` (q, velocity); ``normal_force
        tangential_force slip_speed mode`` on ``(t, contact)``; on ``episode`` the table of
        contacts; ``final_state``. With races ``event_race_speed`` on ``(event, contact)``, and on
        ``contact`` their largest and smallest speeds, also between events, and when:
        ``race_speed_max race_speed_max_time race_speed_min race_speed_min_time``. The reference
        knows these only at samples and events.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If the solver gives up; reports time and state. `rotor_ida.core.interface` lists why.
    InvariantError
        If the result contradicts the mechanics; reports time and state.

    Warns
    -----
    UserWarning
        If the motion of a `RotorSystem` without contact grows, with the rate and the whirl speed,
        also in the attributes ``growth_rate_without_contact`` and ``whirl_speed_of_growth``; or if
        neither supports nor contacts hold the system against its constant forces
        (``nothing_holds``).

    Notes
    -----
    ``z'' + 2 zeta z' + max(|z| - delta0, 0)**1.5 z/|z| = omega**2 exp(i omega t)``. An event
    within ``min(100 rtol, 1e-8) duration`` after the end belongs to the run. A start
    exactly on the stator is in contact if it moves outwards, or is about to. Grazes
    below an indentation of about 1e-13 of the lengths involved may be missed or invented.
    ``event_time_error`` comes from a second run by Taylor series with tighter tolerances (of very
    long runs by CVODE with looser ones), and includes the spacing of doubles. It is infinite after
    ``horizon``, where the start no longer determines the orbit at these tolerances.

    A `RotorSystem` moves by ``M q'' + (C + Omega G) q' + K q = unbalance + static force +
    contacts``. Each contact has the displacement ``u = B q - c``; where ``d = |u| - delta > 0`` its
    force on the rotor is ``-(N + i T) u/|u|``, ``N = k d**n max(0, 1 + lambda d')``,
    ``T = mu N sign(v_s)``.

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

    A rotor system:

    >>> import numpy as np
    >>> from rotor_ida import Contact, RotorSystem, Unbalance
    >>> system = RotorSystem(
    ...     mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)},
    ...     contacts=[Contact(node="disc", clearance=1.5, stiffness=4.0, exponent=1.0)],
    ...     unbalance=[Unbalance(node="disc", moment=1.0)], units="1")
    >>> run = simulate(system, speed=0.9, duration=20.0, samples=3)
    >>> run.event_time.values.round(6)[:2], run.event_kind.values[:2]
    (array([ 4.350352, 11.973831]), array([ 1, -1], dtype=int8))
    """
    assert method is not None
    method, backend = with_fallback(method, backend)
    if isinstance(rotor, RotorSystem):
        course = held(check_real("speed", speed), check_positive("duration", duration))
        return run_of_system(
            changed_system(simulate, rotor, changed), course, start=start, samples=samples,
            modes=modes, more_modes=more_modes, rtol=rtol, method=method, progress=progress,
            backend=backend,
        )  # fmt: skip
    assert isinstance(rotor, Rotor)
    progress = check_progress(progress)
    first = start_of(rotor, start)
    check_can_be_followed(rotor, first)
    end = check_duration("duration", duration, rotor.omega)
    options = Options(rtol=rtol, atol=atol, method=method, flight=flight, backend=backend)
    if rotor.omega != 0.0:  # which drives it: else it may fly for ever in one step
        check_length(end, rotor.omega, options.backend)
    return run_of_disc(rotor, first, held(rotor.omega, end), samples, options, progress)
