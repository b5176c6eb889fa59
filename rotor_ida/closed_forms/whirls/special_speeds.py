"""Speeds at which the motion of a rotor system changes: thresholds, folds, Hopf points, grazes.

1. *Branches* of each set of contacts, followed through their folds along the arc (`branches`).
2. *Folds*: where the speed turns along a branch.
3. *Grazes and Hopf points*: along a branch, where another contact is just touched, and where the
   real part of a pair of eigenvalues vanishes. Pieces of branches are halved where values
   in the middle show that two may undo each other.
4. From each graze, the branch of the larger set of contacts is followed too.
5. *Thresholds* of instability: where the growth of the motion without contact begins or ends.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Column, ComplexValues, Values
from rotor_ida.checks import check_count, check_progress
from rotor_ida.closed_forms.curve_tracing import checked_limits
from rotor_ida.closed_forms.linear_motions import growth_thresholds, linear_motions
from rotor_ida.closed_forms.whirls.at_speeds import MOST_TOUCHING, touching_sets
from rotor_ida.closed_forms.whirls.branches import (
    Branches,
    Curve,
    Piece,
    RubProblem,
    Touching,
    plain_pieces,
)
from rotor_ida.closed_forms.whirls.synchronous import whirls_of_system
from rotor_ida.closed_forms.whirls.turning_axes import NEUTRAL
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import Assembly, assemble
from rotor_ida.model.axisymmetric import check_masses, forward_motions, no_circles
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.system_parts import check_clearances
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.archived_system import described_problem
from rotor_ida.results.in_si import takes_system
from rotor_ida.results.si_units import with_system_units
from rotor_ida.schema import SPECIAL, labelled_dataset

MOST_POINTS = 100_000
# Parts of the work for each set of contacts: branches, Hopf points, grazes.
PARTS = 3
# Points on a further contact, over the clearance, but for rounding.
_ROUNDED = 1e-11


@dataclass(frozen=True, slots=True)
class _Point:
    """A special point: speed, kind, what touches, unknowns, frequencies, and what it grazes."""

    speed: float
    kind: str
    touching: Touching
    v: Values
    frequency: float = np.nan
    grazed: float = np.nan
    whirl_speed: float = np.nan


@takes_system
@shows_progress
def special_speeds(
    system: RotorSystem,
    *,
    limits: tuple[float, float],
    points: int = 200,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Compute the speeds at which a rotor system becomes unstable, and at which its whirls change.

    Parameters
    ----------
    system : RotorSystem, Rotor or DimensionalRotor
        The rotor. Where it is not axisymmetric, or carries a load, only thresholds are found.
    limits : (float, float)
        Lowest and highest speed.
    points : int
        Number of speeds in between, at equal distances, from whose whirls branches are followed. An
        isola between neighbouring speeds that no graze leads to is not noticed; nor may be two Hopf
        points that undo each other within a small part of a step along a branch.
    progress : callable or bool, optional
        Called with the number of parts done and their total, for each set of contacts that may
        touch its branches, their Hopf points and their grazes; True shows a bar on standard error.
    contacts, unbalance, supports, bearings, gravity, static_force : optional
        In place of those of the system, as in `simulate`.

    Returns
    -------
    Dataset
        On ``special``, in order of speed: ``special_speed`` and ``special_kind``: ``threshold``,
        where the motion without contact begins or ceases to grow, as a whirl at ``whirl_speed``;
        ``fold``, where two whirls meet and vanish; ``hopf``, where a whirl in contact loses its
        stability to an oscillation, with ``hopf_frequency`` on rotating axes; and ``graze``, where
        a whirl just touches another contact, the number ``grazed_contact``. On
        ``(special, contact)``: ``amplitude``, NaN at a threshold, and ``in_contact``. The whirls
        between: ``branch_amplitude`` on ``(speed, branch, contact)`` and ``branch_stability``. The
        attribute ``not_exact`` says why there are none.

    Raises
    ------
    InputError
        As from `synchronous_response`; if `limits` are not two speeds, the lower one first, or lie
        outside the table of a bearing.

    Notes
    -----
    A fold is a double root of the equations of `single_rubs` or `double_rubs`. In a linear contact
    two whirls may also meet at a graze. Bearings have their coefficients at each speed.

    Examples
    --------
    >>> from rotor_ida import Rotor
    >>> found = special_speeds(Rotor(omega=1.0, zeta=0.07, delta0=0.5), limits=(0.1, 3.0))
    >>> found.special_speed.values.round(6), found.special_kind.values
    (array([1.340701, 1.859769]), array([1, 1], dtype=int8))
    """
    system = changed_system(special_speeds, system, changed)
    low, high = checked_limits(limits)
    speeds = np.linspace(low, high, check_count("points", points, 2, MOST_POINTS))
    assembly = assemble(system, speeds=speeds)
    check_clearances(assembly.contacts)
    check_masses(assembly)
    found = [
        _Point(at, "threshold", (), np.zeros(0), whirl_speed=whirl_speed)
        for at, whirl_speed in growth_thresholds(linear_motions(assembly), speeds)
    ]
    told: dict[str, object] = {"limits": np.array([low, high]), "points": points}
    report = check_progress(progress)
    try:
        whirls = whirls_of_system(system, speeds)
    except InputError as error:
        return _dataset(assembly, found, None, None).assign_attrs(told, not_exact=no_circles(error))
    problem = RubProblem(assembly, forward_motions(assembly))
    others = (each for each in _special_points(problem, speeds, report) if _is_free(problem, each))
    return _dataset(assembly, [*found, *others], problem, whirls).assign_attrs(told)


