"""The response curve as a curve: its points in order, over the speed or over the clearance.

At a given amplitude A a contacting whirl has at most two speeds, one on each flank of the
resonance, and at a given speed at most two clearances. So the curve is traced along A, flank by
flank. The points at which it turns or leaves the range are computed apart, each exactly: tips,
where the flanks meet, folds, the first touch, and the whirls at the limits of the range. Between
two of them it is monotone, and points are set where it is long or bends.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby, pairwise
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_count, check_positive, shown
from rotor_ida.closed_forms.contact_free import complex_amplitude, touch_speeds
from rotor_ida.closed_forms.contact_laws import stiffnesses
from rotor_ida.closed_forms.contacting_whirls import contacting_whirls
from rotor_ida.closed_forms.fold_locus_further import Ring
from rotor_ida.closed_forms.folds import fold_table, folds
from rotor_ida.closed_forms.further_parameters import PAPERS, Further, FurtherAxes, further_axes
from rotor_ida.closed_forms.peaks import (
    SMALLEST_DAMPING,
    flank_speeds,
    speeds_of_stiffness,
    tip_speed,
    tip_speed_of_ring,
    tips,
    tips_of_ring,
)
from rotor_ida.closed_forms.rubs import Rub, flanks, rub_tips
from rotor_ida.closed_forms.stability import eigenvalues
from rotor_ida.closed_forms.synchronous import SMALLEST_SPEED, whirls_in_contact
from rotor_ida.errors import InputError
from rotor_ida.model.contact import HERTZ_EXPONENT, secant_stiffness
from rotor_ida.schema import STABILITY, Column, labelled_dataset

# Amplitude and the speed or clearance at which a whirl has it.
_Place = tuple[float, float]

_REFERENCES = "Mechanika 25(6), 2019, eqs (10) and (21)-(23), with the force corrected"
_SOURCE = "rotor_ida closed forms: the amplitude equation, solved at given amplitudes"
# Rounds in which points move to where the curve is long or bends.
_ROUNDS = 4
# Between one landmark and the next; a figure shows some hundred.
MOST_POINTS = 100_000


def response_curve(
    *,
    zeta: object,
    delta0: object,
    limits: tuple[float, float],
    points: int = 200,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return every synchronous whirl over the spin speed, in order along the curve.

    Parameters
    ----------
    zeta, delta0 : float or sequence of float, shapes (m,) and (k,)
        Damping ratios and clearances [1].
    limits : tuple of two floats
        Lowest and highest speed [1].
    points : int
        Number of points between one fold, tip, first touch or limit and the next.
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `folds`, numbers or axes [1].

    Returns
    -------
    Dataset
        On (zeta, delta0, point), with further dimensions as `folds` has them before ``point``:
        ``omega``, ``amplitude`` [1], ``phase_lag`` [rad],
        ``stability`` and ``in_contact`` (flags), and ``piece``, the number of the connected
        piece: first the contact-free whirl, then those in contact. An isola ends with the point
        that it begins with. A curve with fewer points than another ends in NaN, the flag
        ``absent`` and piece -1.

    Raises
    ------
    InputError
        If `limits` are not two speeds, the lower one first and the higher one at most 1e15, or
        a value is none that `folds` takes, or `zeta` is 0 in a linear contact without friction.

    Notes
    -----
    With ``q = omega**2`` and ``s = f(A)/A`` the amplitude equation is a quadratic in q at given
    A (see `speeds_at_amplitude`). The flanks meet at the tips, where
    ``h(A) = (A - delta0)**1.5 / (A**2 (A + sqrt(A**2 - 1))) = 2 zeta**2``; without damping they
    never do. From the implicit derivative of P (see `contacting_whirls`), ``dP/dA = 2 A D`` and
    ``dP/dq = -q (1 + cos(theta)**2 + 2 A cos(theta))``: the last factor is positive on the slower
    flank and negative on the faster, so there a whirl is stable where the speed rises with A,
    here where it falls, and stability changes at folds alone. A fold has the stability of what
    comes before it on the curve. Without damping the flanks of ``delta0 >= 1`` meet at rest; they
    count as two pieces.

    A shaft adds its stiffness kappa to s. The contact-free whirl then has a resonance of its own,
    and for ``delta0 > 1`` two pieces where that reaches the ring: see `touch_speeds`. Contact
    damping may make a whirl unstable away from folds, which is told point by point.

    So may friction, with which the speeds at given A are the positive roots of a quartic in omega,
    two at most as well: see `rubs`. A whirl is on the slower flank where
    ``omega (1 + A cos(theta)) > zeta A sin(theta)``. Without damping the flanks meet too then.

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
    dampings, clearances = check_axis("zeta", zeta), check_axis("delta0", delta0)
    span = _checked_limits(limits, smallest=SMALLEST_SPEED)
    count = check_count("points", points, 2, MOST_POINTS)
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
        delta0=clearances,
    )
    if not further.default:
        return _further_curve(dampings, clearances, further, span, count)
    turns = fold_table(dampings, clearances)
    curves = [
        pieces_over_speed(float(damping), float(clearance), turns[i, k], span, count)
        for i, damping in enumerate(dampings)
        for k, clearance in enumerate(clearances)
    ]
    return _labelled("omega", curves, {"zeta": dampings, "delta0": clearances})


def clearance_curve(
    *,
    omega: object,
    zeta: object,
    limits: tuple[float, float],
    points: int = 200,
    shaft_stiffness: object = 0.0,
    contact_exponent: object = 1.5,
    contact_damping: object = 0.0,
    friction: object = 0.0,
) -> xr.Dataset:
    """Return every synchronous whirl over the clearance, in order along the curve.

    Parameters
    ----------
    omega, zeta : float or sequence of float, shapes (n,) and (m,)
        Spin speeds, above zero, and damping ratios [1].
    limits : tuple of two floats
        Smallest and largest clearance [1].
    points : int
        Number of points between one fold, tip, first touch or limit and the next.
    shaft_stiffness, contact_exponent, contact_damping, friction : float or sequence of float
        As for `folds`, numbers or axes [1].

    Returns
    -------
    Dataset
        On (omega, zeta, point), with further dimensions as `folds` has them before ``point``:
        ``delta0`` and the other variables of `response_curve`.

    Raises
    ------
    InputError
        If `limits` are not two clearances, the smaller one first, a damping ratio is above zero
        and below 1e-20, or 0 in a linear contact without friction, or a value is none that
        `synchronous_response` takes.

    Notes
    -----
    With ``q = omega**2`` a whirl of amplitude A needs ``s = q +- sqrt(q**2/A**2 - 4 zeta**2 q)``,
    so ``A <= omega/(2 zeta)``, and as ``s = u**3/A`` (the Hertz exponent) the clearance is
    ``A - (s A)**(2/3)``. The flanks meet at the largest A, where theta is a quarter turn; without
    damping they never do. A whirl is stable where the clearance rises with A on the stiffer
    flank, theta below a quarter turn, and where it falls on the softer one.

    There is at most one fold on either side of the largest value of

        ``g(w) = (R - w) (w**2/(1 + w**2))**(1/6)``,  ``R = omega/(2 zeta)``,

    at ``3 w**3 + 4 w = R``: where ``g = (2/3) (omega**2 r)**(2/3) r/R`` with ``r**2 = 1 + R**2``,
    and there ``A = R (R w + 1)/(r sqrt(1 + w**2))``. That is the derivative of the clearance
    by theta, with ``w = -tan(theta + arctan(1/R))``. Without damping the fold is at
    ``A = 1 + (8/27) q**2``.

    A shaft takes its stiffness kappa from s. Below its resonance, ``q <= kappa``, all whirls in
    contact lie on the stiffer flank. In a linear contact the clearance is ``A - s A``. Friction
    turns the force of the contact (see `contacting_whirls`): all this holds with
    ``(omega**2 - kappa - 2 mu zeta omega)/m``, ``(2 zeta omega + mu (omega**2 - kappa))/m`` and
    ``omega**2/sqrt(m)``, where ``m = 1 + mu**2``, for what stands before A and on the right.

    References
    ----------
    Eqs (21)-(23) and section 4.2.1 of the paper, Mechanika 25(6), 2019, with the force
    corrected.

    Examples
    --------
    >>> found = clearance_curve(omega=1.7, zeta=0.07, limits=(0.0, 3.0))
    >>> round(found.delta0.where(found.in_contact == 1).max().item(), 4)
    1.4589
    """
    speeds = check_axis("omega", omega, smallest=SMALLEST_SPEED, largest=LARGEST_NUMBER)
    for speed in speeds:
        check_positive("omega", float(speed))
    dampings = check_axis("zeta", zeta, smallest=SMALLEST_DAMPING, largest=LARGEST_NUMBER)
    span, count = _checked_limits(limits), check_count("points", points, 2, MOST_POINTS)
    further = further_axes(
        shaft_stiffness=shaft_stiffness,
        contact_exponent=contact_exponent,
        contact_damping=contact_damping,
        friction=friction,
        delta0=np.array(span),
    )
    if not further.default:
        _check_damped(dampings, further)
        axes = {"omega": speeds, "zeta": dampings} | further.axes
        return _labelled("delta0", _curves_over_clearance(axes, span, count), axes, further)
    curves = [
        _over_clearance(float(speed), float(damping), span, count)
        for speed in speeds
        for damping in dampings
    ]
    return _labelled("delta0", curves, {"omega": speeds, "zeta": dampings})


class _Chain(NamedTuple):
    """Both flanks of a part of the curve: from `begin` up to `top` and down to `end`.

    A flank is +1 where a whirl is stable as the value rises with the amplitude, -1 where as it
    falls. A place is infinite where the flank never ends.
    """

    flank: int  # from begin to top; the other one leads from top to end
    begin: _Place
    top: _Place
    end: _Place


@dataclass(frozen=True, slots=True)
class _Law:
    """How one curve runs, and how it is to be traced."""

    value: Callable[[int, Values], Values]  # on a flank, at amplitudes
    lag: Callable[[Values, Values], Values]  # [rad], at amplitudes and such values
    limits: _Place
    points: int  # of each monotone arc
    damped: bool  # a whirl that is not unstable is stable then, and neutral otherwise


def pieces_over_speed(
    zeta: float, delta0: float, turns: Values, limits: _Place, points: int
) -> list[Values]:
    """Return the pieces of the curve over the speed, as `response_curve` labels them.

    Each has speed, amplitude, stability and whether it is in contact, shape (4, n); `turns` has
    speed and amplitude of the folds, as `fold_table` returns them.

    Examples
    --------
    >>> free, touching = pieces_over_speed(0.07, 0.5, np.empty((0, 2)), (0.05, 0.1), 3)
    >>> free[1, -1].item(), touching[1, 0].item()
    (0.5, 0.5)
    """

    def speed(flank: int, A: Values) -> Values:
        return flank_speeds(A, 4.0 * zeta * zeta, delta0)[0 if flank == 1 else 1]

    def lag(A: Values, omega: Values) -> Values:
        return _phase_lag(A, omega, zeta, delta0)

    touch = math.inf
    if delta0 < 1.0:
        touch = 2.0 * zeta * delta0 / math.sqrt((1.0 - delta0) * (1.0 + delta0))
    pieces = []
    low, high = limits[0], min(limits[1], touch)
    if low < high:
        speeds, amplitude = _spread(
            lambda omega: np.abs(complex_amplitude(omega, zeta)),
            lambda omega, A: lag(A, omega),
            ((low, _free_amplitude(low, zeta)), (high, min(_free_amplitude(high, zeta), delta0))),
            points,
        )
        pieces.append(_points(speeds, amplitude, STABILITY["neutral"], in_contact=0))

    ends: list[_Place] = [(A, tip_speed(A, zeta, delta0)) for A in tips(zeta, delta0)]
    chains = []
    if delta0 < 1.0:
        # an odd number of tips: the first one ends what begins at the first touch
        far = (math.inf, math.inf) if zeta == 0.0 else (1.0, math.inf)
        top = ends.pop(0) if len(ends) % 2 else far
        chains.append(_Chain(1, (delta0, touch), top, (1.0, math.inf)))
    elif zeta == 0.0:
        chains.append(_Chain(1, (delta0, 0.0), (math.inf, math.inf), (delta0, 0.0)))
    chains += [
        _Chain(1, low_tip, high_tip, low_tip)
        for low_tip, high_tip in zip(ends[::2], ends[1::2], strict=True)
    ]

    at_limits = np.array([omega for omega in limits if omega > 0.0])
    amplitude, lags, omega = _whirls_at(at_limits, zeta, delta0, at_limits)
    turns = turns[np.isfinite(turns[:, 0])]
    # at a fold the phase lag is beyond a quarter turn
    sine = np.minimum(2.0 * zeta * turns[:, 1] / turns[:, 0], 1.0)
    cosine = np.cos(np.append(lags, math.pi - np.arcsin(sine)))
    amplitude, omega = np.append(amplitude, turns[:, 1]), np.append(omega, turns[:, 0])
    slope = 1.0 + cosine**2 + 2.0 * amplitude * cosine
    return pieces + _traced(
        chains, _marks(slope, amplitude, omega), _Law(speed, lag, limits, points, zeta > 0.0)
    )


def _further_curve(
    zeta: Values, delta0: Values, further: FurtherAxes, span: _Place, count: int
) -> xr.Dataset:
    """Return the curves with a shaft, either contact law and contact damping."""
    _check_damped(zeta, further)
    axes = {"zeta": zeta, "delta0": delta0} | further.axes
    found = folds(
        zeta=zeta,
        delta0=delta0,
        shaft_stiffness=axes["shaft_stiffness"],
        contact_exponent=axes["contact_exponent"],
        contact_damping=axes["contact_damping"],
        friction=axes["friction"],
    )
    turns = np.stack([found["fold_omega"].values, found["fold_amplitude"].values], axis=-1)
    curves = []
    for place in np.ndindex(*(axis.size for axis in axes.values())):
        at = {name: float(axis[k]) for (name, axis), k in zip(axes.items(), place, strict=True)}
        damping, hertz = at.pop("zeta"), at["contact_exponent"] == HERTZ_EXPONENT
        ring = Ring(at["delta0"], at["shaft_stiffness"], hertz, at["friction"])
        pieces = pieces_with_ring(damping, ring, turns[place], span, count)
        if at["contact_damping"] > 0.0 or at["friction"] > 0.0:
            for piece in pieces:
                _drive(piece, piece[0], at | {"zeta": damping})
        curves.append(pieces)
    return _labelled("omega", curves, axes, further)


def pieces_with_ring(
    zeta: float, ring: Ring, turns: Values, limits: _Place, points: int
) -> list[Values]:
    """Return the pieces of the curve over the speed, as `pieces_over_speed` does, of any ring."""
    d, rub = ring.delta0, _rub(zeta, ring)

    def speed(flank: int, A: Values) -> Values:
        if ring.friction > 0.0:
            slower, faster, _ = flanks(A, rub)
        else:
            slower, faster = speeds_of_stiffness(A, 4.0 * zeta * zeta, ring.stiffness(A))
        return slower if flank == 1 else faster

    def lag(A: Values, omega: Values) -> Values:
        stiffness = ring.stiffness(A)
        loss = 2.0 * zeta * omega + ring.friction * (stiffness - ring.shaft_stiffness)
        return np.asarray(np.arctan2(loss, stiffness - omega * omega))

    first, second = (
        each if math.isfinite(each) else math.inf
        for each in touch_speeds(zeta=zeta, delta0=d, shaft_stiffness=ring.shaft_stiffness).tolist()
    )
    pieces = [
        _contact_free_piece(zeta, ring, (max(limits[0], low), min(limits[1], high)), points)
        for low, high in ((0.0, first), (second, math.inf))
        if max(limits[0], low) < min(limits[1], high)
    ]

    ends: list[_Place] = (
        rub_tips(rub)
        if ring.friction > 0.0
        else [(A, tip_speed_of_ring(A, zeta, ring)) for A in tips_of_ring(zeta, ring)]
    )
    chains = []
    endless = zeta == 0.0 and ring.friction == 0.0
    if math.isfinite(first):
        far = (math.inf if endless else 1.0, math.inf)
        top = ends.pop(0) if len(ends) % 2 else far
        chains.append(_Chain(1, (d, first), top, (d, second) if d > 1.0 else (1.0, math.inf)))
    elif endless:
        chains.append(_Chain(1, (d, 0.0), (math.inf, math.inf), (d, 0.0)))
    elif len(ends) % 2:  # without damping, from rest
        chains.append(_Chain(1, (d, 0.0), ends.pop(0), (d, 0.0)))
    chains += [_Chain(1, *pair, pair[0]) for pair in zip(ends[::2], ends[1::2], strict=True)]

    at_limits = np.array([omega for omega in limits if omega > 0.0])
    beyond = Further(
        0.0 * at_limits + ring.shaft_stiffness,
        0.0 * at_limits + (HERTZ_EXPONENT if ring.hertz else 1.0),
        0.0 * at_limits,
        0.0 * at_limits + ring.friction,
    )
    whirls = whirls_in_contact(at_limits, 0.0 * at_limits + zeta, 0.0 * at_limits + d, beyond)
    rows, columns = np.nonzero(np.isfinite(whirls.amplitude))
    turns = turns[np.isfinite(turns[:, 0])]
    amplitude = np.append(whirls.amplitude[rows, columns], turns[:, 1])
    omega = np.append(at_limits[rows], turns[:, 0])
    if ring.friction > 0.0:
        lags = np.append(whirls.phase_lag[rows, columns], lag(turns[:, 1], turns[:, 0]))
        slope = omega * (1.0 + amplitude * np.cos(lags)) - zeta * amplitude * np.sin(lags)
    else:
        # at a fold the phase lag is beyond a quarter turn
        sine = np.minimum(2.0 * zeta * turns[:, 1] / turns[:, 0], 1.0)
        lags = np.append(whirls.phase_lag[rows, columns], math.pi - np.arcsin(sine))
        slope = 1.0 + np.cos(lags) ** 2 + 2.0 * amplitude * np.cos(lags)
    marks = _marks(slope, amplitude, omega)
    return pieces + _traced(chains, marks, _Law(speed, lag, limits, points, zeta > 0.0))


def _rub(zeta: float, ring: Ring) -> Rub:
    return Rub(zeta, ring.delta0, ring.shaft_stiffness, ring.friction, ring.hertz)


def _contact_free_piece(zeta: float, ring: Ring, ends: _Place, points: int) -> Values:
    """Return the contact-free whirl between two speeds, monotone on either side of its largest."""
    kappa = ring.shaft_stiffness

    def amplitude(omega: Values) -> Values:
        free = np.abs(complex_amplitude(omega, zeta, kappa if kappa > 0.0 else None))
        return np.minimum(free, ring.delta0)

    def lag(omega: Values, _: Values) -> Values:
        return np.asarray(np.arctan2(2.0 * zeta * omega, kappa - omega * omega))

    softening = kappa - 2.0 * zeta * zeta
    largest = kappa / math.sqrt(softening) if softening > 0.0 else math.inf
    cuts = [ends[0], largest, ends[1]] if ends[0] < largest < ends[1] else list(ends)
    held = zeta > 0.0 and kappa > 0.0
    arcs = []
    for low, high in pairwise(cuts):
        places = [(omega, float(amplitude(np.array(omega)))) for omega in (low, high)]
        speeds, radius = _spread(amplitude, lag, (places[0], places[1]), points)
        flag = STABILITY["stable" if held else "neutral"]
        arcs.append(_points(speeds, radius, flag, in_contact=0))
    return np.concatenate([arcs[0], *(arc[:, 1:] for arc in arcs[1:])], axis=1)


def _check_damped(zeta: Values, further: FurtherAxes) -> None:
    """Refuse curves of a linear contact without damping or friction, which run to infinity."""
    if (
        (zeta == 0.0).any()
        and (further.axes["contact_exponent"] != HERTZ_EXPONENT).any()
        and (further.axes["friction"] == 0.0).any()
    ):
        raise InputError(
            "zeta must be positive for the curve of a linear contact, which is infinite in "
            "resonance without damping, got 0.0"
        )


def _curves_over_clearance(
    axes: Mapping[str, Values], limits: _Place, points: int
) -> list[list[Values]]:
    """Return the curves over the clearance with a shaft, either law and contact damping."""
    curves = []
    for place in np.ndindex(*(axis.size for axis in axes.values())):
        at = {name: float(axis[k]) for (name, axis), k in zip(axes.items(), place, strict=True)}
        hertz = at["contact_exponent"] == HERTZ_EXPONENT
        rotor = at["omega"], at["zeta"], at["shaft_stiffness"], at["friction"], hertz
        pieces = _ring_over_clearance(*rotor, limits, points)
        if at["contact_damping"] > 0.0 or at["friction"] > 0.0:
            for piece in pieces:
                _drive(piece, 0.0 * piece[0] + at["omega"], at | {"delta0": piece[0]})
        curves.append(pieces)
    return curves


def _ring_over_clearance(
    omega: float,
    zeta: float,
    kappa: float,
    mu: float,
    hertz: bool,
    limits: _Place,
    points: int,
) -> list[Values]:
    """Return the pieces of the curve over the clearance, as `_over_clearance` does."""
    q = omega * omega
    p, power = q - kappa, 2.0 / 3.0 if hertz else 1.0
    largest = omega / (2.0 * zeta) if zeta > 0.0 else math.inf
    free = complex_amplitude(omega, zeta, kappa if kappa > 0.0 else None)
    loss, lead = 2.0 * zeta * omega, 1.0 + mu * mu
    if mu > 0.0:  # turned until the force of the contact is real
        across = abs(loss + mu * p) / lead
        p, q = (p - mu * loss) / lead, q / math.sqrt(lead)
        largest = q / across if across > 0.0 else math.inf
    touch = min(float(np.abs(free)), largest)
    pieces = []
    if touch < limits[1]:
        ends = np.array([max(limits[0], touch), limits[1]])
        word = "stable" if zeta > 0.0 and kappa > 0.0 else "neutral"
        pieces.append(_points(ends, np.full(2, touch), STABILITY[word], in_contact=0))

    def clearance(flank: int, A: Values) -> Values:
        sine = A / largest
        cosine = flank * np.sqrt(np.maximum((1.0 - sine) * (1.0 + sine), 0.0))
        return np.asarray(A - np.maximum(p * A + q * cosine, 0.0) ** power)

    def lag(A: Values, d: Values) -> Values:
        depth = np.maximum(A - d, 0.0)
        force = depth * np.sqrt(depth) if hertz else depth
        across = loss * A + mu * force
        return np.asarray(np.arctan2(across, force - (omega * omega - kappa) * A))

    top = (touch, touch)  # below the resonance of the shaft
    if p > 0.0:
        top = (
            (math.inf, math.inf)
            if math.isinf(largest)
            else (largest, float(clearance(1, np.array(largest))))
        )
    chain = _Chain(-1, (touch, touch), top, (0.0, -(q**power)))

    at_limits = np.array(limits)
    like = 0.0 * at_limits
    beyond = Further(like + kappa, like + (HERTZ_EXPONENT if hertz else 1.0), like, like + mu)
    whirls = whirls_in_contact(like + omega, like + zeta, at_limits, beyond)
    rows, columns = np.nonzero(np.isfinite(whirls.amplitude))
    cosine = np.cos(whirls.phase_lag[rows, columns] - math.atan(mu))
    marks = _marks(cosine, whirls.amplitude[rows, columns], at_limits[rows])
    if p > 0.0:
        turns = _ring_turns(q, p, largest, touch, hertz)
        marks += _marks(np.full(turns.size, -1.0), turns, clearance(-1, turns))
    law = _Law(clearance, lag, limits, points, zeta > 0.0)
    return pieces + _traced([chain], marks, law)


def _ring_turns(q: float, p: float, largest: float, touch: float, hertz: bool) -> Values:
    """Return the amplitudes of the folds over the clearance, on the softer flank.

    With ``A = R sin(t)`` the clearance is stationary where ``p + (q/R) tan(t)`` is 1 in a linear
    contact, and by Hertz 3/2 of the cube root of the force ``p A - q cos(t)``.
    """
    if math.isinf(largest):
        return np.array([(q + (8.0 / 27.0) * p**3) / p])
    first, last = math.asin(min(touch / largest, 1.0)), 0.5 * math.pi
    if not hertz:
        turn = math.atan2((1.0 - p) * largest, q)
        return np.array([largest * math.sin(turn)]) if first < turn < last else np.empty(0)

    def excess(turn: float) -> float:
        force = p * largest * math.sin(turn) - q * math.cos(turn)
        slope = p * math.cos(turn) + q / largest * math.sin(turn)
        return math.cbrt(max(force, 0.0)) * math.cos(turn) - (2.0 / 3.0) * slope

    nodes = first + (last - first) * (0.5 - 0.5 * np.cos(np.linspace(0.0, math.pi, 2001)))
    signs = np.array([excess(node) > 0.0 for node in nodes.tolist()])
    changes = np.nonzero(signs[:-1] != signs[1:])[0]
    brackets = [(float(nodes[k]), float(nodes[k + 1])) for k in changes]
    found = [brentq(excess, *ends, xtol=1e-300, rtol=1e-15) for ends in brackets]
    return np.asarray(largest * np.sin(np.array(found)))


def _drive(piece: Values, omega: Values, rotor: dict[str, Any]) -> None:
    """Mark the contacting whirls of a piece that contact damping drives as unstable."""
    _, amplitude, stability, in_contact = piece
    unstable = STABILITY["unstable"]
    chosen = np.nonzero((in_contact == 1) & (stability != unstable) & (omega > 0.0))[0]
    given = rotor | {"omega": omega}
    here = {name: each[chosen] if np.ndim(each) else each for name, each in given.items()}
    rates = eigenvalues(amplitude[chosen], **here).real.max(axis=-1)
    # at a fold one eigenvalue is 0, up to rounding
    driven = rates > 1e-10 * omega[chosen]
    stability[chosen] = np.where(driven, unstable, STABILITY["stable"])


def _over_clearance(omega: float, zeta: float, limits: _Place, points: int) -> list[Values]:
    """Return the pieces of the curve over the clearance."""
    q = omega * omega
    touch = _free_amplitude(omega, zeta)
    pieces = []
    if touch < limits[1]:
        ends = np.array([max(limits[0], touch), limits[1]])
        pieces.append(_points(ends, np.full(2, touch), STABILITY["neutral"], in_contact=0))

    largest = omega / (2.0 * zeta) if zeta > 0.0 else math.inf

    def clearance(flank: int, A: Values) -> Values:
        sine = A / largest
        cosine = flank * np.sqrt(np.maximum((1.0 - sine) * (1.0 + sine), 0.0))
        return np.asarray(A - np.cbrt(q * np.maximum(A + cosine, 0.0)) ** 2)

    top = (math.inf, math.inf)
    if zeta > 0.0:
        top = (largest, float(clearance(1, np.array(largest))))
    chain = _Chain(-1, (touch, touch), top, (0.0, -(np.cbrt(q) ** 2)))

    at_limits = np.array(limits)
    amplitude, lags, delta0 = _whirls_at(omega, zeta, at_limits, at_limits)
    turns = _turns_over_clearance(omega, zeta)
    marks = _marks(np.cos(lags), amplitude, delta0)
    marks += _marks(np.full(turns.size, -1.0), turns, clearance(-1, turns))
    law = _Law(clearance, lambda A, d: _phase_lag(A, omega, zeta, d), limits, points, zeta > 0.0)
    return pieces + _traced([chain], marks, law)


def _turns_over_clearance(omega: float, zeta: float) -> Values:
    """Return the amplitudes of the folds over the clearance: see `clearance_curve`."""
    q = omega * omega
    if zeta == 0.0:
        return np.array([1.0 + (8.0 / 27.0) * q * q])
    R = omega / (2.0 * zeta)
    r = math.hypot(1.0, R)

    def excess(w: float) -> float:
        cosine_squared = 1.0 / (1.0 + w * w)
        return (R - w) * math.cbrt(w * math.sqrt(cosine_squared)) - bound

    bound = (2.0 / 3.0) * math.cbrt(q * r) ** 2 * (r / R)
    summit = float(brentq(lambda w: 3.0 * w**3 + 4.0 * w - R, 0.0, R, xtol=1e-300, rtol=1e-15))
    if excess(summit) <= 0.0:
        return np.empty(0)
    brackets = ((0.0, summit), (summit, R))
    w = np.array([brentq(excess, *ends, xtol=1e-300, rtol=1e-15) for ends in brackets])
    return np.asarray(R * (R * w + 1.0) / (r * np.hypot(1.0, w)))


def _free_amplitude(omega: float, zeta: float) -> float:
    return abs(complex(complex_amplitude(omega, zeta)))


def _whirls_at(
    omega: Values | float, zeta: float, delta0: Values | float, values: Values
) -> tuple[Values, Values, Values]:
    """Return amplitude and phase lag of each contacting whirl, and the one of `values` it has."""
    whirls = contacting_whirls(*(0.0 * values + each for each in (omega, zeta, delta0)))
    rows, columns = np.nonzero(np.isfinite(whirls.amplitude))
    return whirls.amplitude[rows, columns], whirls.phase_lag[rows, columns], values[rows]


def _marks(slope: Values, amplitude: Values, value: Values) -> list[tuple[int, _Place]]:
    """Return flank, by the sign of `slope`, and place of points that end monotone arcs."""
    places = zip(amplitude.tolist(), value.tolist(), strict=True)
    return list(zip(np.where(slope > 0.0, 1, -1).tolist(), places, strict=True))


def _traced(
    chains: Sequence[_Chain], marks: Sequence[tuple[int, _Place]], law: _Law
) -> list[Values]:
    """Return the pieces of the contacting curve whose values lie within the limits."""
    pieces = []
    for flank, begin, top, end in chains:
        arcs = _arcs(flank, begin, top, marks) + _arcs(-flank, top, end, marks)
        low, high = law.limits
        inside = [low <= min(a[1], b[1]) <= max(a[1], b[1]) <= high for _, a, b in arcs]
        if begin == end and math.isfinite(top[0]) and not all(inside):
            # a closed curve of which a part is left out begins behind that
            first = inside.index(False)
            arcs, inside = arcs[first:] + arcs[:first], inside[first:] + inside[:first]
        for kept, group in groupby(zip(inside, arcs, strict=True), key=itemgetter(0)):
            if kept:
                drawn = [_drawn(*arc, law) for _, arc in group]
                shared = [part[:, 1:] for part in drawn[1:]]  # the arcs share their ends
                pieces.append(np.concatenate([drawn[0], *shared], axis=1))
    return pieces


def _arcs(
    flank: int, begin: _Place, end: _Place, marks: Sequence[tuple[int, _Place]]
) -> list[tuple[int, _Place, _Place]]:
    """Return the arcs, each with its flank, into which the marks divide a flank."""
    low, high = sorted((begin[0], end[0]))
    inside = [place for side, place in marks if side == flank and low < place[0] < high]
    places = [begin, *sorted(inside, reverse=begin[0] > end[0]), end]
    return [(flank, *ends) for ends in pairwise(places) if ends[0] != ends[1]]


def _drawn(flank: int, begin: _Place, end: _Place, law: _Law) -> Values:
    """Return the points of one arc."""
    amplitude, value = _spread(partial(law.value, flank), law.lag, (begin, end), law.points)
    lasts = flank * (end[1] - begin[1]) * (end[0] - begin[0]) > 0.0
    word = "unstable" if not lasts else "stable" if law.damped else "neutral"
    return _points(value, amplitude, STABILITY[word], in_contact=1)


def _points(value: Values, amplitude: Values, stability: int, in_contact: int) -> Values:
    """Return the columns of a piece of the curve: the named ones, shape (4, n)."""
    return np.stack(np.broadcast_arrays(value, amplitude, stability, in_contact))


def _spread(
    value_at: Callable[[Values], Values],
    lag_at: Callable[[Values, Values], Values],
    ends: tuple[_Place, _Place],
    points: int,
) -> tuple[Values, Values]:
    """Return points of a monotone arc, more of them where it is long, bends or the lag changes.

    Lengths and angles are those in the arc's own frame, scaled to a unit square; a quarter turn
    of the line and half a turn of the phase lag count as much as a side.
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


