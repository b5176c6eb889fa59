"""Eigenvalues of a rotor system over its speed: whirl speeds, damping, forward and backward."""

from __future__ import annotations

from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, Values
from rotor_ida.checks import check_axis, check_count, check_distinct
from rotor_ida.closed_forms.linear_motions import (
    LinearMotions,
    Motions,
    critical_speeds,
    linear_motions,
)
from rotor_ida.closed_forms.receptances import checked_speeds
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.growth_words import growth_over_speeds
from rotor_ida.results.in_si import takes_system
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import labelled_dataset

# A motion whirls if it turns by more than this part of its rate: what turns less is rounding.
WHIRLS = 1e-9


@takes_system
def campbell(
    system: RotorSystem,
    *,
    speed: npt.ArrayLike,
    contact_stiffness: npt.ArrayLike = 0.0,
    modes: int | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute the eigenvalues of a rotor system over its speed, for a Campbell diagram.

    Parameters
    ----------
    system : RotorSystem, Rotor or DimensionalRotor
        The rotor. It need not be axisymmetric. A stator of a contact that moves joins it.
    speed : float or sequence of float, shape (n,)
        Spin speeds.
    contact_stiffness : float or sequence of float, shape (k,)
        Stiffnesses of springs at the contacts, which stand for a rub: 0 where they are open, and
        large where they are closed. A rub of indentation d has ``k d**(n - 1)`` across and n times
        that along the force.
    modes : int, optional
        Number of eigenvalues to keep, the slowest first, without overdamped motions, which decay
        without whirling. Default: all that move a node.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        On ``(contact_stiffness, speed, eigenvalue)``: ``whirl_speed``, negative if the motion is
        backward, ``damping_ratio``, negative if it grows, and ``whirl_sense``; in order of the size
        of the whirl speed, padded with NaN. On ``critical``, wherever a whirl speed is the spin
        speed in size between the lowest and the highest speed, but for 0: ``critical_speed``,
        ``critical_stiffness`` of the contacts, ``critical_damping_ratio`` and ``critical_sense``.
        Unbalance excites the forward ones; the others only if the system is not axisymmetric.
        The attribute ``unstable_speeds`` has the ends of the ranges in which it grows without
        contact, in pairs.

    Raises
    ------
    InputError
        If an argument cannot be used.

    Notes
    -----
    The eigenvalues L of ``M q'' + (C + Omega G) q' + K q = 0``: whirl speed ``Im L``, damping ratio
    ``-Re L/|L|``. In an axisymmetric system each motion is a circle, forward or backward. Otherwise
    it is an ellipse, and its sense that of the larger of its two circles, summed over the nodes.
    Forward is the sense of the spin; at rest, that from x to y. Axes whose stiffness differs by
    less than about 1e-7 count as equal: two eigenvalues that differ by half of that are then told
    as those of one circle forward and one backward, at their mean.

    At a critical speed W an eigenvalue is ``-d + i W`` in a damped system too, at the spin speed W.
    How many speeds are given does not matter to them: see `rotor_ida.closed_forms.crossings`.

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
    system = changed_system(campbell, system, changed)
    speeds = check_distinct("speed", checked_speeds(speed))
    springs = _springs(contact_stiffness, system)
    assembly = assemble(system, speeds=speeds)
    most = None if modes is None else check_count("modes", modes, maximum=2 * assembly.size)
    motions = linear_motions(assembly)
    found = [
        _seen(motions.at(spring, omega), whirling=most is not None)
        for spring in springs for omega in speeds
    ]  # fmt: skip
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
        "whirl_sense": (along, senses), **described_problem(assembly),
        **_critical(motions, springs, speeds),
    }  # fmt: skip
    coordinates: dict[str, Column] = {
        "contact_stiffness": ("contact_stiffness", springs), "speed": ("speed", speeds),
        "eigenvalue": ("eigenvalue", np.arange(shape[2])),
        "node": ("node", np.array(list(system.nodes), str)),
    }  # fmt: skip
    told: dict[str, object] = {"source": "rotor_ida closed forms"}
    told |= growth_over_speeds(assembly, speeds)
    if most is not None:
        told["modes"] = most
    dataset = labelled_dataset(
        "Eigenvalues of a rotor system", variables, coordinates, told, kind="campbell"
    )
    return with_system_units(dataset, system)


def _critical(motions: LinearMotions, springs: Values, speeds: Values) -> dict[str, Column]:
    """Return the critical speeds between the lowest and the highest speed, as variables."""
    found = sorted(
        (spring, *each)
        for spring in springs.tolist()
        for each in critical_speeds(motions, spring, float(speeds.min()), float(speeds.max()))
    )
    rows = np.array(found).reshape(-1, 4)
    return {
        "critical_speed": ("critical", rows[:, 1]),
        "critical_stiffness": ("critical", rows[:, 0]),
        "critical_damping_ratio": ("critical", rows[:, 3]),
        "critical_sense": ("critical", rows[:, 2].astype(np.int8)),
    }


def _seen(motions: Motions, *, whirling: bool) -> Motions:
    """Return the motions that move a node; without those that decay without whirling, if asked."""
    seen = motions.seen
    if whirling:
        found = motions.eigenvalues
        seen = seen & ((np.abs(found.imag) > WHIRLS * np.abs(found)) | (found.real >= 0.0))
    return Motions(motions.eigenvalues[seen], motions.senses[seen], seen[seen])


def _springs(given: object, system: RotorSystem) -> Values:
    """Return the stiffnesses at the contacts, which must exist for any but 0."""
    springs = check_axis("contact_stiffness", given)
    if springs.any() and not system.contacts:
        raise InputError(
            "{name} must be 0 without contacts, got {value}",
            name="contact_stiffness", value=float(springs.max()),
        )  # fmt: skip
    return springs
