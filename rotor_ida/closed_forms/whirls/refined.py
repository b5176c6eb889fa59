"""Refine eigenvalues of whirls in the matrices as they were given.

An eigenvalue that LAPACK returns is wrong by rounding of the largest one. In a rotor of finite
elements that is a million times faster than the whirl, and a growth rate is small beside both. With
the eigenvectors x and y of ``P(L) x = 0`` and ``y' P(L) = 0`` from an inverse iteration, the step

    L - y' P(L) x / (y' P'(L) x)

is exact to the product of their errors, if ``y' P x`` is. Its stiffness part cancels most: it is
summed exactly, from products of slices of the numbers that fit a double.

On rotating axes a small motion has the parts ``x_1 exp((L + i Omega) t)``, forwards, and
``x_2 exp((L - i Omega) t)``, whose conjugate is forwards. Both obey the given matrices,
``D(s) = K + s (C + Omega G) + s**2 M``, and the contacts couple them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import ROUNDING, ComplexValues, Values
from rotor_ida.closed_forms.whirls.turning_axes import Springs
from rotor_ida.model.assembly import Assembly
from rotor_ida.model.axisymmetric import ForwardMotions

# Corrections above this part of the largest eigenvalue are no rounding, and are left out.
LARGEST_STEP = 1e-12
# Left and right eigenvectors nearer to a right angle than this are of a multiple eigenvalue.
SQUARE = 1e-6
# Distance from the eigenvalue, over the largest one, at which eigenvectors are computed.
BESIDE = 8.0 * ROUNDING
# Bits of a double, and slices of it that are multiplied.
BITS, SLICES = 53, 3


def refined_growth(
    motions: ForwardMotions,
    assembly: Assembly,
    speeds: Values,
    eigenvalues: ComplexValues,
    springs: Sequence[Springs] | None,
) -> Values:
    """Return the largest real part of the eigenvalues of each whirl, refined.

    Parameters
    ----------
    speeds : ndarray, shape (whirl,)
        Spin speeds.
    eigenvalues : ndarray of complex, shape (whirl, k)
        Eigenvalues on rotating axes, or without springs on fixed ones.
    springs : sequence of Springs, optional
        The contacts; None where there is none, so that forward motions are alone.
    """
    found = eigenvalues[np.arange(speeds.size), eigenvalues.real.argmax(axis=1)]
    if not speeds.size:
        return np.asarray(found.real)
    problem = _Problem(motions, assembly, speeds, springs)
    largest = np.abs(eigenvalues).max(axis=1)
    try:
        # beside the eigenvalue, where the matrix is not singular
        x, y = problem.vectors(found + BESIDE * largest)
    except np.linalg.LinAlgError:
        return np.asarray(found.real)
    slope = problem.product(found, x, y, slope=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        step = problem.product(found, x, y) / slope
    size = np.linalg.norm(x, axis=(1, 2)) * np.linalg.norm(y, axis=(1, 2))
    good = np.abs(step) <= LARGEST_STEP * largest
    good &= np.abs(slope) > SQUARE * size * np.abs(found)
    return np.asarray(np.where(good, found - np.where(good, step, 0.0), found).real)


@dataclass(frozen=True, slots=True)
class _Problem:
    """The eigenvalue problem of whirls, in forward motions and in the given matrices."""

    motions: ForwardMotions
    assembly: Assembly
    speeds: Values
    springs: Sequence[Springs] | None

    @property
    def turns(self) -> list[tuple[int, ComplexValues]]:
        """Number and rate, on rotating axes, of each part of a motion."""
        if self.springs is None:
            return [(0, np.zeros_like(self.speeds, complex))]
        turning = 1j * self.speeds.astype(np.complex128)
        return [(0, turning), (1, -turning)]

    def vectors(self, eigenvalues: ComplexValues) -> tuple[ComplexValues, ComplexValues]:
        """Return right and left eigenvectors, shape (whirl, part, n), by inverse iteration."""
        n, parts = self.motions.size, len(self.turns)
        one = np.eye(n)
        matrix = np.zeros((self.speeds.size, parts * n, parts * n), complex)
        resisted = self.motions.damping_at(self.speeds)
        resisted = resisted + self.speeds[:, None, None] * self.motions.gyroscopic
        for part, rate in self.turns:
            s = (eigenvalues + rate)[:, None, None]
            stiffness, drag = self.motions.stiffness_at(self.speeds), resisted
            if part:
                stiffness, drag = stiffness.conj(), drag.conj()
            place = slice(part * n, (part + 1) * n)
            matrix[:, place, place] = stiffness + s * drag + s * s * one
        for each in self.springs or ():
            row = each.direction.conj()[:, None] * self.motions.rows[each.number]
            rows = np.stack([row, row.conj()], axis=1)
            tied = _tied(each, eigenvalues)
            for i in (0, 1):
                for j in (0, 1):
                    matrix[:, i * n : (i + 1) * n, j * n : (j + 1) * n] += (
                        tied[:, i, j, None, None]
                        * rows[:, i].conj()[:, :, None] * rows[:, j][:, None, :]
                    )  # fmt: skip
        shape = (self.speeds.size, parts, n)
        adjoint = np.ascontiguousarray(matrix.conj().transpose(0, 2, 1))
        return _null_vectors(matrix).reshape(shape), _null_vectors(adjoint).reshape(shape)

    def product(
        self, eigenvalues: ComplexValues, x: ComplexValues, y: ComplexValues, *, slope: bool = False
    ) -> ComplexValues:
        """Return ``y' P x`` of each whirl, or ``y' P' x``."""
        assembly, total = self.assembly, np.zeros(self.speeds.size, complex)
        shapes = self.motions.shapes
        seen, left = [], []
        for part, rate in self.turns:
            s, shape = eigenvalues + rate, shapes.conj() if part else shapes
            right, other = shape @ x[:, part].T, (shape @ y[:, part].T).conj()
            drag = np.zeros_like(right)
            if assembly.damping is not None:
                drag += assembly.damping @ right
            drag += assembly.films.product("damping", self.speeds, right)
            if assembly.gyroscopic is not None:
                drag += self.speeds * (assembly.gyroscopic @ right)
            inert = assembly.mass @ right
            if slope:
                moved = drag + 2.0 * s * inert
            else:
                moved = exact_product(assembly.stiffness, right) + s * drag + s * s * inert
                moved += assembly.films.product("stiffness", self.speeds, right)
            total += (other * moved).sum(axis=0)
            rows = (assembly.rows[:, 0] + 1j * assembly.rows[:, 1]) / np.sqrt(2.0)
            rows = rows.conj() if part else rows
            seen.append(rows @ right)
            left.append(rows.conj() @ other)
        for each in self.springs or ():
            turn = [each.direction.conj(), each.direction]
            tied = _tied(each, eigenvalues, slope=slope)
            for i in (0, 1):
                for j in (0, 1):
                    total += (tied[:, i, j] * left[i][each.number] * turn[i].conj()
                              * seen[j][each.number] * turn[j])  # fmt: skip
        return total


