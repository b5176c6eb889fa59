"""The sense of a whirl, and its speed over the spin speed, from the motion itself.

One definition for signals, limit cycles and attractors. It does not depend on orders of the speed:
a forward rub is forward whatever the strongest line beside 1X is.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from rotor_ida.arrays import Values

Complex = npt.NDArray[np.complex128]
# If the forward and the backward part differ by less than this fraction of their sum, the motion is
# along a line: an ellipse whose minor axis is less than this fraction of the major one.
ALONG_A_LINE = 0.05


def whirl_over_spin(
    turned: npt.ArrayLike, angle: npt.ArrayLike, forward: npt.ArrayLike, backward: npt.ArrayLike
) -> tuple[Values, npt.NDArray[np.int8]]:
    """Return the mean speed of a whirl over the spin speed, and the sense of the whirl.

    Parameters
    ----------
    turned, angle : float or array_like
        Angle by which the displacement rotates about its mean, positive forwards, and angle by
        which the rotor rotates in the same time [rad].
    forward, backward : float or array_like
        Root sum of squares of the amplitudes of all forward and of all backward lines, in any unit.

    Returns
    -------
    ratio : ndarray
        ``turned/angle``; 0 if there is no sense [dimensionless].
    sense : ndarray of int8
        1 for forward, -1 for backward, 0 for none.

    Notes
    -----
    There is a sense if the two amplitudes differ by more than a twentieth of their sum, and the
    displacement rotates in the direction of the larger one. A vibration along a line has pairs of
    lines of equal height and rotates either way by noise: it has no sense.

    References
    ----------
    C. W. Lee, "Vibration Analysis of Rotors", Kluwer, 1993: forward and backward components.

    Examples
    --------
    >>> ratio, sense = whirl_over_spin([6.28, -8.2, 3.1], 6.28, [1.0, 0.2, 1.0], [0.4, 1.0, 1.01])
    >>> ratio.round(3), sense
    (array([ 1.   , -1.306,  0.   ]), array([ 1, -1,  0], dtype=int8))
    """
    about, ahead, back = (
        np.asarray(each, dtype=np.float64) for each in (turned, forward, backward)
    )
    excess = ahead - back
    clear = (np.abs(excess) > ALONG_A_LINE * (ahead + back)) & (excess * about > 0.0)
    sense = np.where(clear, np.sign(about), 0.0).astype(np.int8)
    return np.where(clear, about / np.asarray(angle, dtype=np.float64), 0.0), sense


def steps_of_turning(z: Complex) -> Values:
    """Return the angles from each displacement to the next, from -pi to pi."""
    return np.asarray(np.angle(z[1:] * z[:-1].conj()), dtype=np.float64)


def forward_and_backward(z: Complex) -> tuple[Complex, Complex]:
    """Return the forward and backward parts of displacements at equally spaced times.

    They are the parts of positive and of negative frequencies; neither contains the mean.

    Examples
    --------
    >>> angle = 2.0 * np.pi * np.arange(640) / 64
    >>> ahead, back = forward_and_backward(0.7 * np.exp(1j * angle) + 0.2 * np.exp(-2j * angle))
    >>> abs(ahead[300:340]).mean().round(2).item(), abs(back[300:340]).mean().round(2).item()
    (0.7, 0.2)
    """
    from scipy.fft import fft, ifft, next_fast_len  # noqa: PLC0415 - takes long to import

    # trailing zeros separate its end from its start
    lines = fft(z - z.mean(), 2 * next_fast_len(z.size * 5 // 8 + 1))
    half = lines.size // 2
    lines[0] = lines[half] = 0.0
    ahead = lines.copy()
    ahead[half:], lines[:half] = 0.0, 0.0
    return ifft(ahead)[: z.size], ifft(lines)[: z.size]
