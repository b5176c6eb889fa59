"""Eigenvalues of a rotor system at a spin speed, and its critical speeds.

A speed is critical where an eigenvalue turns with it: where a whirl speed is the spin speed in
size. See `rotor_ida.closed_forms.crossings` for how all of them are found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

from rotor_ida.arrays import ComplexValues, Flags, Values
from rotor_ida.closed_forms.crossings import Motion, crossing_speeds, eigenvalues_and_slopes
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, canonical
from rotor_ida.model.axisymmetric import check_masses, forward_motions
from rotor_ida.model.bearing import Films

# A motion whose displacements at all nodes are below this part of the largest moves none.
STILL = 1e-9
# Forward and backward parts of a motion that differ by less are equal: it is along a line.
STRAIGHT = 1e-6
# Singular values below this part of the largest are 0: a motion that no stiffness holds.
SINGULAR = 1e-11
# Growth and decay below this part of the largest eigenvalue come from rounding.
ROUNDING = 100.0 * np.finfo(float).eps
# The lowest critical speed that is sought, over the highest.
LOWEST = 1e-6
# Relative distance of critical speeds that are one.
ONE = 1e-9


class Motions(NamedTuple):
    """Eigenvalues on fixed axes, and which way each motion whirls: 1 with the spin, -1, or 0.

    Those that are not seen move no node. Conjugate ones are left out.
    """

    eigenvalues: ComplexValues
    senses: npt.NDArray[np.int8]
    seen: Flags


class CriticalSpeed(NamedTuple):
    """A critical speed, negative against the positive sense, and the motion at it."""

    speed: float
    sense: int
    damping_ratio: float


@dataclass(frozen=True, slots=True)
class LinearMotions:
    """The linear motions of a system; of an axisymmetric one, the forward ones, complex.

    Parameters
    ----------
    stiffness, damping, gyroscopic : ndarray, shape (n, n)
        Matrices in coordinates with a unit mass matrix.
    rows : ndarray, shape (k, n)
        What springs at the contacts stretch by.
    films : Films
        The bearings whose coefficients depend on the speed, which the matrices lack.
    nodes : ndarray, shape (node, 2, n), optional
        Displacements of nodes and contacts; None for the motions of an axisymmetric system.
    """

    stiffness: npt.NDArray[Any]
    damping: npt.NDArray[Any]
    gyroscopic: npt.NDArray[Any]
    rows: npt.NDArray[Any]
    films: Films
    nodes: Values | None = None

    def held(self, spring: float, omega: float) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Return the stiffness with springs at the contacts, and the damping, at a speed."""
        stiffness = self.stiffness + spring * (self.rows.conj().T @ self.rows)
        joined = self.films.joined
        return joined(stiffness, "stiffness", omega), joined(self.damping, "damping", omega)

    def at(self, spring: float, omega: float) -> Motions:
        """Return the motions at a speed."""
        stiffness, damping = self.held(spring, omega)
        resisted = damping + omega * self.gyroscopic
        matrix = first_order(stiffness, resisted)
        spin = -1.0 if omega < 0.0 else 1.0
        if self.nodes is None:
            found = _exact(np.linalg.eigvals(matrix), stiffness, resisted)
            senses = spin * np.sign(found.imag)
            return Motions(found, senses.astype(np.int8), np.ones(found.size, bool))
        found, vectors = np.linalg.eig(matrix)
        found = _exact(found, stiffness, resisted)
        chosen = found.imag >= 0.0
        found, shapes = found[chosen], vectors[: len(stiffness), chosen]
        moved = np.einsum("njk,ks->njs", self.nodes, shapes)
        largest = np.abs(moved).max(axis=(0, 1), initial=0.0)
        seen = largest > STILL * np.linalg.norm(shapes, axis=0)
        forward, backward = (
            (np.abs(moved[:, 0] + sign * moved[:, 1]) ** 2).sum(axis=0) for sign in (1j, -1j)
        )
        whirls = np.abs(forward - backward) > STRAIGHT * (forward + backward)
        senses = np.where(whirls & (found.imag > 0.0), spin * np.sign(forward - backward), 0.0)
        return Motions(found, senses.astype(np.int8), seen | (len(self.nodes) == 0))

    def eigenvalues(self, omega: float) -> ComplexValues:
        """Return the eigenvalues without contact at a speed, but for 0."""
        stiffness, damping = self.held(0.0, omega)
        resisted = damping + omega * self.gyroscopic
        rates = np.linalg.eigvals(first_order(stiffness, resisted))
        found = _exact(rates, stiffness, resisted)
        return np.asarray(found[found != 0.0])

    def turning(self, spring: float, side: float, sense: float) -> Callable[[float], Motion]:
        """Return the eigenvalues at sizes of the speed, conjugate for the sense -1.

        `side` is the sign of the speed; of an axisymmetric system, whose motions are complex, one
        sense has those whose whirl speeds are positive.
        """
        size = len(self.stiffness)

        def at(speed: float) -> Motion:
            omega = side * speed
            stiffness, damping = self.held(spring, omega)
            left = first_order(stiffness, damping + omega * self.gyroscopic)
            slope = np.zeros_like(left)
            slope[size:, size:] = -side * self.gyroscopic
            if self.films:
                slope[size:, :size] = -side * self.films.matrix("stiffness", omega, 1)
                slope[size:, size:] -= side * self.films.matrix("damping", omega, 1)
            values, slopes = eigenvalues_and_slopes(left, slope)
            return (values, slopes) if sense > 0.0 else (values.conj(), slopes.conj())

        return at


