"""Where a rotor system starts: in a given state, where a result ends, settled, or at rest."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import STARTS, check_array, check_choice, shown
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, canonical
from rotor_ida.model.axisymmetric import check_axisymmetric_parts, forward_motions
from rotor_ida.model.contact import spring_force, spring_slope
from rotor_ida.results.kinds import KINDS, kind_of
from rotor_ida.simulation.starts import IN_STEP

Start = Literal["settled", "rest"] | tuple[npt.ArrayLike, npt.ArrayLike] | None
# Kinds of results that end at any angle of the unbalance; other states have it at angle 0.
RUNS = ("system_run", "drop")
# Forces at rest balance to this part of the largest; steps of Newton's method that refine them.
BALANCED, REFINEMENTS = 1e-9, 20
FRICTION_STEPS = np.linspace(0.0, 1.0, 5)
QUARTER_TURN = np.array([[0.0, -1.0], [1.0, 0.0]])


def start_of(assembly: Assembly, start: Start | xr.Dataset, speed: float) -> Values:
    """Return displacement and velocity at time 0, shape (2, n)."""
    start = state_at_end(assembly, start)
    size, own = assembly.size, assembly.system.size
    if start is None:
        return np.zeros((2, size))
    if isinstance(start, str):
        chosen = check_choice("start", start, STARTS)
        return settled(assembly, speed) if chosen == "settled" else rest(assembly, speed)
    if not isinstance(start, tuple | list) or len(start) != 2:
        raise InputError(f'start must be (q, velocity), "settled" or "rest", got {shown(start)}')
    state = np.zeros((2, size))
    for row, given, name in zip(state, start, ("displacement", "velocity"), strict=True):
        values = check_array(f"{name} of the start", given)
        if values.shape not in {(own,), (size,)}:
            raise InputError(
                f"{name} of the start must have the shape {(own,)}, got {values.shape}"
            )
        row[: values.size] = values
    return state


def state_at_end(assembly: Assembly, start: Start | xr.Dataset) -> Start:
    """Return a start as given, or displacement and velocity at the end of a result.

    A result ends at some angle of the unbalance. In an axisymmetric system the state is turned back
    by this angle; any other must end after whole revolutions, unless nothing is unbalanced.
    """
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
    motion = values[: 2 * size].reshape(2, size)
    moved = _turned_back(assembly, motion, _angle_at_end(start))
    return moved[0], moved[1]


def _angle_at_end(start: xr.Dataset) -> float:
    """Return the angle of the unbalance at the end of a result, less whole revolutions."""
    if "end_angle" in start:  # a run-up of many
        return math.remainder(float(start["end_angle"]), math.tau)
    if kind_of(start) not in RUNS:
        return 0.0
    phase = start.attrs.get("phase", 0.0)
    if "angle" not in start:
        return math.remainder(start.attrs["speed"] * start.attrs["duration"] + phase, math.tau)
    if float(start["t"][-1]) != start.attrs["duration"]:
        raise InputError(
            "start must have a sample at its end, {duration}, got the last at {time}",
            duration=float(start.attrs["duration"]), time=float(start["t"][-1]),
        )  # fmt: skip
    return math.remainder(float(start["angle"][-1]) + phase, math.tau)


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
    size = assembly.size
    resisted = np.zeros((size, size)) if assembly.damping is None else assembly.damping
    if assembly.gyroscopic is not None:
        resisted = resisted + speed * assembly.gyroscopic
    dynamic = assembly.stiffness - speed**2 * assembly.mass + 1j * speed * resisted
    force = speed**2 * (assembly.unbalance[0] - 1j * assembly.unbalance[1])
    whirl = np.zeros(size, complex)
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
