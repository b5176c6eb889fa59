"""Whether the motion of a rotor system without contact grows, and whether anything holds it."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from rotor_ida.arrays import ComplexValues, Values
from rotor_ida.model.assembly import Canonical

# Relative size below which an eigenvalue is that of a free motion.
FREE = 1e-9
# Error of an eigenvalue, as a part of the largest and of the norm of the stiffness over its size.
# It spreads a double 0, of a rotor that nothing holds, to growth and decay of just such a size.
ROUNDING = 50.0 * np.finfo(float).eps
# Steps in which the speed falls where growth is followed to its beginning, and how near to that
# where no sign of the growth rate tells it.
STEPS, PLACED = 16, 1e-13
# Speeds at which ranges of growth are sought.
POINTS = 65


class Growth(NamedTuple):
    """How a motion without contact grows: at which rate, and at which whirl speed."""

    rate: float
    whirl_speed: float


def rates_of(found: Canonical, speed: float) -> ComplexValues:
    """Return the eigenvalues of the motion without contact at a speed."""
    inert = len(found.stiffness) - found.massless
    first_order = np.eye(2 * inert, k=inert)
    stiffness = found.stiffness_at(speed)
    first_order[inert:, :inert] = -stiffness[:inert, :inert]
    first_order[inert:, inert:] -= found.damping_at(speed)[:inert, :inert]
    if found.gyroscopic is not None:
        first_order[inert:, inert:] -= speed * found.gyroscopic[:inert, :inert]
    relaxing = -np.diag(stiffness)[inert:]  # stators without mass
    return np.concatenate([np.linalg.eigvals(first_order), relaxing])


def growth_of(found: Canonical, speed: float) -> Growth | None:
    """Return how the motion without contact grows fastest at a speed; None where it does not."""
    rates, parts = _moving(found, speed)
    growing = rates[parts > 1.0]
    if not growing.size:
        return None
    fastest = growing[np.argmax(growing.real)]
    return Growth(float(fastest.real), float(abs(fastest.imag)))


def _moving(found: Canonical, speed: float) -> tuple[ComplexValues, Values]:
    """Return the eigenvalues, free motions aside, and their real parts over their errors."""
    rates, inert = rates_of(found, speed), len(found.stiffness) - found.massless
    held = np.linalg.norm(found.stiffness_at(speed)[:inert, :inert])
    sizes = np.abs(rates)
    rates = rates[sizes**2 > ROUNDING * (held + sizes.max() * sizes)]
    return rates, rates.real / (ROUNDING * (held / np.abs(rates) + sizes.max()))


def growth_begins(found: Canonical, speed: float) -> float | None:
    """Return from which speed on the motion without contact grows up to a speed at which it does.

    It is sought on films alone, down to the lowest speed of their tables; None if it grows there.
    """
    first = found.films.reach[0]
    high = speed
    for low in np.linspace(speed, first, STEPS + 1)[1:].tolist():
        if growth_of(found, low) is None:
            break
        high = low
    else:
        return None
    return _end_between(found, low, high, True)


def growth_between(found: Canonical, low: float, high: float) -> list[tuple[float, float]]:
    """Return the ranges of speeds between two in which the motion without contact grows.

    Ranges, and gaps between them, that lie between neighbours of `POINTS` speeds are not seen.
    """
    if _only_loses(found):
        return []
    knots = found.films.knots
    inside = knots[(knots > low) & (knots < high)]
    speeds = np.unique(np.concatenate([np.linspace(low, high, POINTS), inside])).tolist()
    grow = [growth_of(found, each) is not None for each in speeds]
    ends = [low] if grow[0] else []
    for (below, above), grows in zip(pairwise(speeds), grow[1:], strict=True):
        if grows != (len(ends) % 2 == 1):
            ends.append(_end_between(found, below, above, grows))
    ends += [high] if len(ends) % 2 else []
    return list(zip(ends[::2], ends[1::2], strict=True))


def _only_loses(found: Canonical) -> bool:
    """Return whether springs and dampers give the motion no energy at any speed, to rounding.

    Of symmetric matrices without negative eigenvalues they do not; gyroscopic moments do no work.
    """
    if found.films:
        return False
    return all(
        np.abs(each - each.T).max() <= ROUNDING * np.linalg.norm(each)
        and np.linalg.eigvalsh(each)[0] >= -ROUNDING * np.linalg.norm(each)
        for each in (found.stiffness, found.damping) if each is not None
    )  # fmt: skip


def _end_between(found: Canonical, low: float, high: float, grows: bool) -> float:
    """Return where growth begins between two speeds, or ends.

    It is where the growth rate is 0; where it does not change its sign, as without damping, a speed
    at which there is growth.
    """

    def growth(speed: float) -> float:
        parts = _moving(found, speed)[1]
        return float(parts.max()) if parts.size else 0.0

    lower, higher = sorted((growth(low), growth(high)))
    if lower < -1.0 and higher > 1.0:
        from scipy.optimize import brentq  # noqa: PLC0415 - takes long to import

        return float(brentq(growth, low, high, xtol=1e-14 * max(abs(low), abs(high))))
    near = PLACED * max(abs(low), abs(high))
    while high - low > near and low < (middle := 0.5 * (low + high)) < high:
        same = (growth(middle) > 1.0) == grows
        low, high = (low, middle) if same else (middle, high)
    return high if grows else low


def nothing_holds(found: Canonical) -> bool:
    """Return whether constant forces move the system where neither supports nor contacts hold it.

    Nothing balances a force f along a motion u that neither bends supports, ``u' K = 0``, nor moves
    a contact, ``B u = 0``.
    """
    if not found.force.any():
        return False
    left, sizes, _ = np.linalg.svd(found.stiffness)
    free = left[:, sizes <= FREE * sizes.max(initial=0.0)]
    _, strengths, shapes = np.linalg.svd(found.rows.reshape(-1, len(free)) @ free)
    rank = int((strengths > FREE * strengths.max(initial=0.0)).sum())
    pushed = (free @ shapes[rank:].T).T @ found.force
    return bool(np.abs(pushed).max(initial=0.0) > FREE * np.linalg.norm(found.force))