def _special_points(
    problem: RubProblem, speeds: Values, progress: Progress | None
) -> Iterator[_Point]:
    """Yield folds, grazes and Hopf points of all sets of contacts, the smaller sets first."""
    touched: dict[Touching, list[Values]] = {}
    sets = [(), *touching_sets(problem.assembly.contacts)]

    def tell(done: int) -> None:
        if progress is not None:
            progress(done, PARTS * len(sets))

    for number, touching in enumerate(sets):
        branches = Branches(problem, touching, speeds)
        for each in touched.get(touching, []):
            branches.add_from(each)
        curve = branches.curve
        tell(PARTS * number + 1)
        yield from (_point(curve, each, "fold") for each in branches.folds)
        if branches.pieces:
            if touching:
                yield from _hopf_points(curve, branches.pieces)
            tell(PARTS * number + 2)
            for graze in _grazes(curve, branches.pieces):
                more = int(graze.grazed)
                larger = tuple(sorted((*touching, more)))
                start = np.insert(np.append(graze.v, graze.speed), larger.index(more), 0.0)
                touched.setdefault(larger, []).append(start)
                yield graze
        tell(PARTS * (number + 1))


def _point(curve: Curve, at: Values, kind: str, **more: float) -> _Point:
    """Return a special point of a branch."""
    unknowns = at * curve.scale
    return _Point(float(unknowns[-1]), kind, curve.touching, unknowns[:-1], **more)


def _grazes(curve: Curve, pieces: Sequence[Piece]) -> Iterator[_Point]:
    """Yield where another contact is just touched along branches."""

    def gaps(points: Values) -> Values:
        at = points * curve.scale
        return _gaps(curve.problem, curve.touching, at[:, :-1], at[:, -1])

    for piece, ends in zip(*plain_pieces(curve, pieces, gaps), strict=True):
        for other in np.nonzero(ends[0] * ends[1] < 0.0)[0].tolist():

            def gap(point: Values, other: int = other) -> float:
                return float(gaps(point[np.newaxis])[0, other])

            yield _point(curve, piece.at(piece.where(gap)), "graze", grazed=float(other))


def _gaps(problem: RubProblem, touching: Touching, v: Values, speeds: Values) -> Values:
    """Return the distances of whirls from the contacts that they do not touch, else NaN."""
    displacement = problem.whirls(touching, v, speeds).displacement
    gaps = problem.clearances - np.abs(displacement)
    gaps[:, list(touching)] = np.nan
    return np.asarray(gaps)


