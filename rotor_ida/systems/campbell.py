"""Eigenvalues of a rotor system over its speed: whirl speeds, damping, forward and backward."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import xarray as xr
from scipy.optimize import brentq

from rotor_ida.arrays import Column, ComplexValues, Values
from rotor_ida.checks import check_axis, check_count
from rotor_ida.errors import InputError
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import Contact
from rotor_ida.schema import WHIRL_DIRECTION, labelled_dataset
from rotor_ida.systems.archived import described_problem
from rotor_ida.systems.assembly import Assembly, assemble, canonical
from rotor_ida.systems.axisymmetric import check_masses, forward_motions
from rotor_ida.systems.receptances import checked_speeds
from rotor_ida.systems.units import with_system_units

# A motion whose displacements at all nodes are below this part of the largest moves none.
STILL = 1e-9
# Forward and backward parts of a motion that differ by less are equal: it is along a line.
STRAIGHT = 1e-6
# Singular values below this part of the largest are 0: a motion that no stiffness holds.
SINGULAR = 1e-11
# Growth and decay below this part of the largest eigenvalue come from rounding.
ROUNDING = 100.0 * np.finfo(float).eps
# A whirl speed is the spin speed to this part of it.
CROSSED = 1e-6


class _Motions(NamedTuple):
    """Eigenvalues on fixed axes, and which way each motion whirls: 1, -1 or 0."""

    eigenvalues: ComplexValues
    senses: npt.NDArray[np.int8]


def campbell(
    system: RotorSystem,
    *,
    speed: npt.ArrayLike,
    contacts: Sequence[Contact] = (),
    contact_stiffness: npt.ArrayLike = 0.0,
    modes: int | None = None,
) -> xr.Dataset:
    """Compute the eigenvalues of a rotor system over its speed, for a Campbell diagram.

    Parameters
    ----------
    system : RotorSystem
        The rotor. It need not be axisymmetric.
    speed : float or sequence of float, shape (n,)
        Spin speeds.
    contacts : sequence of Contact
        Contacts at which springs stand for a rub; a stator that moves joins the system.
    contact_stiffness : float or sequence of float, shape (k,)
        Stiffnesses of these springs: 0 where the contacts are open, and large where they are
        closed. A rub of indentation d has ``k d**(n - 1)`` across and n times that along the force.
    modes : int, optional
        Number of eigenvalues to keep, the slowest first. Default: all that move a node.

    Returns
    -------
    Dataset
        On ``(contact_stiffness, speed, eigenvalue)``: ``whirl_speed``, negative if the motion is
        backward, ``damping_ratio``, negative if it grows, and ``whirl_sense``; in order of the size
        of the whirl speed, padded with NaN. On ``critical``, where a whirl speed is the spin speed
        in size, between neighbouring speeds from 0 on: ``critical_speed``, ``critical_stiffness``
        of the contacts, ``critical_damping_ratio`` and ``critical_sense``. Unbalance excites the
        forward ones; the others only if the system is not axisymmetric.

    Raises
    ------
    InputError
        If an argument cannot be used.

    Notes
    -----
    The eigenvalues L of ``M q'' + (C + Omega G) q' + K q = 0``: whirl speed ``Im L``, damping ratio
    ``-Re L/|L|``. In an axisymmetric system each motion is a circle, forward or backward. Otherwise
    it is an ellipse, and its sense that of the larger of its two circles, summed over the nodes.

    References
    ----------
    M. I. Friswell et al., "Dynamics of Rotating Machines", Cambridge University Press, 2010,
    chapter 3.

    Examples
    --------
    >>> disc = RotorSystem(mass=np.diag([1.0, 1.0, 0.5, 0.5]), stiffness=np.diag([4, 4, 8, 8]),
    ...                    gyroscopic=np.diag([0.0, 0, 1], 1) - np.diag([0.0, 0, 1], -1),
    ...                    nodes={"disc": [[1, 0, 0.2, 0], [0, 1, 0, 0.2]]}, units="1")
    >>> campbell(disc, speed=[0.0, 1.0]).whirl_speed.values.squeeze().round(4)
    array([[-2.    ,  2.    , -4.    ,  4.    ],
           [-2.    ,  2.    , -3.1231,  5.1231]])
    """
    speeds = checked_speeds(speed)
    springs = _springs(contact_stiffness, contacts)
    assembly = assemble(system, contacts, [], None, None)
    most = None if modes is None else check_count("modes", modes, maximum=2 * assembly.size)
    motions_at = cache(_motions(assembly))  # asked again about critical speeds
    found = [motions_at(spring, omega) for spring in springs for omega in speeds]
    widest = max(each.senses.size for each in found)
    shape = (springs.size, speeds.size, min(widest, most or widest))
    whirl, damping = np.full((2, *shape), np.nan)
    senses = np.zeros(shape, np.int8)
    rows = [np.unravel_index(number, shape[:2]) for number in range(len(found))]
    for row, each in zip(rows, found, strict=True):
        turning = np.abs(each.eigenvalues.imag)
        order = np.lexsort((each.senses, np.round(turning / turning.max(initial=1e-300), 9)))
        order = order[: shape[2]]
        size = np.abs(each.eigenvalues[order])
        ratio = np.divide(-each.eigenvalues[order].real, size, out=np.zeros_like(size),
                          where=size > 0.0)  # fmt: skip
        whirl[row][: order.size] = turning[order] * np.where(each.senses[order] < 0, -1.0, 1.0)
        damping[row][: order.size] = ratio + 0.0
        senses[row][: order.size] = each.senses[order]
    along = ("contact_stiffness", "speed", "eigenvalue")
    variables: dict[str, Column] = {
        "whirl_speed": (along, whirl + 0.0), "damping_ratio": (along, damping),
        "whirl_sense": (along, senses), **described_problem(assembly, []),
        **_critical(motions_at, springs, np.sort(speeds[speeds >= 0.0])),
    }  # fmt: skip
    coordinates: dict[str, Column] = {
        "contact_stiffness": ("contact_stiffness", springs), "speed": ("speed", speeds),
        "eigenvalue": ("eigenvalue", np.arange(shape[2])),
        "node": ("node", np.array(list(system.nodes), str)),
    }  # fmt: skip
    told: dict[str, object] = {"source": "rotor_ida closed forms"}
    if most is not None:
        told["modes"] = most
    dataset = labelled_dataset(
        "Eigenvalues of a rotor system", variables, coordinates, told, kind="campbell"
    )
    if system.units == "SI":
        for name in ("contact_stiffness", "critical_stiffness"):
            dataset[name].attrs["units"] = "N m-1"
    return with_system_units(dataset, system)


def _critical(
    motions_at: Callable[[float, float], _Motions], springs: Values, speeds: Values
) -> dict[str, Column]:
    """Return the speeds at which a motion whirls with the spin speed, as variables."""
    found = [
        (spring, sense, *each)
        for spring in springs.tolist()
        for sense in WHIRL_DIRECTION.values()
        for each in _crossings(partial(motions_at, spring), sense, speeds.tolist())
    ]
    rows = np.array(sorted(found, key=lambda row: (row[0], row[2]))).reshape(-1, 4)
    return {
        "critical_speed": ("critical", rows[:, 2]),
        "critical_stiffness": ("critical", rows[:, 0]),
        "critical_damping_ratio": ("critical", rows[:, 3]),
        "critical_sense": ("critical", rows[:, 1].astype(np.int8)),
    }


def _crossings(
    motions_at: Callable[[float], _Motions], sense: int, speeds: Sequence[float]
) -> Iterator[tuple[float, float]]:
    """Yield speeds that are whirl speeds of one sense, with the damping ratios."""

    def motions(omega: float) -> ComplexValues:
        found = motions_at(omega)
        own = found.eigenvalues[found.senses == sense]
        return np.asarray(own[np.argsort(np.abs(own.imag), kind="stable")])

    def gap(omega: float, number: int) -> float:
        own = motions(omega)  # what has ceased to whirl has no whirl speed
        return (float(abs(own[number].imag)) if number < own.size else 0.0) - omega

    for low, high in pairwise(speeds):
        before, behind = (np.abs(motions(each).imag) - each for each in (low, high))
        if before.size != behind.size:
            continue  # a motion ceases to whirl
        for number in np.flatnonzero((before > 0.0) != (behind > 0.0)).tolist():
            speed = float(brentq(gap, low, high, args=(number,), xtol=1e-12 * high))
            if abs(gap(speed, number)) > CROSSED * speed:
                continue  # its whirl speed jumps across the spin speed
            here = motions(speed)[number]
            yield speed, float(-here.real / abs(here))


def _springs(given: object, contacts: Sequence[Contact]) -> Values:
    """Return the stiffnesses at the contacts, which must exist for any but 0."""
    springs = check_axis("contact_stiffness", given)
    if springs.any() and not contacts:
        raise InputError(
            f"contact_stiffness must be 0 without contacts, got {float(springs.max())!r}"
        )
    return springs


def _motions(assembly: Assembly) -> Callable[[float, float], _Motions]:
    """Return a function of the contacts' stiffness and the speed that gives the motions."""
    check_masses(assembly)
    try:
        axisymmetric = forward_motions(assembly)
    except InputError:
        return _ellipses(assembly)

    def circles(spring: float, omega: float) -> _Motions:
        rows = axisymmetric.rows
        stiffness = axisymmetric.stiffness + spring * (rows.conj().T @ rows)
        resisted = axisymmetric.damping + omega * axisymmetric.gyroscopic
        found = _exact(np.linalg.eigvals(_first_order(stiffness, resisted)), stiffness, resisted)
        return _Motions(found, np.sign(found.imag).astype(np.int8))

    return circles


