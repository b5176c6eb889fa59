"""The response curve over the spin speed."""

from __future__ import annotations

import math
from dataclasses import asdict, replace
from itertools import pairwise
from typing import Unpack

import numpy as np
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import check_count
from rotor_ida.closed_forms.contact_free import complex_amplitude, static_sag, touch_speeds
from rotor_ida.closed_forms.curve_polynomials import (
    CurveEquations,
    equations_of,
    exact_tips,
    flanks,
)
from rotor_ida.closed_forms.curve_tracing import (
    MOST_POINTS,
    Chain,
    CurveLaw,
    Piece,
    Place,
    check_damped,
    checked_limits,
    driven,
    joined,
    labelled_curves,
    marks_at,
    piece_of,
    spread,
    traced,
)
from rotor_ida.closed_forms.folds import RANGES, fold_table
from rotor_ida.closed_forms.peaks import speeds_of_stiffness
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.closed_forms.synchronous import (
    SMALLEST_SPEED,
    whirls_in_contact,
    why_linear_alone,
)
from rotor_ida.model.parameters import Parameters
from rotor_ida.model.rotor import Rotor
from rotor_ida.model.varied import Varied

# Why a curve over the speed takes none.
BETWEEN_LIMITS = {"omega": "it varies between the limits"}
# Range of speeds in which a contact-free whirl fits into the clearance.
_Span = tuple[float, float]