def linear_motions(assembly: Assembly) -> LinearMotions:
    """Return the linear motions of a system with its stators."""
    check_masses(assembly)
    try:
        forward = forward_motions(assembly)
    except InputError:
        pass
    else:
        return LinearMotions(
            forward.stiffness, forward.damping, forward.gyroscopic, forward.rows, forward.films
        )
    found = canonical(assembly)
    zero = np.zeros_like(found.stiffness)
    return LinearMotions(
        stiffness=found.stiffness,
        damping=zero if found.damping is None else found.damping,
        gyroscopic=zero if found.gyroscopic is None else found.gyroscopic,
        rows=found.rows.reshape(-1, assembly.size),
        films=found.films,
        nodes=np.concatenate([found.rows_in_y(assembly.node_rows()), found.rows]),
    )


def critical_speeds(
    motions: LinearMotions, spring: float, low: float, high: float
) -> Iterator[CriticalSpeed]:
    """Yield the critical speeds between two speeds, but for 0."""
    for side in (-1.0, 1.0):
        last = max(side * low, side * high)
        first = max(min(side * low, side * high), LOWEST * last)
        if not 0.0 < first < last:
            continue
        knots = np.sort(side * motions.films.knots)
        found = [
            size
            for sense in ((1.0,) if motions.nodes is not None else (1.0, -1.0))
            for size in crossing_speeds(motions.turning(spring, side, sense), knots, first, last)
        ]
        for size, number in _merged(found):
            here = motions.at(spring, side * size)
            nearest = np.argsort(np.abs(np.abs(here.eigenvalues.imag) - size))[:number]
            for i in nearest[here.seen[nearest]].tolist():
                ratio = -here.eigenvalues[i].real / np.abs(here.eigenvalues[i])
                yield CriticalSpeed(side * size, int(here.senses[i]), float(ratio))


def growth_thresholds(motions: LinearMotions, speeds: Values) -> Iterator[tuple[float, float]]:
    """Yield the speeds at which the motion begins or ceases to grow, and its whirl speed there.

    Neighbouring speeds, in ascending order, and knots of films between them must not have two
    thresholds in between.
    """
    growth = cache(lambda speed: float(motions.eigenvalues(speed).real.max(initial=-np.inf)))
    knots = motions.films.knots
    inside = knots[(knots > speeds[0]) & (knots < speeds[-1])]
    for low, high in pairwise(np.unique(np.concatenate([speeds, inside])).tolist()):
        if (growth(low) > 0.0) != (growth(high) > 0.0):
            speed = _threshold(growth, low, high)
            found = motions.at(0.0, speed)
            fastest = int(np.argmax(np.where(found.seen, found.eigenvalues.real, -np.inf)))
            whirl_speed = abs(float(found.eigenvalues[fastest].imag))
            yield speed, -whirl_speed if found.senses[fastest] < 0 else whirl_speed


def _threshold(growth: Callable[[float], float], low: float, high: float) -> float:
    """Return where a growth rate leaves or reaches the numbers above 0, between two speeds."""
    if growth(low) * growth(high) < 0.0:
        return float(brentq(growth, low, high, xtol=1e-13 * high))
    grows = growth(low) > 0.0  # the other is 0 without damping
    while high - low > 1e-13 * high and low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if (growth(middle) > 0.0) == grows else (low, middle)
    return high


def _merged(roots: Sequence[float]) -> Iterator[tuple[float, int]]:
    """Yield roots in ascending order, with the number of those that are one."""
    every = np.sort(np.array(roots))
    first = np.flatnonzero(np.diff(every, prepend=-1.0) > ONE * every)
    yield from zip(every[first].tolist(), np.diff(first, append=every.size).tolist(), strict=True)


def _exact(
    eigenvalues: ComplexValues, stiffness: npt.NDArray[Any], damping: npt.NDArray[Any]
) -> ComplexValues:
    """Return eigenvalues without what rounding makes of those at 0 and of undamped motions.

    A free motion p with ``K p = 0`` has the eigenvalue 0, twice if no damping resists it either.
    Rounding moves such a pair by the square root of its size, half of the pairs to growth.
    """
    left, sizes, right = np.linalg.svd(stiffness)
    free = sizes <= SINGULAR * sizes.max(initial=0.0)
    resists = left[:, free].conj().T @ damping @ right[free].conj().T
    scale = np.abs(damping).max(initial=0.0)
    twice = np.linalg.svd(resists, compute_uv=False) <= SINGULAR * scale
    found = eigenvalues.astype(complex)
    found[np.argsort(np.abs(found))[: free.sum() + twice.sum()]] = 0.0
    rounded = np.abs(found.real) <= ROUNDING * np.abs(found).max(initial=0.0)
    return np.where(rounded, 1j * found.imag, found)


def first_order(stiffness: npt.NDArray[Any], damping: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the matrices of ``(p, p')`` for ``p'' + C p' + K p = 0``, shape (..., 2 n, 2 n)."""
    stiffness, damping = np.broadcast_arrays(stiffness, damping)
    one = np.broadcast_to(np.eye(stiffness.shape[-1]), stiffness.shape)
    return np.block([[0.0 * one, one], [-stiffness, -damping]])
