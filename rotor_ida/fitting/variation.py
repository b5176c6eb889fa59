"""How a motion answers to small changes of its start and of a machine's parameters.

Along a motion that is known, a small difference ``w = (x, y, vx, vy)`` obeys ``w' = A w + b``, with
the derivatives A of the accelerations by the state and b by a parameter [1]_. Contact begins and
ends with a force of zero, so nothing is added there; but A has kinks, so panels end at the
events, and shrink towards them on the side of the contact, where a Hertz stiffness goes with the
root of the time. In each panel the equation, which is linear, is solved by Gauss's collocation at
three nodes, of order six [2]_.

References
----------
.. [1] R. I. Leine and H. Nijmeijer, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems",
   Springer, 2004, chapter 7.
.. [2] E. Hairer, S. P. Norsett and G. Wanner, "Solving Ordinary Differential Equations I",
   Springer, 1993, section II.7.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.model.parameters import DimensionalRotor

Complex = npt.NDArray[np.complex128]

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
        1 where the surfaces press on each other, else 0: told by the events, not by rounding.
    slides : ndarray, shape (n,)
        The sense in which they slide, 1 or -1; 0 without friction.
    """

    z: Complex
    v: Complex
    pull: Complex
    pushes: Values
    slides: Values


def slopes_of(
    machine: DimensionalRotor, at: Moments, names: Sequence[str]
) -> tuple[Values, Values]:
    """Return the derivatives of the rates of a state, by the state and by parameters.

    Returns
    -------
    by_state : ndarray, shape (n, 4, 4)
        Of ``(vx, vy, ax, ay)`` by ``(x, y, vx, vy)``.
    by_parameter : ndarray, shape (n, 4, k)
        By each of the names: parameters of the machine, or ``unbalance_angle``.

    Notes
    -----
    ``m z'' = m D pull exp(i alpha) - i L - n z' - k_s z - N (1 + i mu s) z/|z|``, where
    ``N = k d**e (1 + lambda r')`` with the indentation d.
    """
    force = _Force(machine, at)
    mass = machine.mass
    by_z, by_v = force.by_position(), force.by_velocity()
    by_state = np.zeros((at.z.size, 4, 4))
    by_state[:, 0, 2] = by_state[:, 1, 3] = 1.0
    by_state[:, 2:, :2] = -by_z / mass
    by_state[:, 2:, 2:] = -by_v / mass
    for i in range(2):
        by_state[:, 2 + i, i] -= machine.shaft_stiffness / mass
        by_state[:, 2 + i, 2 + i] -= machine.damping / mass
    added = np.zeros((at.z.size, 4, len(names)))
    for column, name in enumerate(names):
        change = force.by_parameter(name)
        added[:, 2, column], added[:, 3, column] = change.real, change.imag
    return by_state, added


class _Force:
    """The contact force at some moments, and what changes it."""

    def __init__(self, machine: DimensionalRotor, at: Moments) -> None:
        self.machine, self.at = machine, at
        self.radius = np.abs(at.z)
        # on the axis a direction is of no use, and none is asked for
        safe = np.where(self.radius > 0.0, self.radius, 1.0)
        self.outward = at.z / safe
        self.around = 1j * self.outward
        along = self.outward.conj() * at.v
        self.rise, self.turning = along.real, along.imag / safe
        depth = np.maximum(self.radius - machine.clearance, 0.0) * at.pushes
        exponent, damping = machine.contact_exponent, machine.contact_damping
        self.spring = machine.contact_stiffness * depth**exponent
        factor = (1.0 + damping * self.rise) * at.pushes
        self.push = self.spring * factor
        self.steepness = machine.contact_stiffness * exponent * depth ** (exponent - 1.0) * factor
        self.over_radius = self.push / safe
        self.direction = self.outward + machine.friction * at.slides * self.around

    def by_position(self) -> Values:
        """Return the derivative by ``(x, y)``, shape (n, 2, 2)."""
        across = self.spring * self.machine.contact_damping * self.turning
        grows = self.steepness * self.outward + across * self.around
        sideways = self.direction * 1j
        return _product(self.direction, grows) + _product(self.over_radius * sideways, self.around)

    def by_velocity(self) -> Values:
        """Return the derivative by ``(vx, vy)``, shape (n, 2, 2)."""
        return _product(self.direction, self.spring * self.machine.contact_damping * self.outward)

    def by_parameter(self, name: str) -> Complex:
        """Return the derivative of the acceleration by a parameter, shape (n,)."""
        machine, at, contact = self.machine, self.at, self.push * self.direction
        changes: dict[str, Callable[[], Complex]] = {
            "mass": lambda: (machine.damping * at.v + machine.shaft_stiffness * at.z + contact
                             + 1j * machine.load) / machine.mass,
            "damping": lambda: -at.v,
            "shaft_stiffness": lambda: -at.z,
            "contact_stiffness": lambda: -contact / machine.contact_stiffness,
            "clearance": lambda: self.steepness * self.direction,
            "contact_damping": lambda: -self.spring * self.rise * self.direction * at.pushes,
            "load": lambda: np.full(at.z.shape, -1j),
            "friction": lambda: -self.push * at.slides * self.around,
            "eccentricity": lambda: machine.mass * at.pull,
            "unbalance_angle": lambda: 1j * machine.mass * machine.eccentricity * at.pull,
        }  # fmt: skip
        found: Complex = np.asarray(changes[name](), dtype=np.complex128) / machine.mass
        return found


