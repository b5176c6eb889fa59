"""Trace response curves: chains of flanks, cut at marks, as points in order.

At a given amplitude A a contacting whirl has at most two speeds, one on each flank of the
resonance, and at a given speed at most two clearances. So the curve is traced along A, flank by
flank. The points at which it turns or leaves the range are computed separately and exactly: tips
(where the flanks meet), folds, the first touch, and the whirls at the limits of the range. Between
two of them it is monotone, and points are placed where it is long or bends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import partial
from itertools import groupby, pairwise
from operator import itemgetter
from typing import NamedTuple

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis
from rotor_ida.closed_forms.restoring_law import stiffnesses
from rotor_ida.closed_forms.rotor_columns import RotorColumns
from rotor_ida.closed_forms.stability import eigenvalues_of
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.varied import Varied
from rotor_ida.schema import STABILITY, labelled_dataset

_REFERENCES = "Mechanika 25(6), 2019, eqs (10) and (21)-(23), with the force corrected"
_SOURCE = "rotor_ida closed forms: the amplitude equation, solved at given amplitudes"
# Rounds in which points move to where the curve is long or bends.
_ROUNDS = 4
# Largest number of points from one landmark to the next; a figure shows some hundred.
MOST_POINTS = 100_000


class Place(NamedTuple):
    """An amplitude and the speed or clearance at which a whirl has it [dimensionless]."""

    amplitude: float
    value: float


class Mark(NamedTuple):
    """A point that ends monotone arcs of one flank."""

    flank: int
    place: Place


class Piece(NamedTuple):
    """The points of a connected piece of a curve, in order."""

    value: Values  # speed or clearance
    amplitude: Values
    stability: Values  # flags, as numbers
    in_contact: Values


class Chain(NamedTuple):
    """Both flanks of a part of the curve: from `begin` up to `top` and down to `end`.

    On flank +1 a whirl is stable where the value rises with the amplitude, on flank -1 where it
    falls. A place is infinite if the flank never ends.
    """

    flank: int  # from begin to top; the other one leads from top to end
    begin: Place
    top: Place
    end: Place


class Arc(NamedTuple):
    """A monotone part of a flank."""

    flank: int
    begin: Place
    end: Place


@dataclass(frozen=True, slots=True)
class CurveLaw:
    """The course of one curve, and how to trace it."""

    value: Callable[[int, Values], Values]  # on a flank, at amplitudes
    lag: Callable[[Values, Values], Values]  # [rad], at amplitudes and such values
    limits: tuple[float, float]
    points: int  # of each monotone arc
    damped: bool  # if so, a whirl that is not unstable is stable, otherwise neutral


def marks_at(slope: Values, amplitude: Values, value: Values) -> list[Mark]:
    """Return marks on the flanks by the sign of `slope`."""
    flank = np.where(slope > 0.0, 1, -1).tolist()
    return list(map(Mark, flank, map(Place, amplitude.tolist(), value.tolist())))


def traced(chains: Sequence[Chain], marks: Sequence[Mark], law: CurveLaw) -> list[Piece]:
    """Return the pieces of the contacting curve whose values lie within the limits."""
    pieces = []
    low, high = law.limits
    for flank, begin, top, end in chains:
        arcs = _arcs(Arc(flank, begin, top), marks) + _arcs(Arc(-flank, top, end), marks)
        ends = [sorted((arc.begin.value, arc.end.value)) for arc in arcs]
        inside = [low <= first <= last <= high for first, last in ends]
        if begin == end and math.isfinite(top.amplitude) and not all(inside):
            # a closed curve that is partly outside the limits begins behind that part
            first = inside.index(False)
            arcs, inside = arcs[first:] + arcs[:first], inside[first:] + inside[:first]
        for kept, group in groupby(zip(inside, arcs, strict=True), key=itemgetter(0)):
            if kept:
                pieces.append(joined([_drawn(arc, law) for _, arc in group]))
    return pieces


def _arcs(flank: Arc, marks: Sequence[Mark]) -> list[Arc]:
    """Return the arcs into which the marks divide a flank."""
    low, high = sorted((flank.begin.amplitude, flank.end.amplitude))
    inside = [
        place for side, place in marks if side == flank.flank and low < place.amplitude < high
    ]
    falls = flank.begin.amplitude > flank.end.amplitude
    places = [flank.begin, *sorted(inside, reverse=falls), flank.end]
    return [
        Arc(flank.flank, begin, end)
        for begin, end in pairwise(places)
        if begin.amplitude != end.amplitude
    ]


def _drawn(arc: Arc, law: CurveLaw) -> Piece:
    """Return the points of one arc."""
    begin, end = arc.begin, arc.end
    amplitude, value = spread(partial(law.value, arc.flank), law.lag, (begin, end), law.points)
    rises = (end.value - begin.value) * (end.amplitude - begin.amplitude)
    word = "unstable" if arc.flank * rises <= 0.0 else "stable" if law.damped else "neutral"
    return piece_of(value, amplitude, word, in_contact=1)


def piece_of(value: Values, amplitude: Values, stability: str, in_contact: int) -> Piece:
    """Return a piece with uniform stability."""
    columns = np.broadcast_arrays(value, amplitude, float(STABILITY[stability]), in_contact)
    return Piece(*columns)


def joined(parts: Sequence[Piece]) -> Piece:
    """Return parts that share their ends as one piece."""
    columns = (
        np.concatenate([column[min(number, 1) :] for number, column in enumerate(each)])
        for each in zip(*parts, strict=True)
    )
    return Piece(*columns)


def spread(
    value_at: Callable[[Values], Values],
    lag_at: Callable[[Values, Values], Values],
    ends: tuple[tuple[float, float], tuple[float, float]],
    points: int,
) -> tuple[Values, Values]:
    """Return points of a monotone arc, more of them where it is long, bends or the lag changes.

    Lengths and angles are measured with the arc scaled to a unit square. A quarter turn of the line
    and half a turn of the phase lag count as much as a side.
    """
    (first, low), (last, high) = ends

    def at(fraction: Values) -> tuple[Values, Values]:
        position = first + (last - first) * fraction
        # none beyond the ends by rounding
        inner = np.clip(value_at(position[1:-1]), min(low, high), max(low, high))
        return position, np.concatenate([[low], inner, [high]])

    fraction = 0.5 - 0.5 * np.cos(np.linspace(0.0, math.pi, points))
    for _ in range(_ROUNDS):
        position, value = at(fraction)
        turn = np.abs(np.diff(lag_at(position, value))) / math.pi
        across, up = np.diff(fraction), np.diff(value) / ((high - low) or 1.0)
        bend = np.abs(np.diff(np.arctan2(up, across))) / math.pi
        weight = np.hypot(across, up) + turn + np.append(bend, 0.0) + np.append(0.0, bend)
        along = np.append(0.0, np.cumsum(weight))
        fraction = np.interp(np.linspace(0.0, along[-1], points), along, fraction)
    position, value = at(fraction)
    position[-1] = last
    return position, value


def driven(piece: Piece, varied: str, rotor: RotorColumns) -> Piece:
    """Return a piece with whirls driven by contact damping or friction marked as unstable."""
    rotors = RotorColumns.of(asdict(rotor) | {varied: piece.value})
    unstable = STABILITY["unstable"]
    chosen = np.nonzero(
        (piece.in_contact == 1) & (piece.stability != unstable) & (rotors.omega > 0.0)
    )[0]
    if not chosen.size:
        return piece
    at = rotors[chosen]
    rates = eigenvalues_of(piece.amplitude[chosen], at).real.max(axis=-1)
    stability = piece.stability.copy()
    # at a fold one eigenvalue is 0, up to rounding
    stability[chosen] = np.where(rates > 1e-10 * at.omega, unstable, STABILITY["stable"])
    return piece._replace(stability=stability)


def labelled_curves(varied: str, curves: Sequence[Sequence[Piece]], asked: Varied) -> xr.Dataset:
    """Return the dataset of curves, one for each rotor of a study, over the parameter `varied`."""
    longest = max(sum(piece.value.size for piece in pieces) for pieces in curves)
    absent = [math.nan, math.nan, STABILITY["absent"], 0, -1]
    table = np.tile(np.reshape(absent, (5, 1, 1)), (len(curves), longest))
    for row, pieces in enumerate(curves):
        first = 0
        for number, piece in enumerate(pieces):
            here = slice(first, first + piece.value.size)
            table[:4, row, here], table[4, row, here] = piece, number
            first = here.stop
    value, amplitude, *flags = table
    columns = {
        varied: value,
        "amplitude": amplitude,
        "phase_lag": _phase_lag(
            amplitude, replace(RotorColumns.of(asked.columns)[:, None], **{varied: value})
        ),
    }
    names = ("stability", "in_contact", "piece")
    columns |= {name: flag.astype(np.int8) for name, flag in zip(names, flags, strict=True)}
    dims, sizes = (*asked.dims, "point"), (*asked.shape, longest)
    contact = "contact" if asked.optional else "Hertz contact"
    return labelled_dataset(
        f"Response curve of a rotor with {contact} and clearance",
        {name: (dims, column.reshape(sizes)) for name, column in columns.items()},
        asked.coordinates | {"point": ("point", np.arange(longest))},
        {"source": _SOURCE, "references": _REFERENCES},
        kind="response_curve",
    )


def _phase_lag(amplitude: Values, rotors: RotorColumns) -> Values:
    _, stiffness = stiffnesses(amplitude, rotors.delta0, rotors.contact_exponent)
    loss = 2.0 * rotors.zeta * rotors.omega + rotors.friction * stiffness
    lag = np.arctan2(loss, stiffness + rotors.shaft_stiffness - rotors.omega**2)
    return np.where(np.isnan(amplitude), math.nan, lag)  # a linear stiffness is a number there too


def check_damped(asked: Varied) -> None:
    """Raise InputError for a linear contact without damping or friction: infinite curves."""
    if (
        (asked.values("zeta") == 0.0).any()
        and (asked.values("contact_exponent") != HERTZ_EXPONENT).any()
        and (asked.values("friction") == 0.0).any()
    ):
        raise InputError(
            "zeta must be positive for the curve of a linear contact without friction, got 0.0: "
            "without damping it is infinite in resonance"
        )


def checked_limits(limits: object, *, smallest: float = 0.0) -> tuple[float, float]:
    """Return the two ends of a range."""
    ends = check_axis("limits", limits, smallest=smallest, largest=LARGEST_NUMBER)
    if ends.size != 2 or ends[0] >= ends[1]:
        raise InputError(
            "{name} must be two numbers, the lower first, got {value}",
            name="limits", value=tuple(ends.tolist()),
        )  # fmt: skip
    return float(ends[0]), float(ends[1])
