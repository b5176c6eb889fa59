"""The response curve over the clearance."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_count, check_positive
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.closed_forms.contacting_whirls import root_between
from rotor_ida.closed_forms.curve_tracing import (
    MOST_POINTS,
    Chain,
    CurveLaw,
    Piece,
    Place,
    check_damped,
    checked_limits,
    driven,
    labelled_curves,
    marks_at,
    piece_of,
    traced,
)
from rotor_ida.closed_forms.peaks import SMALLEST_DAMPING
from rotor_ida.closed_forms.rotor_columns import RotorColumns, whirls_asked
from rotor_ida.closed_forms.synchronous import SMALLEST_SPEED, whirls_in_contact
from rotor_ida.model.contact import HERTZ_EXPONENT, contact_force
from rotor_ida.model.parameters import Parameters, check_clearance_needed
from rotor_ida.model.rotor import Rotor


def clearance_curve(
    rotor: Rotor | None = None,
    *,
    limits: tuple[float, float],
    points: int = 200,
    **varied: Unpack[Parameters],
) -> xr.Dataset:
    """Compute the response curve over the clearance: all synchronous whirls, in order along it.

    Parameters
    ----------
    rotor : Rotor, optional
        The rotor, with any clearance. Without it, ``omega`` and ``zeta`` must be given.
    limits : tuple of two floats
        Smallest and largest clearance [dimensionless].
    points : int
        Number of points from one fold, tip, first touch or limit to the next.
    **varied : float or array_like, shape (n,)
        Parameters of `Rotor` by name [dimensionless], as for `synchronous_response`, all but
        ``delta0``. The speed must be above 0.

    Returns
    -------
    Dataset
        On (omega, zeta, point), with other dimensions as for `folds` before ``point``:
        ``delta0`` and the other variables of `response_curve`.

    Raises
    ------
    InputError
        If `limits` are not two clearances, the smaller one first; if a damping ratio is between 0
        and 1e-20, or 0 in a linear contact without friction; or if `synchronous_response` does not
        accept a value.

    Notes
    -----
    With ``q = omega**2`` a whirl of amplitude A needs ``s = q +- sqrt(q**2/A**2 - 4 zeta**2 q)``,
    so ``A <= omega/(2 zeta)``. As ``s = u**3/A`` (the Hertz exponent), the clearance is
    ``A - (s A)**(2/3)``. The flanks meet at the largest A, where theta is a quarter turn; without
    damping they never do. On the stiffer flank, with theta below a quarter turn, a whirl is stable
    where the clearance rises with A; on the softer one where it falls.

    There is at most one fold on either side of the largest value of

        ``g(w) = (R - w) (w**2/(1 + w**2))**(1/6)``,  ``R = omega/(2 zeta)``,

    at ``3 w**3 + 4 w = R``: where ``g = (2/3) (omega**2 r)**(2/3) r/R`` with ``r**2 = 1 + R**2``,
    and there ``A = R (R w + 1)/(r sqrt(1 + w**2))``. That is the derivative of the clearance
    by theta, with ``w = -tan(theta + arctan(1/R))``. Without damping the fold is at
    ``A = 1 + (8/27) q**2``.

    A shaft takes its stiffness kappa from s. Below its resonance, ``q <= kappa``, all whirls in
    contact lie on the stiffer flank. In a linear contact the clearance is ``A - s A``. Friction
    rotates the contact force (see `contacting_whirls`): with ``m = 1 + mu**2``,
    ``p = (q - kappa - 2 mu zeta omega)/m`` and ``q' = q/sqrt(m)`` the force is
    ``p A + q' cos(t)``, where ``A = A_m sin(t)`` and ``A_m = q' m/(2 zeta omega + mu (q - kappa))``
    is the largest amplitude. The folds are those above with ``R = A_m p/q'``, ``q'`` for q and
    A_m for the factors R and 1/R of A and g.

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
    span, count = checked_limits(limits), check_count("points", points, 2, MOST_POINTS)
    ranges = {
        "omega": (SMALLEST_SPEED, LARGEST_NUMBER),
        "zeta": (SMALLEST_DAMPING, LARGEST_NUMBER),
    }
    left_out = {"delta0": "it varies between the limits"}
    asked = whirls_asked(clearance_curve, rotor, varied, ranges, left_out)
    check_positive("omega", float(asked.values("omega").min()))
    check_damped(asked)
    if span[0] == 0.0:
        names = ("friction", "contact_damping")
        check_clearance_needed({name: float(asked.values(name).max()) for name in names})
    grid = RotorColumns.of(asked.columns)
    curves = []
    for row in range(asked.points):
        pieces = _pieces(grid[row], span, count)
        if grid.contact_damping[row] > 0.0 or grid.friction[row] > 0.0:
            pieces = [driven(piece, "delta0", grid[row]) for piece in pieces]
        curves.append(pieces)
    return labelled_curves("delta0", curves, asked)