def _product(column: Complex, row: Complex) -> Values:
    """Return the matrices ``column row'`` of plane vectors, shape (n, 2, 2)."""
    found = np.empty((column.size, 2, 2))
    found[:, 0, 0], found[:, 0, 1] = column.real * row.real, column.real * row.imag
    found[:, 1, 0], found[:, 1, 1] = column.imag * row.real, column.imag * row.imag
    return found


def panels_of(
    ends: Values, pushes: Values, longest: tuple[float, float], *, hertz: bool
) -> tuple[Values, npt.NDArray[np.intp]]:
    """Return the ends of panels, and in which stretch between events each lies.

    Parameters
    ----------
    ends : ndarray, shape (m + 1,)
        Where the stretches begin and end [s].
    pushes : ndarray, shape (m,)
        Whether the surfaces press in each.
    longest : tuple of float
        The longest panel in flight, and in contact [s].
    hertz : bool
        Whether the stiffness goes with the root of the indentation.
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


def nodes_of(ends: Values) -> Values:
    """Return the nodes in panels, shape (panels, 3)."""
    return np.asarray(ends[:-1, None] + np.diff(ends)[:, None] * NODES)


def grown(ends: Values, by_state: Values, added: Values) -> Values:
    """Return the derivatives of the state at the ends of panels.

    Parameters
    ----------
    ends : ndarray, shape (p + 1,)
        Ends of the panels [s].
    by_state, added : ndarray, shape (p, 3, 4, 4) and (p, 3, 4, k)
        What `slopes_of` gives at the nodes.

    Returns
    -------
    ndarray, shape (p + 1, 4, 4 + k)
        By the state at the first end, and by each parameter.
    """
    panels, columns = len(by_state), 4 + added.shape[-1]
    found = np.zeros((panels + 1, 4, columns))
    found[0, :, :4] = np.eye(4)
    steps = np.diff(ends)
    for first in range(0, panels, AT_ONCE):
        part = slice(first, min(first + AT_ONCE, panels))
        across = _across(steps[part], by_state[part], added[part])
        now = found[first]
        for number, step in enumerate(across, first + 1):
            now = now + step[:, :4] @ now
            now[:, 4:] += step[:, 4:]
            found[number] = now
    return found


def _across(steps: Values, by_state: Values, added: Values) -> Values:
    """Return by how much each panel changes a difference, and what it adds: (p, 4, 4 + k)."""
    panels = steps.size
    matrix = -np.einsum("p,ij,pikl->pikjl", steps, COEFFICIENTS, by_state)
    matrix = matrix.reshape(panels, 12, 12) + np.eye(12)
    right = np.concatenate([by_state, added], axis=-1).reshape(panels, 12, -1)
    rates = np.linalg.solve(matrix, right).reshape(panels, 3, 4, -1)
    return np.asarray(np.einsum("p,i,pikc->pkc", steps, WEIGHTS, rates), dtype=np.float64)


def between(ends: Values, grown_to: Values, rates: tuple[Values, Values], times: Values) -> Complex:
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