def _null_vectors(matrices: ComplexValues) -> ComplexValues:
    """Return what almost singular matrices take to almost 0, by two inverse iterations."""
    vectors = np.ones((*matrices.shape[:2], 1), complex)
    for _ in range(2):
        vectors = np.linalg.solve(matrices, vectors)
        vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors


def _tied(each: Springs, eigenvalues: ComplexValues, *, slope: bool = False) -> ComplexValues:
    """Return how a contact ties the parts of a motion, or its slope, shape (whirl, 2, 2)."""
    radial = each.drag + 0j if slope else each.radial + each.drag * eigenvalues
    across = np.zeros_like(each.across) if slope else each.across
    found = np.empty((eigenvalues.size, 2, 2), complex)
    for i, sign in ((0, 1.0), (1, -1.0)):
        pushed = 0.5 * (1.0 + 1j * sign * each.sliding)
        found[:, i, i] = pushed * (radial + across)
        found[:, i, 1 - i] = pushed * (radial - across)
    return found


def exact_product(matrix: Values, columns: ComplexValues) -> ComplexValues:
    """Return a real matrix times complex columns, rounded as one sum is.

    Examples
    --------
    >>> exact_product(np.array([[1e16, 1.0, -1e16]]), np.ones((3, 1), complex)).real
    array([[1.]])
    """
    bits = (BITS - int(np.ceil(np.log2(matrix.shape[1])))) // 2
    slices = _slices(matrix, bits, axis=1)
    parts = []
    for each in (columns.real, columns.imag):
        others = _slices(each, bits, axis=0)
        # the smallest products first
        pairs = sorted(((i, j) for i in range(len(slices)) for j in range(len(others))),
                       key=lambda pair: -sum(pair))  # fmt: skip
        total = np.zeros((len(matrix), each.shape[1]))
        for i, j in pairs:
            total += slices[i] @ others[j]
        parts.append(total)
    return np.asarray(parts[0] + 1j * parts[1])


def _slices(values: Values, bits: int, axis: int) -> list[Values]:
    """Return numbers whose sum is `values`, of so few bits that sums of products are exact."""
    found, rest = [], values
    for _ in range(SLICES - 1):
        largest = np.abs(rest).max(axis=axis, keepdims=True)
        shift = 1.5 * np.ldexp(1.0, np.frexp(largest)[1] + (BITS - bits - 1))
        high = (rest + shift) - shift
        found.append(high)
        rest = rest - high
    return [*found, rest]
