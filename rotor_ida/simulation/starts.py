"""Starts of a motion: a given state, the end of a result, settled, at rest, or drawn in a box."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import (
    AT_REST,
    COMPONENTS,
    STARTS,
    State,
    check_array,
    check_choice,
    check_state,
    check_states,
    check_vector,
    is_scalar,
    listed,
    shown,
)
from rotor_ida.errors import InputError
from rotor_ida.model import disc_starts
from rotor_ida.model.assembly import Assembly, assemble, canonical
from rotor_ida.model.axisymmetric import check_axisymmetric_parts, forward_motions
from rotor_ida.model.contact import spring_force, spring_slope
from rotor_ida.model.reduction import in_modes
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.results.dataset_kinds import KINDS, kind_of
from rotor_ida.results.si_units import dimensionless
from rotor_ida.simulation.options import LARGEST

# One start, as functions take it: a state, of a rotor system (q, velocity), a word, or a result
# that ends in a state. Several are rows of states, or a sequence.
Start = (
    npt.ArrayLike | tuple[npt.ArrayLike, npt.ArrayLike] | Literal["settled", "rest"] | xr.Dataset
    | None
)  # fmt: skip
Starts = npt.ArrayLike | xr.Dataset | Sequence[Start]
# A start of any disc: a state, or the word for one that depends on the rotor.
GivenStart = State | str
# The word for the start at rest, in equilibrium.
REST = "rest"
# Where turning back is not possible, the unbalance must be where it is at time 0, to this part of a
# radian.
IN_STEP = 1e-6
# Kinds of results of systems that end at any angle of the unbalance; in others it is at angle 0.
RUNS = ("system_run", "drop")
# Forces at rest balance to this part of the largest; steps of Newton's method that refine them.
BALANCED, REFINEMENTS = 1e-9, 20
FRICTION_STEPS = np.linspace(0.0, 1.0, 5)
QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


def start_of(rotor: Rotor, start: object, *, phase: float = 0.0, name: str = "start") -> State:
    """Return the state in which one disc starts, with the unbalance along x, or raise `InputError`.

    Parameters
    ----------
    rotor : Rotor
        The disc.
    start : array_like, shape (4,), "settled", "rest", Dataset or None
        A state; a word: on the whirl without contact, or where shaft and contact hold the rotor
        against its load; or a result that ends in a state: a run, one point of a sweep or of many
        run-ups, a limit cycle, or one point of a branch. Without a start the rotor is at rest: in
        equilibrium with its load, or on the axis if there is none.
    phase : float
        Angle of the unbalance where the start is a word [rad].
    name : str
        The argument, for messages.

    Returns
    -------
    tuple of float
        ``(x, y, vx, vy)``.

    Notes
    -----
    A run ends with the unbalance at some angle. The state is turned back by this angle, as the
    equations are the same along all axes; under a load they are not, and the run must end after
    whole revolutions.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> rotor = Rotor(omega=2.0, zeta=0.1, delta0=3.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=math.pi / 2.0)
    >>> x, y, vx, vy = start_of(rotor, run)
    >>> abs(x + run.x[-1].item()) < 1e-12, abs(vy + run.vy[-1].item()) < 1e-12
    (True, True)
    """
    given = given_start(name, start, loaded=rotor.load > 0.0)
    if isinstance(given, str):
        settles = given == "settled"
        return disc_starts.settled(rotor, phase) if settles else disc_starts.hanging(rotor)
    return given


def given_start(name: str, start: object, *, loaded: bool) -> GivenStart:
    """Return a start of one disc as a state or a word: see `start_of`."""
    if start is None:
        return REST if loaded else AT_REST
    if isinstance(start, str):
        return str(check_choice(name, start, STARTS))
    if not isinstance(start, xr.Dataset):
        return check_state(name, start)
    found = dimensionless(start)
    prefix = "end_" if "end_x" in found else ""
    names = [f"{prefix}{each}" for each in COMPONENTS]
    if any(
        each not in found or not found[each].size or "node" in found[each].dims for each in names
    ):
        raise InputError(
            f"{name} must be a state (x, y, vx, vy), or end in one as a run, a limit cycle or one "
            f"point of a sweep of one disc does, got: {KINDS[kind_of(start)].meaning}"
        )
    dims = [str(dim) for dim in found[names[0]].dims if prefix or dim != "t"]
    if dims:
        raise InputError(f"{name} must be one point of a result, got all over {listed(dims)}")
    # a cycle is stored from its start on, with the unbalance along x
    is_cycle, angle = "period" in found, 0.0
    x, y, vx, vy = (float(found[each].values.flat[0 if is_cycle else -1]) for each in names)
    if "end_angle" in found or not (prefix or is_cycle):
        angle = _angle_at_end(found, "omega", "t")
    if loaded or ("load" in found and float(found["load"]) != 0.0):
        if abs(angle) > IN_STEP:
            raise InputError(
                f"{name} must end after whole revolutions under a load, got a run that ends with "
                f"the unbalance at {angle:.6g} rad"
            )
        return x, y, vx, vy
    turn = np.exp(-1j * angle)
    place, velocity = complex(x, y) * turn, complex(vx, vy) * turn
    return check_state(name, (place.real, place.imag, velocity.real, velocity.imag))


def states_of(name: str, starts: object, *, loaded: bool = False) -> list[GivenStart]:
    """Return starts, each as for `given_start`; a result, a word or None alone is one start."""
    if isinstance(starts, xr.Dataset | str | None):
        return [given_start(name, starts, loaded=loaded)]
    if isinstance(starts, list | tuple) and any(
        isinstance(each, xr.Dataset | str | None) for each in starts
    ):
        return [given_start("start", each, loaded=loaded) for each in starts]
    return [*check_states(name, starts)]


def _angle_at_end(end: xr.Dataset, speed: str, time: str) -> float:
    """Return the angle of the unbalance where a run ends, less whole revolutions.

    `speed` and `time` are the names of a constant speed and of the time of the end.
    """
    if "end_angle" in end:  # one of many run-ups
        angle = float(end["end_angle"])
    elif "angle" in end:
        angle = float(end["angle"].values.flat[-1])
    else:
        held, until = ((end if each in end else end.attrs)[each] for each in (speed, time))
        angle = float(np.ravel(held)[-1] * np.ravel(until)[-1])
    return math.remainder(angle, math.tau)


# ---- Of a rotor system ----


def start_of_system(assembly: Assembly, start: object, speed: float) -> Values:
    """Return displacement and velocity of a system and its stators at the start, shape (2, n).

    A start is given as for `start_of`, a state as ``(q, velocity)``. `speed` is that at time 0. A
    system that neither shaft nor supports hold against its constant forces falls from the axis. A
    run of one that is not the same in all directions must end after whole revolutions.
    """
    given = state_at_end(assembly, start)
    if given is None:
        return hanging(assembly, speed)
    if isinstance(given, str):
        chosen, assembly = check_choice("start", given, STARTS), assembly.at(speed)
        return settled(assembly, speed) if chosen == "settled" else rest(assembly, speed)
    return _checked_motion(assembly, given)


def _checked_motion(assembly: Assembly, start: object) -> Values:
    """Return displacement and velocity as given, with those of stators that are left out at 0."""
    state = np.zeros((2, assembly.size))
    if not isinstance(start, tuple | list) or len(start) != 2:
        raise InputError(f'start must be (q, velocity), "settled" or "rest", got {shown(start)}')
    own = assembly.system.size
    for row, given, name in zip(state, start, ("displacement", "velocity"), strict=True):
        values = check_array(f"{name} of the start", given)
        if values.shape not in {(own,), (assembly.size,)}:
            raise InputError(
                f"{name} of the start must have the shape {(own,)}, got {values.shape}"
            )
        row[: values.size] = values
    return state


def begun_in_modes(
    system: RotorSystem, modes: int | None, start: Any, word: str = "start"
) -> tuple[Assembly, Any]:
    """Return a system in a number of modes, and a start there: see `state_at_end`."""
    if modes is not None and isinstance(start, xr.Dataset):
        raise InputError(f"{word} must be (q, velocity) with modes, got a result and {modes!r}")
    taken, begun = in_modes(system, modes, start)
    assembly = assemble(taken)
    return assembly, state_at_end(assembly, begun)


def state_at_end(assembly: Assembly, start: Any) -> Any:
    """Return a start of a system as given, or displacement and velocity at the end of a result."""
    if not isinstance(start, xr.Dataset):
        return start
    if "final_state" not in start or start["final_state"].ndim != 1:
        raise InputError(
            'start must be (q, velocity), "settled", "rest", or end as a run, a limit cycle or one '
            f"point of a sweep of a rotor system does, got: {KINDS[kind_of(start)].meaning}"
        )
    in_si = "t" in start and start["t"].attrs.get("units") == "s"
    if "t" in start and in_si != (assembly.system.units == "SI"):
        units = "SI units" if assembly.system.units == "SI" else "no units"
        raise InputError(f"start must have {units}, as the system has, got one in others")
    speeds = [each.speed for each in dict.fromkeys(assembly.races) if each is not None]
    values, size = np.asarray(start["final_state"].values, float), assembly.size
    if values.size != 2 * size + len(speeds) or not np.isfinite(values).all():
        raise InputError(
            f"start must end in {2 * size + len(speeds)} finite numbers, as this system has, got "
            f"{values.size}"
        )
    if not np.array_equal(values[2 * size :], speeds):
        raise InputError(
            "start must end with the races at their speeds at time 0, {speed}, got {value}: give "
            "these to each Race",
            name="speed", speed=speeds, value=values[2 * size :].tolist(),
        )  # fmt: skip
    motion, angle = values[: 2 * size].reshape(2, size), 0.0
    if "end_angle" in start or kind_of(start) in RUNS:
        if "angle" in start and float(start["t"][-1]) != start.attrs["duration"]:
            raise InputError(
                "start must have a sample at its end, {duration}, got the last at {time}",
                duration=float(start.attrs["duration"]), time=float(start["t"][-1]),
            )  # fmt: skip
        phase = 0.0 if "end_angle" in start else start.attrs.get("phase", 0.0)
        angle = math.remainder(_angle_at_end(start, "speed", "duration") + phase, math.tau)
    moved = _turned_back(assembly, motion, angle)
    return moved[0], moved[1]


def _turned_back(assembly: Assembly, motion: Values, angle: float) -> Values:
    """Return displacement and velocity turned back by an angle, shape (2, n)."""
    if abs(angle) <= IN_STEP or not assembly.unbalance.any():
        return motion
    try:
        check_axisymmetric_parts(assembly)
        shapes, found = forward_motions(assembly).basis, canonical(assembly)
    except InputError as error:
        raise InputError(
            "start must end after whole revolutions, as the system is not the same in all "
            f"directions, got the unbalance at {angle:.6g} rad"
        ) from error
    moved = np.array([found.to_y(each) for each in motion])
    turn = np.exp(-1j * angle) - 1.0
    return found.to_q(moved + 2.0 * ((turn * (moved @ shapes.conj())) @ shapes.T).real)


def settled(assembly: Assembly, speed: float) -> Values:
    """Return the steady state without contact at time 0: static deflection and whirl."""
    resisted = assembly.damping_at(speed)
    if assembly.gyroscopic is not None:
        resisted = resisted + speed * assembly.gyroscopic
    dynamic = assembly.stiffness - speed**2 * assembly.mass + 1j * speed * resisted
    force = speed**2 * (assembly.unbalance[0] - 1j * assembly.unbalance[1])
    whirl = np.zeros(assembly.size, complex)
    try:
        if force.any():
            whirl = np.linalg.solve(dynamic, force)
    except np.linalg.LinAlgError as error:
        raise InputError(
            "start cannot be settled, as the stiffness is singular at this speed"
        ) from error
    return np.array([_deflected(assembly) + whirl.real, (1j * speed * whirl).real])


def _deflected(assembly: Assembly) -> Values:
    """Return the static deflection; motions that nothing holds and nothing drives stay at 0."""
    try:
        return np.asarray(np.linalg.solve(assembly.stiffness, assembly.force))
    except np.linalg.LinAlgError as error:
        found = np.linalg.lstsq(assembly.stiffness, assembly.force)[0]
        left = np.abs(assembly.stiffness @ found - assembly.force).max()
        if left > BALANCED * float(np.abs(assembly.force).max()):
            raise InputError(
                "start cannot be settled, as the stiffness is singular and does not hold the "
                "system against its constant forces"
            ) from error
        return np.asarray(found)


def hanging(assembly: Assembly, speed: float) -> Values:
    """Return the equilibrium under the constant forces, or the axis where the rotor falls.

    What neither stiffness nor supports hold falls, even where a contact would hold it.
    """
    on_axis, force = np.zeros((2, assembly.size)), assembly.force
    if not force.any():
        return on_axis
    stiffness = assembly.at(speed).stiffness
    sag = np.linalg.lstsq(stiffness, force)[0]
    if not np.abs(stiffness @ sag - force).max() <= BALANCED * float(np.abs(force).max()):
        return on_axis
    return rest(assembly.at(speed), speed)


def rest(assembly: Assembly, speed: float = 0.0) -> Values:
    """Return the equilibrium under the constant forces, in supports and contacts, at rest.

    Notes
    -----
    Without friction it is the minimum of ``q' K q/2 - f q + sum k d**(n + 1)/(n + 1)``, which is
    convex for ``n >= 1``. Newton's method refines it, with the part of K that has no potential,
    and then with friction, which grows in steps: a rotor that spins slides, and climbs its stator.
    """
    from scipy.optimize import minimize  # noqa: PLC0415 - takes long to import

    size, unit = assembly.size, assembly.smallest_clearance
    laws = [each.stiffness * unit ** (each.exponent - 1.0) for each in assembly.contacts]
    scale = unit**2 * (max(float(np.abs(assembly.stiffness).max()), *laws, 0.0) or 1.0)

    def potential(q: Values) -> float:
        energy = 0.5 * q @ assembly.stiffness @ q - assembly.force @ q
        for number, contact in enumerate(assembly.contacts):
            indented = max(_indentation(assembly, number, q)[0], 0.0)
            energy += (
                contact.stiffness * indented ** (contact.exponent + 1.0) / (contact.exponent + 1.0)
            )
        return float(energy) / scale

    found = minimize(
        lambda s: potential(s * unit), np.zeros(size), method="trust-exact",
        jac=lambda s: unit / scale * _imbalance(assembly, s * unit, symmetric=True)[0],
        hess=lambda s: unit**2 / scale * _imbalance(assembly, s * unit, symmetric=True)[1],
        options={"gtol": BALANCED},
    )  # fmt: skip
    q = np.asarray(found.x * unit)
    slides = speed != 0.0 and any(each.friction > 0.0 for each in assembly.contacts)
    for sliding in np.sign(speed) * FRICTION_STEPS if slides else (0.0,):
        for _ in range(REFINEMENTS):
            left, slopes = _imbalance(assembly, q, sliding=sliding)
            q = q - np.linalg.lstsq(slopes, left)[0]
        left = _imbalance(assembly, q, sliding=sliding)[0]
    if not np.abs(left).max() <= BALANCED * float(np.abs(assembly.force).max()):
        raise InputError(
            "start cannot be at rest, as neither supports nor contacts hold the system against its "
            "constant forces"
        )
    return np.array([q, np.zeros(size)])


def _indentation(assembly: Assembly, number: int, q: Values) -> tuple[float, Values, float]:
    """Return how far a contact is pressed in, the direction of its displacement, and its size."""
    contact = assembly.contacts[number]
    u = assembly.rows[number] @ q - np.array(contact.centre)
    radius = float(np.hypot(*u))
    return radius - contact.clearance, u / radius if radius > 0.0 else u, radius


def _imbalance(
    assembly: Assembly, q: Values, *, symmetric: bool = False, sliding: float = 0.0
) -> tuple[Values, Values]:
    """Return the forces that do not balance at rest, and their derivatives by q.

    Friction is multiplied by `sliding`, which is negative where the rotor spins backwards.
    """
    matrix = assembly.stiffness
    matrix = 0.5 * (matrix + matrix.T) if symmetric else matrix
    left, slopes = matrix @ q - assembly.force, matrix.copy()
    for number, contact in enumerate(assembly.contacts):
        indented, along, radius = _indentation(assembly, number, q)
        if indented <= 0.0 or radius == 0.0:
            continue
        rows, n = assembly.rows[number], contact.exponent
        force = contact.stiffness * spring_force(indented, n)
        stiff = contact.stiffness * spring_slope(indented, n) * np.outer(along, along)
        stiff += force / radius * (np.eye(2) - np.outer(along, along))
        rubbing = np.eye(2) + sliding * contact.friction * QUARTER_TURN
        stiff = rubbing @ stiff
        left += rows.T @ (rubbing @ (force * along))
        slopes += rows.T @ stiff @ rows
    return left, slopes


# ---- Drawn from a box ----


def drawn_from(box: Values, seed: int, first: int, last: int) -> Values:
    """Return starts `first` to `last` of a box, shape (4, n), as if all were drawn at once."""
    bits = np.random.PCG64(seed)
    bits.advance(len(COMPONENTS) * first)
    chance = np.random.Generator(bits).random((last - first, len(COMPONENTS)))
    return np.asarray(box[:, :1] + (box[:, 1:] - box[:, :1]) * chance.T)


def box_of(ranges: Mapping[str, npt.ArrayLike], starts: int) -> Values:
    """Return the ends of the four ranges, shape (4, 2), from which `starts` are drawn."""
    box = np.array([range_of(name, ranges[name]) for name in COMPONENTS])
    if starts > 1 and (box[:, 0] == box[:, 1]).all():
        raise InputError(f"x, y, vx or vy must be a range, got numbers for {starts} starts")
    return box


def range_of(name: str, value: object) -> tuple[float, float]:
    """Return the ends of a range; a number is a range of length zero."""
    ends = check_vector(name, value, largest=LARGEST).tolist()
    if len(ends) > 2 or (len(ends) == 1 and not is_scalar(name, value)):
        raise InputError(
            "{name} must be a number or a range (low, high), got {value}", name=name, value=ends
        )
    low, high = ends[0], ends[-1]
    if low > high:
        raise InputError(
            "{name} must be a range (low, high) with low <= high, got {value}",
            name=name, value=(low, high),
        )  # fmt: skip
    return low, high
