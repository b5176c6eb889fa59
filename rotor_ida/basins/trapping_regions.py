"""Trapping regions: ellipsoids around a stable whirl that provably no orbit leaves.

On the rotating axes a synchronous whirl is an equilibrium. A quadratic Lyapunov function ``V`` of
the distance to it in state space falls along every orbit in the ellipsoid ``V <= 1``. So no orbit
leaves the ellipsoid, and all orbits in it converge to the whirl.

Notes
-----
Let ``xi`` be the state minus that of the whirl, and ``v`` its position. The equation is linear
except for the contact force F, for which the mean-value form gives

    F(v) - F(v*) = K (v - v*),    K = mean of DF along the segment from v* to v,
    DF = s I + (f' - s) n n^T,    n = v/|v|,  s = f(|v|)/|v|.

So ``xi' = (L - E K) xi`` with a constant L and a symmetric 2 x 2 matrix K that varies. Over a
convex set of positions K lies in the smallest box (three entries) that contains every DF there: a
mean of members of a convex set is a member. ``d/dt xi^T P xi = xi^T (J^T P + P J) xi`` with
``J = L - E K`` is affine in K. So if ``J^T P + P J`` is negative definite at the eight corners of
the box, it is so throughout, with one margin, and V decays exponentially: quadratic stability over
a polytope of matrices [1]_. The positions of the ellipsoid ``xi^T P xi <= c`` are an ellipse with
half-widths ``sqrt(c S)``, where ``S`` is the diagonal of ``P^-1``; its bounding rectangle, along
and across the whirl, gives the box. The largest such c is found by bisection. P is the form of
largest volume among those that weigh the two modes of the linear motion differently; a free search
over all P gained 5 % in width. The rectangle excludes the clearance and the centre, where DF is
not as written above.

A shaft changes only L. With contact damping c the force ``N = f(r) (1 + c r')`` also depends on
the velocity. With w the velocity on the rotating axes, t normal to n, and ``g = 1 + c n.w``,

    DF = g s I + g (f' - s) n n^T + c f (t.w)/r n t^T      by v,      c f n n^T      by w,

so the box has seven entries, four and three, and 128 corners. The bound on w over the ellipsoid
bounds g, which must stay above 0: where contact is lost the force is not as written.

Friction rotates the contact force while the disc slides forwards, ``N (1 + i mu) n``: each DF is
multiplied by one constant matrix, so J stays affine in the same entries, though K is no longer
symmetric. The slip speed ``t.w + omega (|v| + rho)`` must stay above 0 on the ellipsoid, where
|t.w| is bounded in the same way.

References
----------
.. [1] Boyd, El Ghaoui, Feron and Balakrishnan, Linear Matrix Inequalities in System and Control
   Theory, 1994, chapter 5: quadratic stability and invariant ellipsoids of polytopic differential
   inclusions; section 4.3: a nonlinear system in such an inclusion, by the mean-value theorem.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values
from rotor_ida.basins.kernel import REGION, Rows
from rotor_ida.closed_forms import synchronous_response
from rotor_ida.closed_forms.restoring_law import stiffnesses
from rotor_ida.model.contact import contact_force
from rotor_ida.model.equations import rotating_jacobian
from rotor_ida.model.rotor import Rotor
from rotor_ida.schema import STABILITY

# V must fall at this fraction of the fastest possible rate or faster: far more than the rounding of
# matrices, which is not bounded by interval arithmetic.
MARGIN = 1e-6
# The largest level of a form is determined to this relative accuracy,
LEVEL_RTOL = 1e-3
# or for this number of steps: if there is none the bisection tends to 0.
BISECTIONS = 40
# Weights of the faster mode against the slower one, each in its squared amplitude.
MODE_RATIOS = np.geomspace(1e-2, 1e2, 17)
# Near a double eigenvalue the modes are nearly parallel: above this condition number they are not
# used.
MOST_SKEW = 1e6
# Too close to a fold, decay slower than this fraction of the fastest motion is lost in rounding.
SLOWEST = 1e-9
# Forms with axes more unequal than this, squared, are refused: rounding could decide.
MOST_ECCENTRIC = 1e10


@dataclass(frozen=True)
class TrappingRegion:
    """An ellipsoid of states that all converge to one stable whirl in contact.

    Parameters
    ----------
    amplitude, phase_lag : float
        The whirl [dimensionless], [rad].
    centre : ndarray, shape (4,)
        Its state on the rotating axes [dimensionless].
    form : ndarray, shape (4, 4)
        Positive definite P: the region is ``(z - centre)^T P (z - centre) <= 1``. All infinite
        if no such region was found.
    """

    amplitude: float
    phase_lag: float
    centre: Values
    form: Values

    @property
    def exists(self) -> bool:
        """Whether a region was found: close to a fold, or to first touch, there may be none."""
        return bool(np.isfinite(self.form).all())

    @cached_property
    def row(self) -> Rows:
        """The region in the kernel's format."""
        if not self.exists:  # with a centre at infinity it contains nothing
            return np.array((np.full(4, np.inf), np.eye(4)[np.triu_indices(4)]), dtype=REGION)
        factor = np.linalg.cholesky(self.form).T
        return np.array((self.centre, factor[np.triu_indices(4)]), dtype=REGION)

    def holds(self, states: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return which of the states, shape (..., 4) on the rotating axes, lie in the region."""
        offset = np.asarray(states, dtype=np.float64) - self.centre
        if not self.exists:
            return np.zeros(offset.shape[:-1], dtype=np.bool_)
        return np.asarray(np.einsum("...i,ij,...j->...", offset, self.form, offset) <= 1.0)


def trapping_regions(rotor: Rotor) -> list[TrappingRegion]:
    """Return a trapping region for each stable whirl in contact of a damped, turning rotor.

    Examples
    --------
    >>> regions = trapping_regions(Rotor(omega=1.7, zeta=0.07, delta0=0.0))
    >>> [round(each.amplitude, 4) for each in regions]
    [1.8796, 9.4872]
    """
    return [_trapping_region(rotor, *whirl) for whirl in _stable_whirls(rotor)]


def _stable_whirls(rotor: Rotor) -> list[tuple[float, float]]:
    """Return amplitude and phase lag of each stable whirl in contact."""
    whirls = synchronous_response(rotor, load=0.0).squeeze()
    held = np.atleast_1d((whirls.in_contact == 1) & (whirls.stability == STABILITY["stable"]))
    amplitudes = np.atleast_1d(whirls.amplitude)[held].tolist()
    lags = np.atleast_1d(whirls.phase_lag)[held].tolist()
    return list(zip(amplitudes, lags, strict=True))


def _state_on(rotor: Rotor, amplitude: float, lag: float) -> Values:
    """Return the state of a synchronous whirl on the rotating axes."""
    position = amplitude * complex(math.cos(lag), -math.sin(lag))
    velocity = 1j * rotor.omega * position
    return np.array([position.real, position.imag, velocity.real, velocity.imag])


def _trapping_region(rotor: Rotor, amplitude: float, lag: float) -> TrappingRegion:
    """Return the largest of the regions suggested by the linear motion."""
    problem = _Problem(rotor, amplitude)
    forms = problem.candidates()
    levels = problem.largest_levels(forms)
    held = levels > 0.0
    centre = _state_on(rotor, amplitude, lag)
    if not held.any():
        return TrappingRegion(amplitude, lag, centre, np.full((4, 4), np.inf))
    # the region of largest volume
    regions = forms[held] / levels[held, None, None]
    best = regions[np.argmin(np.linalg.slogdet(regions)[1])]
    # from offsets in the plane to offsets along and across the whirl
    turn = np.kron(np.eye(2), np.array([[math.cos(lag), -math.sin(lag)],
                                        [math.sin(lag), math.cos(lag)]]))  # fmt: skip
    return TrappingRegion(amplitude, lag, centre, turn.T @ best @ turn)


class _Problem:
    """The motion near one whirl, on axes along and across it, for many forms P at a time."""

    def __init__(self, rotor: Rotor, amplitude: float):
        self.rotor, self.amplitude = rotor, amplitude
        # factor of friction on the normal force, while the disc slides forwards
        self.friction = np.array([[1.0, -rotor.friction], [rotor.friction, 1.0]])
        self.linear = rotating_jacobian((0.0, 0.0, 0.0, 0.0), Rotor(
            omega=rotor.omega, zeta=rotor.zeta, delta0=1.0,
            shaft_stiffness=rotor.shaft_stiffness))  # fmt: skip

    def stiffnesses(self, radii: Values) -> tuple[Values, Values]:
        """Return the slope and the secant stiffness of the contact force at some radii."""
        return stiffnesses(
            radii, np.asarray(self.rotor.delta0), np.asarray(self.rotor.contact_exponent)
        )

    def matrices(self, along: Values, across: Values, mixed: Values) -> Values:
        """Return J for stiffness matrices K, shape (..., 4, 4)."""
        found = np.tile(self.linear, (*along.shape, 1, 1))
        stiffness = np.stack([along, mixed, mixed, across], axis=-1)
        found[..., 2:, :2] -= self.with_friction(stiffness.reshape(*along.shape, 2, 2))
        return found

    def damped_matrices(self, stiffness: Values, drag: Values) -> Values:
        """Return J if the force depends on v and w by these matrices, shape (..., 2, 2)."""
        found = np.tile(self.linear, (*stiffness.shape[:-2], 1, 1))
        # w is the velocity of the state less that of the axes, i omega v
        turned = self.rotor.omega * np.array([[0.0, -1.0], [1.0, 0.0]])
        found[..., 2:, :2] -= self.with_friction(stiffness - drag @ turned)
        found[..., 2:, 2:] -= self.with_friction(drag)
        return found

    def with_friction(self, of_normal: Values) -> Values:
        """Return the derivative of the total force from that of the normal force."""
        return self.friction @ of_normal if self.rotor.friction > 0.0 else of_normal

    def corners(self, half_along: Values, half_across: Values) -> Values:
        """Return J at the corners of the boxes that contain DF on rectangles, (m, 8, 4, 4)."""
        nearest = self.amplitude - half_along
        farthest = np.hypot(self.amplitude + half_along, half_across)
        angle = np.arctan2(half_across, nearest)
        # f' and s grow with the radius, f' - s does or falls
        tangent, secant = self.stiffnesses(np.stack([nearest, farthest]))
        excess = np.sort(tangent - secant, axis=0)
        along = (secant[0] + excess[0] * np.cos(angle) ** 2, tangent[1])
        across = (secant[0], secant[1] + excess[1] * np.sin(angle) ** 2)
        most = excess[1] * 0.5 * np.sin(2.0 * np.minimum(angle, 0.25 * math.pi))
        boxes = [self.matrices(a, b, c) for a in along for b in across for c in (-most, most)]
        return np.stack(boxes, axis=1)

    def damped_corners(self, half: Values) -> Values:
        """Return the same with contact damping, shape (m, 128, 4, 4).

        `half`, shape (m, 4), contains the half-widths of v and of w, each along and across.
        """
        half_along, half_across, w_along, w_across = half.T
        nearest = self.amplitude - half_along
        farthest = np.hypot(self.amplitude + half_along, half_across)
        angle = np.arctan2(half_across, nearest)
        sine = np.sin(np.minimum(angle, 0.5 * math.pi))
        least, product = np.cos(angle) ** 2, 0.5 * np.sin(2.0 * np.minimum(angle, 0.25 * math.pi))
        radii, damping = np.stack([nearest, farthest]), self.rotor.contact_damping
        tangent, secant = self.stiffnesses(radii)
        push = contact_force(radii, self.rotor.delta0, self.rotor.contact_exponent)
        change = damping * (w_along + sine * w_across)
        low, high = 1.0 - change, 1.0 + change
        excess = np.sort(tangent - secant, axis=0)
        sideways = damping * secant[1] * (sine * w_along + w_across)
        drag = damping * push
        turning = high * excess[1] * product
        entries = (
            (low * (secant[0] + excess[0] * least) - sideways * product,
             high * tangent[1] + sideways * product),
            (-turning - sideways, turning + sideways),
            (-turning - sideways * sine**2, turning + sideways * sine**2),
            (low * secant[0] - sideways * product,
             high * (secant[1] + excess[1] * sine**2) + sideways * product),
            (drag[0] * least, drag[1]),
            (-drag[1] * product, drag[1] * product),
            (np.zeros_like(sine), drag[1] * sine**2),
        )  # fmt: skip
        box = np.array(list(itertools.product(*entries)))  # (128, 7, m)
        stiffness = np.moveaxis(box[:, :4], 2, 0).reshape(-1, 128, 2, 2)
        braking = np.moveaxis(box[:, [4, 5, 5, 6]], 2, 0).reshape(-1, 128, 2, 2)
        return self.damped_matrices(stiffness, braking)

    def fall(self, forms: Values, levels: Values) -> npt.NDArray[np.bool_]:
        """Return for which forms V falls everywhere on the ellipsoid ``xi^T P xi <= level``."""
        inverse: Values = np.linalg.inv(forms).astype(np.float64, copy=False)
        along, across = (np.sqrt(levels * inverse[:, place, place]) for place in (0, 1))
        inside = self.amplitude - along > self.rotor.delta0
        if self.rotor.friction > 0.0:
            inside &= self.slides(inverse, levels)
        if self.rotor.contact_damping > 0.0:
            w_along, w_across = self.widths_of_velocity(inverse, levels)
            # n.w, with n at most at a right angle to the whirl
            inside &= self.rotor.contact_damping * (w_along + w_across) < 1.0
            half = np.stack([along, across, w_along, w_across], axis=1)
            matrices = self.damped_corners(half[inside])
        else:
            matrices = self.corners(along[inside], across[inside])
        weights = forms[inside, None]
        rates = np.swapaxes(matrices, -1, -2) @ weights + weights @ matrices
        rates += 2.0 * MARGIN * self.rotor.zeta * weights
        inside[inside] = np.linalg.eigvalsh(rates).max(axis=(1, 2)) < 0.0
        return inside

    def slides(self, inverse: Values, levels: Values) -> npt.NDArray[np.bool_]:
        """Return on which ellipsoids that avoid the axis the disc slides forwards."""
        along, across = (np.sqrt(levels * inverse[:, place, place]) for place in (0, 1))
        w_along, w_across = self.widths_of_velocity(inverse, levels)
        nearest = np.maximum(self.amplitude - along, 0.0)
        sine = across / np.hypot(nearest, across)
        rim = nearest + (self.rotor.disc_radius or 0.0)
        return np.asarray(self.rotor.omega * rim > (1.0 + MARGIN) * (sine * w_along + w_across))

    def widths_of_velocity(self, inverse: Values, levels: Values) -> tuple[Values, Values]:
        """Return the largest w on some ellipsoids, along and across the whirl."""
        omega = self.rotor.omega
        rows = np.array([[0.0, omega, 1.0, 0.0], [-omega, 0.0, 0.0, 1.0]])
        along, across = np.sqrt(levels * np.einsum("ki,nij,kj->kn", rows, inverse, rows))
        return along, across

    def largest_levels(self, forms: Values) -> Values:
        """Return the largest level of each form, found by bisection; 0 where there is none."""
        room = self.amplitude - self.rotor.delta0
        high = room**2 / np.linalg.inv(forms)[:, 0, 0]
        low = np.zeros_like(high)
        for _ in range(BISECTIONS):
            open_ = (low == 0.0) | (high - low >= LEVEL_RTOL * low)
            if not open_.any():
                break
            middle = np.where(low > 0.0, 0.5 * (low + high), 0.1 * high)[open_]
            falls = self.fall(forms[open_], middle)
            low[open_] = np.where(falls, middle, low[open_])
            high[open_] = np.where(falls, high[open_], middle)
        return low

    def candidates(self) -> Values:
        """Return forms that decrease in the linear motion, with different weights of its modes.

        Except at strong damping, all eigenvalues of a stable whirl have nearly the same real part:
        any weighted sum of the squared amplitudes of its modes falls at their slowest rate.
        """
        radius = np.asarray(self.amplitude)
        tangent, secant = self.stiffnesses(radius)
        drag = self.rotor.contact_damping * float(secant) * self.amplitude
        if drag > 0.0:
            matrix = self.damped_matrices(
                np.diag([float(tangent), float(secant)]), np.diag([drag, 0.0])
            )
        else:
            matrix = self.matrices(np.asarray(tangent), np.asarray(secant), np.zeros(()))
        values, vectors = np.linalg.eig(matrix)
        none = np.empty((0, 4, 4))
        if values.real.max() > -SLOWEST * np.abs(values).max():
            return none
        if np.linalg.cond(vectors) > MOST_SKEW:
            return none
        inverse = np.linalg.inv(vectors[:, np.argsort(np.abs(values.imag))])
        weights = np.stack([np.ones_like(MODE_RATIOS), MODE_RATIOS], axis=-1).repeat(2, axis=-1)
        forms: Values = ((inverse.conj().T * weights[:, None]) @ inverse).real
        # positive definite by a safe margin
        widths = np.linalg.eigvalsh(forms)
        return forms[(widths[:, 0] > 0.0) & (widths[:, -1] < MOST_ECCENTRIC * widths[:, 0])]
