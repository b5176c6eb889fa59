"""Flight with a shaft and a load in its textbook form, in 250 digits.

With this many digits cancellation does no harm: stiffness and speed are moved by 1e-60, so that no
resonance and no critical damping is a case of its own.
"""

import itertools

import mpmath

DIGITS = 250
# Speed, damping and stiffness of the shaft.
CASES = {
    "nearly critical": [
        (1.3, 0.9, 0.81 * (1.0 + sign * part))
        for part in (0.0, 1e-16, 3e-14, 1e-12, 1e-8, 1e-4, 1e-1)
        for sign in (-1.0, 1.0)
    ],
    "nearly resonant": [
        (omega, zeta, omega**2 * (1.0 + part))
        for part in (0.0, 1e-16, 1e-12, 1e-8, 1e-4, 0.1)
        for zeta in (0.0, 1e-300, 1e-17, 1e-9, 1e-3)
        for omega in (0.3, 2.7)
    ],
    "soft": [
        *itertools.product((0.0, 1e-4, 1.7), (0.0, 1e-12, 0.07, 2.0), (0.0, 1e-20, 1e-12, 1e-5))
    ],
    "slow": [*itertools.product((0.0, 1e-9, 1e-5, 1e-2), (2.0,), (1e-3, 0.5, 7.0, 100.0))],
}


class Exact:
    """Displacement and velocity on axes that stand still, from a start at a time."""

    def __init__(self, rotor, z0, w0, *, since=0.0):
        with mpmath.workdps(DIGITS):
            aside = mpmath.mpf(10) ** -60
            omega = mpmath.mpf(rotor.omega) + aside / 3
            zeta = mpmath.mpf(rotor.zeta)
            kappa = mpmath.mpf(rotor.shaft_stiffness) + aside
            self.rest = -1j * mpmath.mpf(rotor.load) / kappa
            turned = mpmath.expj(mpmath.mpf(rotor.omega) * mpmath.mpf(since))
            whirl = turned * omega**2 / (kappa - omega**2 + 2j * zeta * omega)
            split = mpmath.sqrt(zeta**2 - kappa + aside**2)
            first, last = -zeta + split, -zeta - split
            off, moving = z0 - whirl - self.rest, w0 - 1j * omega * whirl
            self.terms = [
                (first, (moving - last * off) / (first - last)),
                (last, (first * off - moving) / (first - last)),
                (1j * omega, whirl),
            ]

    def __call__(self, tau):
        with mpmath.workdps(DIGITS):
            moved = [(rate, size * mpmath.exp(rate * tau)) for rate, size in self.terms]
            z = self.rest + mpmath.fsum(size for _, size in moved)
            return z, mpmath.fsum(rate * size for rate, size in moved)

    def slope(self, tau):
        z, v = self(tau)
        with mpmath.workdps(DIGITS):
            return (mpmath.conj(z) * v).real

    def missed_by(self, found, tau):
        """Return the errors of displacement and velocity, of what they come to about then."""
        with mpmath.workdps(DIGITS):
            reached = [self(mpmath.mpf(tau) * part) for part in (1.0, 0.8, 0.63)]
            for place in (0, 1):
                size = max(abs(each[place]) for each in reached)
                if size > 1e-30:  # or it has come to rest
                    yield float(abs(found[place] - reached[0][place]) / size)