def _hopf_points(curve: Curve, pieces: Sequence[Piece]) -> Iterator[_Point]:
    """Yield where the real part of a pair of eigenvalues vanishes along branches."""

    def eigenvalues(points: Values) -> ComplexValues:
        """Return eigenvalues in order of their real parts, the largest first."""
        at = points * curve.scale
        found = curve.problem.eigenvalues(curve.touching, at[:, :-1], at[:, -1])
        return np.take_along_axis(found, np.argsort(-found.real, axis=1), axis=1)

    def growth(points: Values) -> Values:
        found = eigenvalues(points)
        size = np.abs(found).max(axis=1, keepdims=True)
        return np.where(np.abs(found.real) > NEUTRAL * size, found.real, 0.0)

    for piece, ends in zip(*plain_pieces(curve, pieces, growth), strict=True):
        first, last = (ends > 0.0).sum(axis=1).tolist()
        number = min(first, last)
        while number < max(first, last):

            def eigenvalue(point: Values, number: int = number) -> complex:
                return complex(eigenvalues(point[np.newaxis])[0, number])

            point = piece.at(piece.where(lambda point: eigenvalue(point).real))
            frequency = abs(eigenvalue(point).imag)
            oscillates = frequency > NEUTRAL * np.abs(eigenvalues(point[np.newaxis])).max()
            if oscillates:
                yield _point(curve, point, "hopf", frequency=frequency)
            number += 2 if oscillates else 1


def _is_free(problem: RubProblem, point: _Point) -> bool:
    """Return whether a point touches no further contact, but for the one that it grazes."""
    gaps = _gaps(problem, point.touching, point.v[np.newaxis], np.array([point.speed]))[0]
    gaps = np.sort(gaps[np.isfinite(gaps)])
    rounded = -_ROUNDED * problem.clearances.max(initial=0.0)
    return bool((gaps >= rounded).all())


def _dataset(
    assembly: Assembly, found: Sequence[_Point], problem: RubProblem | None,
    whirls: xr.Dataset | None,
) -> xr.Dataset:  # fmt: skip
    """Return special points in order of speed, with the whirls and what they are computed from."""
    points = sorted(found, key=lambda each: each.speed)
    amplitude = np.full((len(points), len(assembly.contacts)), np.nan)
    touches = np.zeros(amplitude.shape, np.int8)
    for number, each in enumerate(points):
        if problem is not None and each.kind != "threshold":
            whirl = problem.whirls(each.touching, each.v[np.newaxis], np.array([each.speed]))
            amplitude[number] = np.abs(whirl.displacement[0])
            touches[number, list(each.touching)] = 1
    kinds = np.array([SPECIAL[each.kind] for each in points], np.int8)
    variables: dict[str, Column] = {
        "special_speed": ("special", np.array([each.speed for each in points])),
        "special_kind": ("special", kinds),
        "hopf_frequency": ("special", np.array([each.frequency for each in points])),
        "whirl_speed": ("special", np.array([each.whirl_speed for each in points])),
        "grazed_contact": ("special", np.array([each.grazed for each in points])),
        "amplitude": (("special", "contact"), amplitude),
        "in_contact": (("special", "contact"), touches),
    }
    coordinates: dict[str, Column] = {
        "node": ("node", np.array(list(assembly.system.nodes), str)),
    }  # fmt: skip
    if whirls is not None:
        coordinates |= {name: (name, whirls[name].values) for name in ("speed", "branch")}
        for name in ("amplitude", "stability"):
            variables[f"branch_{name}"] = (whirls[name].dims, whirls[name].values)
    dataset = labelled_dataset(
        "Special speeds of a rotor system", {**variables, **described_problem(assembly)},
        coordinates, {"source": "rotor_ida closed forms", "most_touching": MOST_TOUCHING},
        kind="system_special_points",
    )  # fmt: skip
    return with_system_units(dataset, assembly.system)
