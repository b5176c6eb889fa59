"""Derivatives of a motion by its initial state and by a machine's parameters.

Along a known motion, a small difference ``w = (x, y, vx, vy)`` obeys ``w' = A w + b``. A is the
derivative of the accelerations by the state and b that by a parameter [1]_; both follow from the
model by forward differentiation. The contact force is zero at entry and exit, so w does not jump
there. But A has kinks: so panels end at the events, and shrink towards them on the side of the
contact, where a Hertz stiffness varies with the root of the time. In each panel the linear
equation is solved by Gauss collocation at three nodes, of order six [2]_.

References
----------
.. [1] R. I. Leine and H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems",
   Springer, 2004, chapter 7.
.. [2] E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations I",
   Springer, 1993, section II.7.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.fitting.identifiability import ANGLE
from rotor_ida.model.contact import damped, drag_of, slope_of_root, spring_of_root
from rotor_ida.model.forces import Moment, accelerations
from rotor_ida.model.parameters import OF_MACHINE, OF_ROTOR
from rotor_ida.model.rotor import DimensionalRotor
from rotor_ida.model.symbols import Dual, variables

# Gauss's nodes, weights and coefficients on (0, 1), Hairer and others 1993, table II.7.4.
_ROOT = math.sqrt(15.0)
NODES = np.array([0.5 - _ROOT / 10.0, 0.5, 0.5 + _ROOT / 10.0])
WEIGHTS = np.array([5.0, 8.0, 5.0]) / 18.0
COEFFICIENTS = np.array(
    [
        [5.0 / 36.0, 2.0 / 9.0 - _ROOT / 15.0, 5.0 / 36.0 - _ROOT / 30.0],
        [5.0 / 36.0 + _ROOT / 24.0, 2.0 / 9.0, 5.0 / 36.0 - _ROOT / 24.0],
        [5.0 / 36.0 + _ROOT / 30.0, 2.0 / 9.0 + _ROOT / 15.0, 5.0 / 36.0],
    ]
)
# The same twice, as the rates of displacements are velocities; and the weights of both.
SQUARED = COEFFICIENTS @ COEFFICIENTS
MEANS = np.array([WEIGHTS @ COEFFICIENTS, WEIGHTS])
# Radians of the fastest motion in a panel; and how often those beside an event are halved.
LONGEST = 0.35
HALVINGS = 14
# Panels that are solved at once.
AT_ONCE = 4096


@dataclass(frozen=True)
class Moments:
    """A motion at some moments.

    Parameters
    ----------
    z, v : ndarray of complex, shape (n,)
        Displacement ``x + i y`` and velocity [m, m/s].
    pull : ndarray of complex, shape (n,)
        ``(theta'**2 - i theta'') exp(i theta)``, the unbalance's pull on mass and eccentricity.
    pushes : ndarray, shape (n,)
        1 where the surfaces press on each other, else 0; from the events, to avoid rounding.
    slides : ndarray, shape (n,)
        Direction of sliding, 1 or -1; 0 without friction.
    """

    z: ComplexValues
    v: ComplexValues
    pull: ComplexValues
    pushes: Values
    slides: Values


def slopes_of(
    machine: DimensionalRotor, at: Moments, names: Sequence[str]
) -> tuple[Values, Values]:
    """Return the derivatives of the accelerations by the state and by parameters.

    Returns
    -------
    by_state : ndarray, shape (n, 2, 4)
        Derivatives of ``(ax, ay)`` by ``(x, y, vx, vy)``.
    by_parameter : ndarray, shape (n, 2, k)
        Derivatives by each of the names: parameters of the machine, or ``unbalance_angle``.
    """
    columns = 4 + len(names)
    slopes = np.empty((2, columns, at.z.size))
    for row, acceleration in zip(slopes, _accelerations_of(machine, at, names), strict=True):
        for column, part in zip(row, acceleration.parts, strict=True):
            column[:] = part
    turned = np.ascontiguousarray(np.moveaxis(slopes, -1, 0))
    return turned[:, :, :4], turned[:, :, 4:]


def _accelerations_of(
    machine: DimensionalRotor, at: Moments, names: Sequence[str]
) -> tuple[Dual, Dual]:
    """Return both accelerations, with their derivatives by the state and by the names.

    The model holds in SI units as well, with all forces over the mass.
    """
    values = {name: getattr(machine, name) for name in OF_MACHINE} | {ANGLE: 0.0}
    state = [at.z.real, at.z.imag, at.v.real, at.v.imag]
    x, y, vx, vy, *varied = variables([*state, *(values[name] for name in names)])
    values |= zip(names, varied, strict=True)
    rotor = _over_mass(values, at)
    # on the axis there is no direction, and none is needed
    radius = (x * x + y * y + np.finfo(float).tiny) ** 0.5
    outwards = x / radius, y / radius
    depth = radius - rotor.delta0
    q = np.sqrt(np.maximum(depth.value, 0.0) * at.pushes)
    spring = spring_of_root(q, rotor) + slope_of_root(q, rotor) * Dual(0.0, depth.parts)
    push = damped(spring, outwards[0] * vx + outwards[1] * vy, rotor)
    ahead, pull = values[ANGLE], at.pull
    unbalance = (
        values["eccentricity"] * (pull.real - ahead * pull.imag),
        values["eccentricity"] * (pull.imag + ahead * pull.real),
    )
    here = Moment((x, y), (vx, vy), outwards, unbalance, (0.0, -1.0))
    return accelerations(here, push, rotor, drag_of(push, rotor))


def _over_mass(values: Mapping[str, Any], at: Moments) -> SimpleNamespace:
    """Return the model's rotor from the values of a machine, forces divided by the mass."""
    mass = values["mass"]
    given = {
        name: values[name] / mass if parameter.unit.startswith("N") else values[name]
        for name, parameter in OF_MACHINE.items()
        if name in OF_ROTOR
    }
    stiffness, hertz = values["contact_stiffness"] / mass, values["contact_exponent"] > 1.0
    return SimpleNamespace(
        **given, omega=1.0, zeta=0.5 * values["damping"] / mass, delta0=values["clearance"],
        hertz=stiffness if hertz else 0.0, linear=0.0 if hertz else stiffness,
        loose=1.0 - at.pushes, sigma=at.slides,
    )  # fmt: skip


def panels_of(
    ends: Values, pushes: Values, longest: tuple[float, float], *, hertz: bool
) -> tuple[Values, npt.NDArray[np.intp]]:
    """Return the ends of panels, and the stretch between events in which each lies.

    Parameters
    ----------
    ends : ndarray, shape (m + 1,)
        Ends of the stretches [s].
    pushes : ndarray, shape (m,)
        Whether the surfaces press in each.
    longest : tuple of float
        Longest panel in flight, and in contact [s].
    hertz : bool
        Whether the stiffness varies with the root of the indentation.
    """
    parts, stretch = [ends[:1]], []
    halves = 0.5 ** np.arange(HALVINGS, 0.0, -1.0)
    for number, (begin, end) in enumerate(pairwise(ends.tolist())):
        presses = bool(pushes[number])
        count = max(2, math.ceil((end - begin) / longest[presses]))
        inner = begin + (end - begin) * np.arange(1, count) / count
        if presses and hertz:
            first = (end - begin) / count
            inner = np.concatenate([begin + first * halves, inner, end - first * halves[::-1]])
        part = np.append(inner, end)
        parts.append(part)
        stretch.append(np.full(part.size, number))
    return np.concatenate(parts), np.concatenate(stretch)


def panel_count(
    ends: Values, pushes: Values, longest: tuple[float, float], *, hertz: bool
) -> float:
    """Return how many panels `panels_of` makes, nearly."""
    counts = np.maximum(np.diff(ends) / np.where(pushes, longest[1], longest[0]), 2.0)
    return float(counts.sum() + 2.0 * HALVINGS * hertz * pushes.sum())


def nodes_of(ends: Values) -> Values:
    """Return the nodes in panels, shape (panels, 3)."""
    return np.asarray(ends[:-1, None] + np.diff(ends)[:, None] * NODES)


def grown(ends: Values, by_state: Values, added: Values) -> Values:
    """Return the derivatives of the state at the ends of panels.

    Parameters
    ----------
    ends : ndarray, shape (p + 1,)
        Ends of the panels [s].
    by_state, added : ndarray, shape (p, 3, 2, 4) and (p, 3, 2, k)
        Derivatives from `slopes_of` at the nodes.

    Returns
    -------
    ndarray, shape (p + 1, 4, 4 + k)
        Derivatives by the state at the first end, and by each parameter.
    """
    panels, columns = len(by_state), 4 + added.shape[-1]
    # neighbouring panels in blocks: all blocks grow from their first ends at once, then in turn
    length = math.isqrt(panels - 1) + 1
    blocks = -(-panels // length)
    across = np.zeros((blocks * length, 4, columns))
    steps = np.diff(ends)
    for first in range(0, panels, AT_ONCE):
        part = slice(first, min(first + AT_ONCE, panels))
        across[part] = _across(steps[part], by_state[part], added[part])
    across = across.reshape(blocks, length, 4, columns)
    inside, now = np.empty_like(across), np.eye(4, columns)[None]
    for number in range(length):
        now = now + across[:, number, :, :4] @ now
        now[:, :, 4:] += across[:, number, :, 4:]
        inside[:, number] = now
    found = np.empty((blocks * length + 1, 4, columns))
    found[0] = begin = np.eye(4, columns)
    for each, block in zip(inside, found[1:].reshape(inside.shape), strict=True):
        np.matmul(each[:, :, :4], begin, out=block)
        block[:, :, 4:] += each[:, :, 4:]
        begin = block[-1]
    return found[: panels + 1]


def _across(steps: Values, by_state: Values, added: Values) -> Values:
    """Return the change of a difference over each panel, and its forcing: (p, 4, 4 + k).

    The rates of the displacements are velocities, so only those of the velocities are solved for.
    """
    h = steps[:, None, None, None, None]
    by_place, by_speed = by_state[:, :, :, :2], by_state[:, :, :, 2:]
    matrix = np.eye(6).reshape(3, 2, 3, 2) - h * (
        h * SQUARED[:, None, :, None] * by_place[:, :, :, None]
        + COEFFICIENTS[:, None, :, None] * by_speed[:, :, :, None]
    )
    later = h[..., 0] * NODES[:, None, None] * by_place + by_speed
    right = np.concatenate([by_place, later, added], axis=-1)
    rates = np.linalg.solve(matrix.reshape(-1, 6, 6), right.reshape(steps.size, 6, -1))
    change = MEANS @ rates.reshape(steps.size, 3, -1) * h[..., 0, 0]
    change = change.reshape(steps.size, 4, -1)
    change[:, :2] *= h[..., 0, 0]
    change[:, [0, 1], [2, 3]] += steps[:, None]
    return np.asarray(change)


def between(
    ends: Values, grown_to: Values, rates: tuple[Values, Values], times: Values
) -> ComplexValues:
    """Return the derivatives of ``x + i y`` at times, shape (n, 4 + k), by quintic interpolation.

    `rates` are those of the velocities at the beginning and at the end of each panel,
    shape (p, 2, 4 + k).
    """
    panel = np.clip(np.searchsorted(ends, times, side="right") - 1, 0, ends.size - 2)
    step = np.diff(ends)[panel]
    s = (times - ends[panel]) / step
    place, speed = (grown_to[:, row] + 1j * grown_to[:, row + 1] for row in (0, 2))
    faster = [each[:, 0] + 1j * each[:, 1] for each in rates]
    s3 = s**3
    weights = (
        1.0 - s3 * (10.0 - 15.0 * s + 6.0 * s**2),
        step * (s - s3 * (6.0 - 8.0 * s + 3.0 * s**2)),
        0.5 * step**2 * (s**2 - s3 * (3.0 - 3.0 * s + s**2)),
        s3 * (10.0 - 15.0 * s + 6.0 * s**2),
        -step * s3 * (4.0 - 7.0 * s + 3.0 * s**2),
        0.5 * step**2 * s3 * (1.0 - 2.0 * s + s**2),
    )
    terms = (
        place[panel], speed[panel], faster[0][panel],
        place[panel + 1], speed[panel + 1], faster[1][panel],
    )  # fmt: skip
    total = np.zeros((times.size, grown_to.shape[-1]), dtype=np.complex128)
    for weight, term in zip(weights, terms, strict=True):
        total += weight[:, None] * term
    return total