def response_curve(
    rotor: Rotor | None = None,
    *,
    limits: tuple[float, float],
    points: int = 200,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the response curve over the speed: all synchronous whirls, in order along it.

    Parameters
    ----------
    rotor : Rotor, optional
        The rotor. Without it, ``zeta`` and ``delta0`` must be given.
    limits : tuple of two floats
        Lowest and highest speed [dimensionless].
    points : int
        Number of points from one fold, tip, first touch or limit to the next.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], in place of those of `rotor`, as for `folds`.

    Returns
    -------
    Dataset
        On (zeta, delta0, point), with other dimensions as for `folds` before ``point``: ``omega``,
        ``amplitude`` [dimensionless], ``phase_lag`` [rad], ``stability`` and ``in_contact``
        (flags), and ``piece``, the number of the connected piece: first the contact-free whirl,
        then those in contact. The first and the last point of an isola are the same. Shorter curves
        are padded with NaN, the flag ``absent`` and piece -1. Under a load there is the whirl clear
        of the stator alone, up to the touch, as from `synchronous_response`.

    Raises
    ------
    InputError
        If `limits` are not two speeds, the lower one first and the higher one at most 1e15; if
        `folds` does not accept a value; or if `zeta` is 0 in a linear contact without friction.

    Notes
    -----
    With ``q = omega**2`` and ``s = f(A)/A`` the amplitude equation is a quadratic in q at given
    A (see `speeds_at_amplitude`). The flanks meet at the tips, where
    ``h(A) = (A - delta0)**1.5 / (A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``; without damping they
    never do. The derivatives of P (see `contacting_whirls`) are ``dP/dA = 2 A D`` and
    ``dP/dq = -q (1 + cos(theta)**2 + 2 A cos(theta))``. The last factor is positive on the slower
    flank and negative on the faster. So a whirl on the slower flank is stable where the speed rises
    with A, on the faster where it falls, and stability changes only at folds. A fold has the
    stability of the preceding part of the curve. Without damping the flanks of ``delta0 >= 1`` meet
    at rest; they count as two pieces.

    A shaft adds its stiffness kappa to s. The contact-free whirl then has a separate resonance, and
    for ``delta0 > 1`` two pieces if that reaches the stator: see `touch_speeds`. Contact damping
    may make a whirl unstable away from folds, which is decided point by point.

    So may friction. The speeds at given A are then the positive roots of a quartic in omega, also
    at most two: see `curve_polynomials`. A whirl is on the slower flank if
    ``omega (1 + A cos(theta)) > zeta A sin(theta)``. The flanks then meet even without damping.

    References
    ----------
    Eqs (21)-(23) and Figs 6 and 10 of the paper, Mechanika 25(6), 2019, with the force
    corrected.

    Examples
    --------
    >>> found = response_curve(zeta=0.07, delta0=2.0, limits=(0.05, 3.0))
    >>> isola = found.where(found.piece == 1, drop=True).squeeze()
    >>> round(isola.amplitude.max().item(), 3), bool(isola.omega[0] == isola.omega[-1])
    (11.346, True)
    """
    asked = whirls_asked(response_curve, rotor, varied, RANGES, BETWEEN_LIMITS, under_load=True)
    return curve_over_speed(asked, limits, points)


def curve_over_speed(asked: Varied, limits: object, points: object) -> xr.Dataset:
    """Return the response curves of all rotors, as `response_curve` does."""
    span = checked_limits(limits, smallest=SMALLEST_SPEED)
    count = check_count("points", points, 2, MOST_POINTS)
    check_damped(asked)
    grid, table = RotorColumns.of(asked.columns), fold_table(asked)
    turns = table.reshape(asked.points, *table.shape[-2:])
    curves = []
    rooms = grid.delta0 - static_sag(grid.load, grid.shaft_stiffness)
    for row, equations in enumerate(equations_of(grid)):
        if grid.load[row] > 0.0:
            room = replace(equations, law=replace(equations.law, delta0=float(rooms[row])))
            curves.append(_contact_free_pieces(room, span, count) if rooms[row] > 0.0 else [])
            continue
        pieces = _contact_free_pieces(equations, span, count)
        pieces += _contacting_pieces(equations, turns[row], span, count)
        if equations.contact_damping > 0.0 or equations.law.friction > 0.0:
            pieces = [driven(piece, "omega", grid[row]) for piece in pieces]
        curves.append(pieces)
    return labelled_curves("omega", curves, asked).assign_attrs(why_linear_alone(grid))


def _contact_free_pieces(equations: CurveEquations, limits: _Span, points: int) -> list[Piece]:
    """Return the contact-free whirl at the speeds at which it fits into the clearance."""
    first, second = _touch_speeds(equations)
    spans = [
        (max(limits[0], low), min(limits[1], high))
        for low, high in ((0.0, first), (second, math.inf))
    ]
    return [_contact_free_piece(equations, span, points) for span in spans if span[0] < span[1]]


def _touch_speeds(equations: CurveEquations) -> list[float]:
    """Return the speeds of `touch_speeds`, infinite where there is none."""
    law = equations.law
    found = touch_speeds(
        zeta=equations.zeta, delta0=law.delta0, shaft_stiffness=law.shaft_stiffness
    )
    return [each if math.isfinite(each) else math.inf for each in found.tolist()]


def _contact_free_piece(equations: CurveEquations, ends: _Span, points: int) -> Piece:
    """Return the contact-free whirl between two speeds, monotone on either side of its peak."""
    zeta, kappa = equations.zeta, equations.law.shaft_stiffness

    def amplitude(omega: Values) -> Values:
        free = np.abs(complex_amplitude(omega, zeta, kappa))
        return np.minimum(free, equations.law.delta0)

    def lag(omega: Values, _: Values) -> Values:
        return np.asarray(np.arctan2(2.0 * zeta * omega, kappa - omega * omega))

    softening = kappa - 2.0 * zeta * zeta
    largest = kappa / math.sqrt(softening) if softening > 0.0 else math.inf
    cuts = [ends[0], largest, ends[1]] if ends[0] < largest < ends[1] else list(ends)
    word = "stable" if zeta > 0.0 and kappa > 0.0 else "neutral"
    places = [(omega, float(amplitude(np.array(omega)))) for omega in cuts]
    arcs = [spread(amplitude, lag, pair, points) for pair in pairwise(places)]
    return joined([piece_of(*arc, word, in_contact=0) for arc in arcs])


def _contacting_pieces(
    equations: CurveEquations, turns: Values, limits: _Span, points: int
) -> list[Piece]:
    """Return the whirls in contact; `turns` contains speed and amplitude of the folds."""
    zeta, law = equations.zeta, equations.law

    def speed(flank: int, A: Values) -> Values:
        if law.friction > 0.0:
            slower, faster, _ = flanks(A, equations)
        else:
            slower, faster = speeds_of_stiffness(A, 4.0 * zeta * zeta, law.stiffness(A))
        return slower if flank == 1 else faster

    def lag(A: Values, omega: Values) -> Values:
        stiffness = law.stiffness(A)
        loss = 2.0 * zeta * omega + law.friction * (stiffness - law.shaft_stiffness)
        return np.asarray(np.arctan2(loss, stiffness - omega * omega))

    at_limits = np.array([omega for omega in limits if omega > 0.0])
    whirls = whirls_in_contact(RotorColumns.of(asdict(law) | {"omega": at_limits, "zeta": zeta}))
    rows, columns = np.nonzero(np.isfinite(whirls.amplitude))
    turn_speeds, turn_radii = turns[np.isfinite(turns[:, 0])].T
    lag_at_turns = lag(turn_radii, turn_speeds)
    if law.friction == 0.0:
        # at a fold the phase lag is beyond a quarter turn
        sine = np.minimum(2.0 * zeta * turn_radii / turn_speeds, 1.0)
        lag_at_turns = math.pi - np.arcsin(sine)
    lags = np.append(whirls.phase_lag[rows, columns], lag_at_turns)
    amplitude = np.append(whirls.amplitude[rows, columns], turn_radii)
    omega = np.append(at_limits[rows], turn_speeds)
    slope = omega * (1.0 + amplitude * np.cos(lags)) - zeta * amplitude * np.sin(lags)
    curve = CurveLaw(speed, lag, limits, points, zeta > 0.0)
    return traced(_chains(equations), marks_at(slope, amplitude, omega), curve)


def _chains(equations: CurveEquations) -> list[Chain]:
    """Return the parts of the contacting curve: from first touch, and closed ones."""
    zeta, law = equations.zeta, equations.law
    d, (first, second) = law.delta0, _touch_speeds(equations)
    ends = [Place(*tip) for tip in exact_tips(equations)]
    chains = []
    endless = zeta == 0.0 and law.friction == 0.0
    rest = Place(d, 0.0)
    if math.isfinite(first):
        far = Place(math.inf if endless else 1.0, math.inf)
        top = ends.pop(0) if len(ends) % 2 else far
        end = Place(d, second) if d > 1.0 else Place(1.0, math.inf)
        chains.append(Chain(1, Place(d, first), top, end))
    elif endless:
        chains.append(Chain(1, rest, Place(math.inf, math.inf), rest))
    elif len(ends) % 2:  # without damping, from rest
        # where the free whirl of every speed just touches, a linear contact holds one of speed 1
        end = Place(d, 1.0) if d == 1.0 and not law.hertz else rest
        chains.append(Chain(1, rest, ends.pop(0), end))
    pairs = zip(ends[::2], ends[1::2], strict=True)
    return chains + [Chain(1, low, high, low) for low, high in pairs]
