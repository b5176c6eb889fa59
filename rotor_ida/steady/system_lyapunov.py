"""Lyapunov exponents of a rotor system at a constant speed."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, Stop, Values
from rotor_ida.checks import (
    check_between,
    check_count,
    check_positive,
    check_progress,
    check_real,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.parallel import Progress, interruptible, shows_progress
from rotor_ida.results.provenance import provenance
from rotor_ida.schema import labelled_dataset
from rotor_ida.simulation.lyapunov import (
    BATCHES,
    FEWEST_BATCHES,
    FEWEST_SPANS,
    POINTS_SHOWN,
    means_of_rates,
)
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from rotor_ida.steady.system_sweep import check_slowest, first_state
from rotor_ida.systems.assembly import assemble
from rotor_ida.systems.modes import in_modes
from rotor_ida.systems.receptances import checked_speeds
from rotor_ida.systems.simulate import LOOSEST_RTOL, TIGHTEST_RTOL
from rotor_ida.systems.starts import Start
from rotor_ida.systems.units import with_system_units

# Revolutions at most: each keeps one number for each exponent in memory.
LONGEST = 1_000_000


@shows_progress
def lyapunov_exponent_system(
    system: RotorSystem,
    *,
    speed: float,
    start: Start | xr.Dataset = None,
    exponents: int | None = None,
    transient: int = 200,
    revolutions: int = 2000,
    batches: int = BATCHES,
    modes: int | None = None,
    rtol: float = 1e-10,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute the largest Lyapunov exponents of the motion of a rotor system.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    speed : float
        Spin speed, not 0.
    start, modes : optional
        As in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
    exponents : int, optional
        Number of exponents, the largest first; default: all, one for each displacement, velocity
        and speed of a race.
    transient : int
        Revolutions to settle before averaging; the small changes align in them too.
    revolutions : int
        Revolutions over which to average, at least 20 for each batch, at most a million.
    batches : int
        Number of parts of `revolutions`, at least 4, whose scatter gives the error.
    rtol : float
        Relative tolerance, from 1e-14 to 1e-4.
    progress : callable or bool, optional
        Called with the number of revolutions done and their total; True shows a bar on standard
        error.

    Returns
    -------
    Dataset
        ``lyapunov_exponent`` and ``lyapunov_error`` on ``exponent``, the largest first, per unit of
        time; ``running_exponent`` on ``t`` and ``exponent``, the plain mean so far.

    Raises
    ------
    InputError
        If an argument cannot be used.
    SimulationError
        If a run is stuck.

    Notes
    -----
    Small changes of the motion follow the linearised equations along it, and jump where slip ends
    or turns (saltation). After each revolution they are made orthonormal; their mean rates of
    growth are the exponents. Means and errors are those of `lyapunov_exponent` of one disc. In an
    axisymmetric system one exponent of a motion other than a whirl at the spin speed is 0, that of
    a shift in time. An exponent is minus infinity where a contact rolls in every revolution, as
    rolling leaves no slip, and where a change shrinks below 1e-12 in a revolution.

    References
    ----------
    G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15, 1980.
    P. C. Müller, Chaos, Solitons & Fractals 5, 1995: the jump at discontinuities.

    Examples
    --------
    >>> import numpy as np
    >>> from rotor_ida import RotorSystem
    >>> system = RotorSystem(mass=np.eye(2), damping=0.14 * np.eye(2), stiffness=np.eye(2),
    ...                      nodes={"disc": (0, 1)}, units="1")
    >>> found = lyapunov_exponent_system(system, speed=1.7, transient=20, revolutions=80, batches=4)
    >>> found.lyapunov_exponent.values.round(5)
    array([-0.07, -0.07, -0.07, -0.07])
    """
    system = changed_system(lyapunov_exponent_system, system, changed)
    here, progress = check_real("speed", speed), check_progress(progress)
    speeds = checked_speeds(here)
    if here == 0.0:
        raise InputError("speed must not be 0 for the exponents of a rotor system, got 0.0")
    tolerance = check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL)
    parts = check_count("batches", batches, FEWEST_BATCHES)
    lead = math.ceil(check_positive("transient", transient, LONGEST))
    each = int(check_positive("revolutions", revolutions, LONGEST)) // parts
    if each < FEWEST_SPANS:
        raise InputError(
            f"revolutions must be at least {FEWEST_SPANS} for each of {parts} batches, "
            f"got {shown(revolutions)}"
        )
    taken, begun = in_modes(system, modes, start)
    problem = SettlingProblem.of(assemble(taken), tolerance)
    check_slowest(problem, speeds)
    state = first_state(problem, begun, here)
    count = state.size if exponents is None else check_count("exponents", exponents, 1)
    if count > state.size:
        raise InputError(f"exponents must be at most {state.size}, got {shown(exponents)}")

    total, done = lead + parts * each, list[int]()

    def rates_of_growth(stop: Stop) -> Values:
        flow = SystemFlow.at(problem, here, stop)
        return flow.growth(state / flow.scales, count, total, done)[lead:]

    def tell(progress: Progress) -> None:
        progress(len(done), total)

    rates = interruptible(rates_of_growth, told=progress and partial(tell, progress))
    if progress is not None:
        progress(total, total)
    attributes = provenance({"method": "taylor", "rtol": tolerance})
    return with_system_units(_dataset(rates, here, lead, parts, attributes), system)


def _dataset(
    rates: Values, speed: float, lead: int, parts: int, attributes: dict[str, Any]
) -> xr.Dataset:
    """Return the exponents by the rates of growth in each revolution after the first ones."""
    revolutions, count = rates.shape
    values, errors = np.full(count, -np.inf), np.zeros(count)
    known = np.isfinite(rates).all(axis=0)
    values[known], errors[known] = means_of_rates(rates[:, known], parts)
    order = np.argsort(-values, kind="stable")
    places = np.unique(np.linspace(1, revolutions, min(POINTS_SHOWN, revolutions)).astype(int))
    running = np.cumsum(rates, axis=0)[places - 1] / places[:, np.newaxis]
    variables: dict[str, Column] = {
        "lyapunov_exponent": ("exponent", values[order]),
        "lyapunov_error": ("exponent", errors[order]),
        "running_exponent": (("t", "exponent"), running[:, order]),
    }
    revolution = 2.0 * math.pi / abs(speed)
    coordinates: dict[str, Column] = {
        "speed": ((), speed), "exponent": ("exponent", np.arange(count)),
        "t": ("t", revolution * places),
    }  # fmt: skip
    how = attributes | {
        "transient": lead * revolution, "duration": revolutions * revolution, "batches": parts,
    }  # fmt: skip
    return labelled_dataset(
        "Lyapunov exponents of one motion of a rotor system", variables, coordinates, how,
        kind="lyapunov_exponent",
    )  # fmt: skip