def _ellipses(assembly: Assembly) -> Callable[[float, float], _Motions]:
    """Return the same for a system that is not axisymmetric."""
    found = canonical(assembly)
    zero = np.zeros_like(found.stiffness)
    damping = zero if found.damping is None else found.damping
    gyroscopic = zero if found.gyroscopic is None else found.gyroscopic
    nodes = np.concatenate([found.rows_in_y(assembly.node_rows()), found.rows])
    held = found.rows.reshape(-1, assembly.size)

    def ellipses(spring: float, omega: float) -> _Motions:
        stiffness = found.stiffness + spring * (held.T @ held)
        resisted = damping + omega * gyroscopic
        eigenvalues, vectors = np.linalg.eig(_first_order(stiffness, resisted))
        eigenvalues = _exact(eigenvalues, stiffness, resisted)
        moved = np.einsum("njk,ks->njs", nodes, vectors[: assembly.size])
        size = np.linalg.norm(vectors[: assembly.size], axis=0)
        seen = np.abs(moved).max(axis=(0, 1), initial=0.0) > STILL * size
        seen = (seen | (len(nodes) == 0)) & (eigenvalues.imag >= 0.0)
        forward, backward = (
            (np.abs(moved[:, 0] + sign * moved[:, 1]) ** 2).sum(axis=0) for sign in (1j, -1j)
        )
        whirls = np.abs(forward - backward) > STRAIGHT * (forward + backward)
        senses = np.where(whirls & (eigenvalues.imag > 0.0), np.sign(forward - backward), 0.0)
        return _Motions(eigenvalues[seen], senses[seen].astype(np.int8))

    return ellipses


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


def _first_order(stiffness: npt.NDArray[Any], damping: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Return the matrix of ``(p, p')`` for ``p'' + C p' + K p = 0``."""
    one = np.eye(len(stiffness))
    return np.block([[np.zeros_like(one), one], [-stiffness, -damping]])
