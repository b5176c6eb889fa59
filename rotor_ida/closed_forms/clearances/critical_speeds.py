"""Critical speeds of a rotor system, where its unbalance acts on each, and how sharp each peak is.

1. *Modes*: a speed Omega is critical where an eigenvalue ``s = -d + i Omega`` turns with it. The
   poles of the response to unbalance, ``(K + s C + s**2 (M - i G)) Q = 0``, are near, or the same
   without damping or gyroscopic moments; Newton's method begins at them. Where K and C depend on
   the speed all are sought: see `crossings`.
2. *Antinodes*: neighbouring nodes that move to the same side are a lobe of the shape. The node of a
   lobe that moves most is where unbalance drives the mode best.
3. *Peaks*: the response to it, as the largest axis of each orbit, and its width where it is
   ``1/sqrt(2)`` of the peak.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.linalg import lstsq
from scipy.optimize import brentq, minimize_scalar

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.closed_forms.crossings import film_pencil, film_speeds, pencil_motions
from rotor_ida.closed_forms.linear_motions import STILL
from rotor_ida.closed_forms.receptances import solved_motions
from rotor_ida.model.assembly import Assembly

# A motion whose forward part is below this, squared, is not driven by unbalance.
DRIVEN = 1e-6
# Modes whose eigenvalue decays by more than this part of its size have no peak.
OVERDAMPED = 0.7
# Eigenvalues below this part of the largest speed are free motions.
FREE = 1e-4
# Modes whose speeds differ by less than this part of them are equally fast: one of them is new if
# more than the other part of its shape is not in those of the others.
EQUAL, OTHER = 1e-7, 0.05
# A lobe is driven if its antinode moves at least this part of the largest one.
LOBE = 0.3
# Part of a peak at which its width is measured, and the relative tolerance of its place.
HALF_POWER, PLACED = math.sqrt(0.5), 1e-9
# Most steps of Newton's method: from a pole three to five suffice. Part of the speed by which they
# may correct rounding.
STEPS, ROUNDED = 12, 1e-6


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode at its critical speed.

    Parameters
    ----------
    speed, decay : float
        Critical speed, and the decay rate: half the width of its peak.
    shape : ndarray of complex, shape (node,)
        Forward displacements of the nodes.
    motion : ndarray of complex, shape (n,)
        Displacements of all coordinates.
    """

    speed: float
    decay: float
    shape: ComplexValues
    motion: ComplexValues


@dataclass(frozen=True, slots=True)
class Peak:
    """A peak of a response: its speed, and speed over width, NaN where it has none."""

    speed: float
    amplification: float


def critical_modes(assembly: Assembly, largest: float) -> list[Mode]:
    """Return the modes with critical speeds up to a speed, or else the slowest one.

    Examples
    --------
    >>> from rotor_ida import RotorSystem
    >>> from rotor_ida.model.assembly import assemble
    >>> system = RotorSystem(mass=np.eye(2), damping=0.2 * np.eye(2), stiffness=np.eye(2),
    ...                      nodes={"disc": (0, 1)}, units="1")
    >>> (mode,) = critical_modes(assemble(system), 3.0)
    >>> round(mode.speed, 6), round(mode.decay, 6)
    (0.994987, 0.1)
    """
    modes: list[Mode] = []
    for speed in _speeds_of_films(assembly, largest) if assembly.films else [0.0]:
        found = _driven_modes(assembly, speed, largest)
        if assembly.films:  # the coefficients are those at the critical speed of one mode
            found = [each for each in found if abs(each.speed - speed) < EQUAL * speed]
        turning = _all_turning(assembly, found, largest, speed)
        for mode in sorted(turning, key=lambda each: each.speed):
            if not _known(mode, modes):
                modes.append(mode)
    modes.sort(key=lambda each: each.speed)
    below = sum(each.speed <= largest for each in modes)
    return modes[: max(below, 1)]


def _driven_modes(assembly: Assembly, speed: float, largest: float) -> list[Mode]:
    """Return the modes that unbalance drives, with the coefficients of films at a speed."""
    size = assembly.size
    pencil = film_pencil(assembly, speed) if assembly.films else _pencil(assembly)
    values, vectors = pencil_motions(*pencil)
    moved = np.einsum("njk,ks->jns", assembly.node_rows(), vectors[:size])
    forward, backward = (moved[0] + side * 1j * moved[1] for side in (1.0, -1.0))
    driven, other = ((np.abs(each) ** 2).sum(axis=0) for each in (forward, backward))
    with np.errstate(invalid="ignore"):
        kept = np.isfinite(values) & (values.imag > FREE * largest)
        kept &= np.abs(values.real) < OVERDAMPED * np.abs(values)
    kept &= driven > DRIVEN * (driven + other)
    kept &= np.abs(moved).max(axis=(0, 1)) > STILL * np.linalg.norm(vectors[:size], axis=0)
    chosen = np.flatnonzero(kept)
    chosen = chosen[np.argsort(values.imag[chosen])]
    return [
        Mode(float(values[i].imag), float(-values[i].real), forward[:, i], vectors[:size, i])
        for i in chosen
    ]