def _labelled(
    varied: str,
    curves: Sequence[Sequence[Values]],
    axes: Mapping[str, Values],
    further: FurtherAxes | None = None,
) -> xr.Dataset:
    """Return the dataset of curves, one for each point of the grid of the axes."""
    longest = max(sum(piece.shape[1] for piece in pieces) for pieces in curves)
    beyond = [np.nan, np.nan, STABILITY["absent"], 0, -1]
    table = np.tile(np.reshape(beyond, (5, 1, 1)), (len(curves), longest))
    for row, pieces in enumerate(curves):
        first = 0
        for number, piece in enumerate(pieces):
            here = slice(first, first + piece.shape[1])
            table[:4, row, here], table[4, row, here] = piece, number
            first = here.stop
    value, amplitude, *flags = table.reshape(5, *(axis.size for axis in axes.values()), longest)
    grid = dict(zip(axes, np.meshgrid(*axes.values(), indexing="ij"), strict=True))
    parameters = {name: values[..., None] for name, values in grid.items()} | {varied: value}
    columns = {
        varied: value,
        "amplitude": amplitude,
        "phase_lag": _phase_lag(amplitude, **parameters),
    }
    coordinates: dict[str, Column] = {
        name: (name, axis) for name, axis in axes.items() if name not in PAPERS
    }
    if further is not None:  # single numbers are no dimensions
        coordinates |= further.coordinates
    dims = (*(name for name, (dim, _) in coordinates.items() if dim), "point")
    sizes = (*(axes[str(name)].size for name in dims[:-1]), longest)
    names = ("stability", "in_contact", "piece")
    columns |= {name: flag.astype(np.int8) for name, flag in zip(names, flags, strict=True)}
    return labelled_dataset(
        "Response curve of a rotor with Hertz contact and clearance"
        if further is None
        else "Response curve of a rotor with contact and clearance",
        {name: (dims, column.reshape(sizes)) for name, column in columns.items()},
        coordinates | {"point": ("point", np.arange(longest))},
        {"source": _SOURCE, "references": _REFERENCES},
        kind="response_curve",
    )


def _phase_lag(
    amplitude: Values,
    omega: float | Values,
    zeta: float | Values,
    delta0: float | Values,
    shaft_stiffness: Values | None = None,
    contact_exponent: Values | None = None,
    contact_damping: Values | None = None,  # noqa: ARG001
    friction: Values | None = None,
) -> Values:
    stiffness, loss = secant_stiffness(amplitude, delta0), 2.0 * zeta * omega
    if shaft_stiffness is not None and contact_exponent is not None:
        clearance = np.asarray(delta0)
        _, stiffness = stiffnesses(amplitude, clearance, contact_exponent)
        loss = loss if friction is None else loss + friction * stiffness
        stiffness = stiffness + shaft_stiffness
    return np.asarray(np.arctan2(loss, stiffness - omega * omega))


def _checked_limits(limits: object, *, smallest: float = 0.0) -> _Place:
    """Return the two ends of a range."""
    ends = check_axis("limits", limits, smallest=smallest, largest=LARGEST_NUMBER)
    if ends.size != 2 or ends[0] >= ends[1]:
        raise InputError(f"limits must be two numbers, the lower first, got {shown(limits)}")
    return float(ends[0]), float(ends[1])
