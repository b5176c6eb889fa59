"""The unbalance response of any linear rotor system: orbits, peaks and critical speeds.

Without contact the motion by unbalance is the real part of ``Q exp(i Omega t)``, so that each node
moves on an ellipse: the sum of a forward circle, of complex radius ``(X + i Y)/2``, and a backward
one, ``conj(X - i Y)/2``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Column, ComplexValues, Values
from rotor_ida.closed_forms.clearances.critical_speeds import (
    Mode,
    critical_modes,
    orbit_axes,
    peak_between,
)
from rotor_ida.closed_forms.clearances.response import about
from rotor_ida.closed_forms.receptances import checked_speeds, solved_motions
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.axisymmetric import no_circles
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_parts import check_clearances
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.growth_words import growth_over_speeds
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import labelled_dataset

# Speeds at which peaks are sought, besides those about each critical speed.
POINTS = 300
# A decay below this part of the speed is none: the response there has no bound.
UNDAMPED = 1e-12
# Angles at which the farthest point of an ellipse is sought, and Newton's steps from the best.
ANGLES, STEPS = 64, 6


def response_of_system(system: RotorSystem, speed: npt.ArrayLike | None) -> xr.Dataset:
    """Return the response of a rotor system to unbalance: see `rotor_ida.synchronous_response`.

    Where the system is axisymmetric, the exact whirls are added.
    """
    speeds = checked_speeds(speed)
    assembly = assemble(system, speeds=speeds)
    check_clearances(assembly.contacts)
    nodes: dict[str, Column] = {"node": ("node", np.array(list(system.nodes), str))}
    variables = linear_response(assembly, speeds) | critical_speeds_of(assembly, speeds)
    growth = growth_over_speeds(assembly, speeds)
    try:
        whirls = whirls_of_system(system, speeds)
    except InputError as error:
        dataset = labelled_dataset(
            "Unbalance response of a rotor system", variables | described_problem(assembly),
            {"speed": ("speed", speeds), **nodes},
            {"source": "rotor_ida closed forms", "not_exact": no_circles(error)}
            | growth,
            kind="unbalance_response",
        )  # fmt: skip
        return with_system_units(dataset, system)
    found = labelled_dataset("", variables, nodes, {}, kind="unbalance_response")
    return whirls.assign(with_system_units(found, system).data_vars).assign_attrs(growth)


def linear_response(assembly: Assembly, speeds: Values) -> dict[str, Column]:
    """Return the orbits of nodes, and the radii at contacts, as variables."""
    unbalance = assembly.unbalance[0] - 1j * assembly.unbalance[1]
    motions = np.zeros((speeds.size, assembly.size), complex)
    turning = np.flatnonzero(speeds)
    motions[turning] = solved_motions(assembly, speeds[turning], unbalance[:, np.newaxis])[:, :, 0]
    motions *= speeds[:, np.newaxis] ** 2
    forward, backward = circles_of(assembly.node_rows(), motions)
    spin, along = np.where(speeds < 0.0, -1.0, 1.0)[:, np.newaxis], ("speed", "node")
    at_contacts = circles_of(assembly.rows, motions)
    centres = _centres(assembly, speeds)
    return {
        "node_major_axis": (along, 2.0 * (np.abs(forward) + np.abs(backward))),
        "node_minor_axis": (along, 2.0 * (np.abs(forward) - np.abs(backward))),
        "node_forward_amplitude": (along, np.abs(forward)),
        "node_forward_phase_lag": (along, -spin * np.angle(forward)),
        "node_backward_amplitude": (along, np.abs(backward)),
        "node_backward_phase_lag": (along, spin * np.angle(backward)),
        "unbalance_radius": (("speed", "contact"), farthest(centres, *at_contacts)),
    }


def circles_of(rows: Values, motions: ComplexValues) -> tuple[ComplexValues, ComplexValues]:
    """Return the forward and backward circles of places, shape (speed, place), in motions."""
    x, y = np.einsum("pjk,sk->jsp", rows, motions)
    return 0.5 * (x + 1j * y), 0.5 * np.conj(x - 1j * y)


def farthest(centres: ComplexValues, forward: ComplexValues, backward: ComplexValues) -> Values:
    """Return the largest size of ``c + f exp(i a) + b exp(-i a)`` over the angles a.

    Examples
    --------
    >>> one = np.ones((1, 1), complex)
    >>> farthest(0.0 * one, 2.0 * one, one).item(), farthest(-3.0 * one, 2.0 * one, one).item()
    (3.0, 6.0)
    """
    angles = np.linspace(0.0, 2.0 * np.pi, ANGLES, endpoint=False)
    turn = np.exp(1j * angles)
    sizes = np.abs(centres[..., np.newaxis] + forward[..., np.newaxis] * turn
                   + backward[..., np.newaxis] / turn)  # fmt: skip
    best = angles[sizes.argmax(axis=-1)] if sizes.size else np.zeros(forward.shape)
    largest = sizes.max(axis=-1, initial=0.0)
    for _ in range(STEPS):
        ahead, back = forward * np.exp(1j * best), backward * np.exp(-1j * best)
        place, rate = centres + ahead + back, 1j * (ahead - back)
        largest = np.maximum(largest, np.abs(place))
        slope = (place.conj() * rate).real
        bend = np.abs(rate) ** 2 - (place.conj() * (ahead + back)).real
        best = best - np.divide(slope, bend, out=np.zeros_like(slope), where=bend < 0.0)
    return np.asarray(largest)


def _centres(assembly: Assembly, speeds: Values) -> ComplexValues:
    """Return the mean displacements of contacts from the centres of their stators."""
    offsets = np.array([complex(*each.centre) for each in assembly.contacts], complex)
    found = np.broadcast_to(-offsets, (speeds.size, offsets.size))
    if not assembly.force.any():
        return found
    stiffness = assembly.stiffness_at(speeds)
    try:
        still = np.linalg.solve(stiffness, assembly.force)
    except np.linalg.LinAlgError as error:
        raise InputError(
            "gravity and static_force must be 0 for a system that its stiffness does not hold "
            "against them, got one with a singular stiffness"
        ) from error
    rows = assembly.rows[:, 0] + 1j * assembly.rows[:, 1]
    return np.asarray(found + still.reshape(-1, assembly.size) @ rows.T)


def critical_speeds_of(assembly: Assembly, speeds: Values) -> dict[str, Column]:
    """Return the critical speeds within a range that unbalance drives, with the peaks of each."""
    low, high = max(float(speeds.min()), 0.0), float(speeds.max())
    modes: list[Mode] = []
    if low < high:
        modes = [each for each in critical_modes(assembly, high) if low <= each.speed <= high]
    peaks = _peaks(assembly, modes, low, high)
    names = np.array([*assembly.system.nodes, ""], str)
    rows = np.array([each[1:] for each in peaks]).reshape(-1, 3)
    ratios = [each.decay / np.hypot(each.speed, each.decay) for each in modes]
    return {
        "critical_speed": ("critical", np.array([each.speed for each in modes])),
        "critical_damping_ratio": ("critical", np.array(ratios)),
        "peak_node": ("critical", names[[each[0] for each in peaks]]),
        **{name: ("critical", column) for name, column in
           zip(("peak_speed", "peak_major_axis", "amplification_factor"), rows.T, strict=True)},
    }  # fmt: skip


def _peaks(
    assembly: Assembly, modes: Sequence[Mode], low: float, high: float
) -> list[tuple[int, float, float, float]]:
    """Return the peak of each mode between its neighbours, at the node that moves most.

    It is the number of the node, speed, axis and amplification factor; -1 and NaN without a peak,
    and -1 and infinite where nothing damps the mode.
    """
    if not modes:
        return []
    undamped = np.array([each.decay <= UNDAMPED * each.speed for each in modes])
    poles = np.array([each.speed for each in modes])[undamped]
    grid = np.concatenate([np.linspace(low, high, POINTS), about(modes)])
    grid = np.unique(grid[(grid > 0.0) & (grid >= low) & (grid <= high)])
    apart = np.abs(grid[:, np.newaxis] - poles).min(axis=1, initial=np.inf)
    grid = grid[apart > UNDAMPED * high]
    rows = assembly.node_rows()
    force = (assembly.unbalance[0] - 1j * assembly.unbalance[1])[:, np.newaxis]
    axes = orbit_axes(assembly, rows, force, grid)[0]
    between = [0.5 * (one.speed + other.speed) for one, other in pairwise(modes)]
    found = []
    for mode, ends in zip(modes, pairwise([grid[0], *between, grid[-1]]), strict=True):
        if mode.speed in poles:
            found.append((-1, mode.speed, np.inf, np.inf))
            continue
        inside = grid[(grid >= ends[0]) & (grid <= ends[1])]
        node = int(axes[np.isin(grid, inside)].max(axis=0).argmax())

        def axis(omega: float, node: int = node) -> float:
            return float(orbit_axes(assembly, rows[[node]], force, np.array([omega]))[0, 0, 0])

        peak = peak_between(axis, grid, axes[:, node], inside[0], inside[-1])
        if peak is None:
            found.append((-1, np.nan, np.nan, np.nan))
        else:
            found.append((node, peak.speed, axis(peak.speed), peak.amplification))
    return found