@dataclass(frozen=True, slots=True)
class _WhirlsAtSpeed:
    """The whirls of one speed: with ``A = largest sin(t)`` the force is ``p A + q cos(t)``.

    The angle t is the phase lag less the angle of friction: see `clearance_curve`.
    """

    p: float
    q: float
    largest: float
    hertz: bool

    @classmethod
    def of(cls, rotor: RotorColumns) -> _WhirlsAtSpeed:
        omega, mu = float(rotor.omega), float(rotor.friction)
        loss, lead = 2.0 * float(rotor.zeta) * omega, 1.0 + mu * mu
        q = omega * omega
        p = q - float(rotor.shaft_stiffness)
        across = abs(loss + mu * p) / lead
        p, q = (p - mu * loss) / lead, q / math.sqrt(lead)
        largest = q / across if across > 0.0 else math.inf
        return cls(p, q, largest, float(rotor.contact_exponent) == HERTZ_EXPONENT)

    def depth(self, force: npt.ArrayLike) -> Values:
        """Return the indentation that a force needs."""
        return np.cbrt(force) ** 2 if self.hertz else np.asarray(force)

    def clearance(self, flank: int, A: Values) -> Values:
        """Return the clearance at which a whirl has an amplitude."""
        sine = A / self.largest
        cosine = flank * np.sqrt(np.maximum((1.0 - sine) * (1.0 + sine), 0.0))
        return np.asarray(A - self.depth(np.maximum(self.p * A + self.q * cosine, 0.0)))

    def chain(self, touch: float) -> Chain:
        """Return the curve, from the amplitude of the contact-free whirl on."""
        first = top = Place(touch, touch)  # the top below the resonance of the shaft
        if self.p > 0.0:
            finite = math.isfinite(self.largest)
            value = float(self.clearance(1, np.array(self.largest))) if finite else math.inf
            top = Place(self.largest, value)
        return Chain(-1, first, top, Place(0.0, -float(self.depth(self.q))))

    def turns(self) -> Values:
        """Return the amplitudes of the folds, all on the softer flank."""
        p, q = self.p, self.q
        if p <= 0.0:
            return np.empty(0)
        if math.isinf(self.largest):
            return np.array([(q + (8.0 / 27.0) * p**3) / p])
        if not self.hertz:
            slack = (1.0 - p) * self.largest
            found = [self.largest * slack / math.hypot(slack, q)] if slack > 0.0 else []
            return np.array(found)
        R = self.largest * p / q
        r = math.hypot(1.0, R)
        w = _turns_of_hertz(R, (2.0 / 3.0) * math.cbrt(q * r) ** 2 * (r / self.largest))
        return np.asarray(self.largest * (R * w + 1.0) / (r * np.hypot(1.0, w)))


def _turns_of_hertz(R: float, bound: float) -> Values:
    """Return where ``(R - w) (w**2/(1 + w**2))**(1/6)`` is `bound`: see `clearance_curve`."""

    def excess(w: float) -> float:
        return (R - w) * math.cbrt(w / math.hypot(1.0, w)) - bound

    summit = root_between(lambda w: 3.0 * w**3 + 4.0 * w - R, 0.0, R)
    if excess(summit) <= 0.0:
        return np.empty(0)
    brackets = ((0.0, summit), (summit, R))
    return np.array([root_between(excess, *ends) for ends in brackets])


def _pieces(rotor: RotorColumns, limits: tuple[float, float], points: int) -> list[Piece]:
    """Return the pieces of the curve over the clearance of one rotor."""
    zeta, kappa, mu = (float(each) for each in (rotor.zeta, rotor.shaft_stiffness, rotor.friction))
    whirls = _WhirlsAtSpeed.of(rotor)
    touch = min(abs(complex(complex_amplitude(rotor.omega, zeta, kappa))), whirls.largest)
    pieces = []
    if touch < limits[1]:
        ends = np.array([max(limits[0], touch), limits[1]])
        word = "stable" if zeta > 0.0 and kappa > 0.0 else "neutral"
        pieces.append(piece_of(ends, np.full(2, touch), word, in_contact=0))

    def lag(A: Values, delta0: Values) -> Values:
        push = contact_force(A, delta0, rotor.contact_exponent)
        across = 2.0 * zeta * rotor.omega * A + mu * push
        return np.asarray(np.arctan2(across, push - (rotor.omega**2 - kappa) * A))

    at_limits = np.array(limits)
    known = whirls_in_contact(RotorColumns.of(asdict(rotor) | {"delta0": at_limits}))
    rows, columns = np.nonzero(np.isfinite(known.amplitude))
    cosine = np.cos(known.phase_lag[rows, columns] - math.atan(mu))
    marks = marks_at(cosine, known.amplitude[rows, columns], at_limits[rows])
    turns = whirls.turns()
    marks += marks_at(np.full(turns.size, -1.0), turns, whirls.clearance(-1, turns))
    curve = CurveLaw(whirls.clearance, lag, limits, points, zeta > 0.0)
    return pieces + traced([whirls.chain(touch)], marks, curve)