def _all_turning(
    assembly: Assembly, poles: Sequence[Mode], largest: float, speed: float
) -> list[Mode]:
    """Return the modes near poles that turn with the rotor up to a speed, or else the slowest.

    Each lies in the reach of its pole, so that poles far beyond the speed have none.
    """
    found: list[Mode] = []
    for pole in sorted(poles, key=_least_speed):
        slowest = min((each.speed for each in found), default=np.inf)
        if _least_speed(pole) > max(largest, slowest):
            break
        found.append(_turning(assembly, pole, speed))
    return found


def _least_speed(pole: Mode) -> float:
    return pole.speed - _reach(pole)


def _reach(pole: Mode) -> float:
    """Return how far from a pole its mode is looked for."""
    return max(abs(pole.decay), ROUNDED * pole.speed)


def _turning(assembly: Assembly, pole: Mode, speed: float) -> Mode:
    """Return the mode near a pole whose eigenvalue turns with the rotor, by Newton's method.

    Where none is in the pole's reach, it is the pole. Films have the coefficients of
    `speed`.
    """
    stiffness, damping, mass = (
        assembly.stiffness_at(speed), assembly.damping_at(speed), assembly.mass
    )  # fmt: skip
    turning = np.zeros_like(mass) if assembly.gyroscopic is None else assembly.gyroscopic
    root, motion = complex(-pole.decay, pole.speed), pole.motion / np.linalg.norm(pole.motion)
    border = np.append(motion, [0.0, 0.0])
    for _ in range(STEPS):
        resisted = damping + root.imag * turning
        matrix = stiffness + root * resisted + root**2 * mass
        by_root = (resisted + 2.0 * root * mass) @ motion
        by_speed = 1j * by_root + root * (turning @ motion)
        rows = np.column_stack([matrix, by_root, by_speed])
        # the real and imaginary parts of motion and equations; decay and speed are real
        columns = np.vstack([rows, border.conj()])
        columns = np.column_stack([columns, 1j * columns[:, :-2]])
        step = lstsq(
            np.vstack([columns.real, columns.imag]),
            -np.concatenate([each(np.append(matrix @ motion, 0.0)) for each in (np.real, np.imag)]),
            lapack_driver="gelsy",
        )[0]  # as forward and backward motions may be equally fast, the shortest step
        size = len(mass)
        motion = motion + step[:size] + 1j * step[size + 2 :]
        root += complex(*step[size : size + 2])
        if abs(complex(*step[size : size + 2])) < PLACED * abs(root):
            break
    if not abs(root - complex(-pole.decay, pole.speed)) < _reach(pole):
        return pole
    x, y = np.einsum("njk,k->jn", assembly.node_rows(), motion)
    return Mode(root.imag, -root.real, x + 1j * y, motion)


def _pencil(assembly: Assembly) -> tuple[Values, ComplexValues]:
    """Return the matrices whose eigenvalues turn with the rotor at their own speeds."""
    one, zero = np.eye(assembly.size), np.zeros_like(assembly.mass)
    turning = zero if assembly.gyroscopic is None else assembly.gyroscopic
    damping = zero if assembly.damping is None else assembly.damping
    left = np.block([[zero, one], [-assembly.stiffness, -damping]])
    return left, np.block([[one, zero], [zero, assembly.mass - 1j * turning]])


def _speeds_of_films(assembly: Assembly, largest: float) -> list[float]:
    """Return the speeds at which an eigenvalue turns with the rotor, up to a speed."""
    first, last = assembly.films.reach
    first, last = max(first, FREE * largest), min(last, largest)
    return film_speeds(assembly, first, last) if first < last else []


def _known(mode: Mode, modes: Sequence[Mode]) -> bool:
    """Return whether a mode has the shape of others of its speed, or a mixture of their shapes.

    Without gyroscopic moments a forward mode and a backward one have the same eigenvalue, as have
    modes that do not move each other's nodes. Any mixtures of them are eigenvectors.
    """
    near = [each.shape for each in modes if abs(each.speed - mode.speed) <= EQUAL * mode.speed]
    if not near:
        return False
    basis = np.linalg.qr(np.column_stack(near))[0]
    new = mode.shape - basis @ (basis.conj().T @ mode.shape)
    return bool(np.linalg.norm(new) <= OTHER * np.linalg.norm(mode.shape))


