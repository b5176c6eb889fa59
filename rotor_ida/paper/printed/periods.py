"""Eq. (17) as printed: natural frequency and period of free vibration."""

from __future__ import annotations

import math

from rotor_ida.checks import check_positive


def natural_frequency(amplitude: float) -> float:
    """Return ``sqrt(A**0.5)``, eq. (17a).

    Parameters
    ----------
    amplitude : float
        Amplitude A [1], above zero.

    Returns
    -------
    float
        Frequency [1].

    Raises
    ------
    InputError
        If `amplitude` is not a positive finite number.

    Notes
    -----
    Right for a whirl on a circle without clearance. For motion on a line, which is what Fig. 5
    shows, it is wrong: `rotor_ida.closed_forms.planar_period`.

    References
    ----------
    Eq. (17a) of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> natural_frequency(16.0)
    2.0
    """
    return math.sqrt(math.sqrt(check_positive("amplitude", amplitude)))


def period(amplitude: float) -> float:
    """Return ``2 pi/sqrt(A**0.5)``, eq. (17b).

    Parameters
    ----------
    amplitude : float
        Amplitude A [1], above zero.

    Returns
    -------
    float
        Period [1].

    Raises
    ------
    InputError
        If `amplitude` is not a positive finite number.

    Notes
    -----
    Right for a whirl on a circle without clearance; on a line it is 4.746 % too short. It falls
    with the amplitude, though section 3.2 says that it grows.

    References
    ----------
    Eq. (17b) and section 3.2 of the paper, Mechanika 25(6), 2019.

    Examples
    --------
    >>> round(period(2.0), 5), round(period(8.0), 5)
    (5.28351, 3.736)
    """
    return 2.0 * math.pi / natural_frequency(amplitude)