def antinodes(mode: Mode, order: Sequence[int]) -> list[tuple[int, float]]:
    """Return the nodes at which unbalance drives a mode best, with the angles of the unbalance.

    `order` are the nodes along the axis. Neighbours whose motions differ by more than a quarter
    turn are of two lobes.
    """
    shape = mode.shape[list(order)]
    largest = shape[np.argmax(np.abs(shape))]
    sides = (shape * largest.conjugate()).real >= 0.0
    ends = [0, *(np.flatnonzero(np.diff(sides.astype(int))) + 1).tolist(), shape.size]
    found = []
    for first, last in pairwise(ends):
        place = first + int(np.argmax(np.abs(shape[first:last])))
        if abs(shape[place]) >= LOBE * abs(largest):
            found.append((int(order[place]), 0.0 if sides[place] else np.pi))
    return found


def orbit_axes(
    assembly: Assembly, rows: Values, unbalance: ComplexValues, speeds: Values
) -> Values:
    """Return the largest axes of the orbits by unbalance, from peak to peak.

    Parameters
    ----------
    assembly : Assembly
        The rotor with its stators.
    rows : ndarray, shape (place, 2, n)
        Displacements by q.
    unbalance : ndarray of complex, shape (n, case)
        Force over the square of the speed: q is the real part of ``Q exp(i theta)``.
    speeds : ndarray, shape (speed,)
        Spin speeds, none of them 0.

    Returns
    -------
    ndarray, shape (case, speed, place)

    Notes
    -----
    An orbit of the displacements X and Y, complex, is the sum of a forward circle of radius
    ``|X + i Y|/2`` and a backward one of radius ``|X - i Y|/2``; its axes are twice their sum and
    their difference.
    """
    motions = solved_motions(assembly, speeds, unbalance)
    moved = np.einsum("pjk,skc->jcsp", rows, motions)
    circles = np.abs(moved[0] + 1j * moved[1]) + np.abs(moved[0] - 1j * moved[1])
    return np.asarray(circles * speeds[:, np.newaxis] ** 2)


def largest_between(
    function: Callable[[float], float], speeds: Values, values: Values, low: float, high: float
) -> tuple[float, float]:
    """Return where a function of the speed is largest between two speeds, and its value.

    `values` are those at `speeds`, which contain both ends.
    """
    inside = np.flatnonzero((speeds >= low) & (speeds <= high))
    best = int(inside[np.argmax(values[inside])])
    ends = (speeds[max(best - 1, inside[0])], speeds[min(best + 1, inside[-1])])
    where, largest = float(speeds[best]), float(values[best])
    if ends[0] < ends[1]:
        found = minimize_scalar(
            lambda omega: -function(omega), bounds=ends, method="bounded",
            options={"xatol": PLACED * high},
        )  # fmt: skip
        if -found.fun > largest:
            where, largest = float(found.x), float(-found.fun)
    return where, largest


def peak_between(
    function: Callable[[float], float], speeds: Values, values: Values, low: float, high: float
) -> Peak | None:
    """Return the largest peak of a response between two speeds, None where it has none there.

    A speed at an end is one of a peak where the response falls on both sides of it.
    Its amplification factor is its speed over the width at 0.707 of its height, or over twice the
    half that lies within the speeds.
    """
    inside = 1 + np.flatnonzero((speeds >= low)[1:-1] & (speeds <= high)[1:-1])
    tops = inside[(values[inside] > values[inside - 1]) & (values[inside] > values[inside + 1])]
    if not tops.size:
        return None
    top = int(tops[np.argmax(values[tops])])
    around = slice(top - 1, top + 2)
    where, largest = largest_between(
        function, speeds[around], values[around], float(speeds[top - 1]), float(speeds[top + 1])
    )

    def above(omega: float) -> float:
        return function(omega) - HALF_POWER * largest

    halves = []
    for side in (-1.0, 1.0):
        beside = speeds[side * (speeds - where) > 0.0]
        nearest = np.sort(side * beside) * side
        foot = next((each for each in nearest.tolist() if above(each) <= 0.0), None)
        if foot is not None:
            end = brentq(above, min(where, foot), max(where, foot), rtol=PLACED)
            halves.append(abs(float(end) - where))
    # where the response ends beforehand, the peak is taken as symmetric
    return Peak(where, where / (2.0 * float(np.mean(halves))) if halves else np.nan)


def margins(peak: Peak, low: float, high: float) -> tuple[float, float]:
    """Return the separation margin of a critical speed from a range of speeds, and that required.

    Both are relative to the nearest end of the range; inside it the margin is negative.

    Notes
    -----
    A peak with an amplification factor below 2.5, or without any, needs none. Otherwise it is
    ``17 (1 - 1/(AF - 1.5))`` per cent, at most 16, below the range, and 10 more above it.
    """
    below = (low - peak.speed) / low
    above = (peak.speed - high) / high
    needed = 0.0
    if peak.amplification >= 2.5:
        needed = 0.17 * (1.0 - 1.0 / (peak.amplification - 1.5))
        needed = min(needed + 0.1, 0.26) if above > below else min(needed, 0.16)
    return max(below, above), needed
