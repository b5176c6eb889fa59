"""What quantities and kinds of response are called in pictures."""

from __future__ import annotations

LABELS = {
    "omega": r"spin speed $\omega$",
    "amplitude": r"amplitude $A$",
    "phase_lag": r"phase lag $\theta$",
    "t": r"time $t$",
    "x": r"displacement $x$",
    "y": r"displacement $y$",
    "vx": "velocity $x$′",
    "vy": "velocity $y$′",
    "deviation": r"distance from the simulated $z$",
    "x_alone": "$x$",
    "y_alone": "$y$",
    "radius": r"radius $|z|$",
    "rotating_x": r"along the unbalance $\operatorname{Re}\,z\,e^{-i\omega t}$",
    "rotating_y": r"across it $\operatorname{Im}\,z\,e^{-i\omega t}$",
    "angle": r"angle from the unbalance $\arg z\,e^{-i\omega t}$ [rad]",
    "radial_velocity": "radial velocity $|z|$′",
    "frequency_over_omega": r"frequency over spin speed $\Omega/\omega$",
    "frequency": r"frequency $\Omega$",
    "whirl_amplitude": r"whirl amplitude $|c|$",
    "force": r"contact force $f$",
    "peak_fraction": "share of contacts up to this force",
    "running_exponent": r"Lyapunov exponent $\lambda$",
    "peak_force": r"peak force $f$",
    "zeta": r"damping ratio $\zeta$",
    "delta0": r"clearance $\delta_0$",
    "restoring_x": r"force $f_x$",
    "restoring_y": r"force $f_y$",
    "potential": r"potential $V$",
    "energy": r"energy $E$",
    "period": r"period $T$",
    "natural": r"natural frequency $2\pi/T$",
    "contact_force": r"contact force $f$",
}
SYMBOLS = {"omega": r"\omega", "zeta": r"\zeta", "delta0": r"\delta_0"}

# What is written with a capital where it has a unit, as in eqs (1)-(9).
IN_UNITS = {
    "t": "time $T$",
    "x": "displacement $X$",
    "y": "displacement $Y$",
    "vx": "velocity $X$′",
    "vy": "velocity $Y$′",
    "deviation": r"distance from the simulated $Z$",
    "x_alone": "$X$",
    "y_alone": "$Y$",
    "radius": "radius $|Z|$",
    "rotating_x": r"along the unbalance $\operatorname{Re}\,Z\,e^{-i\omega t}$",
    "rotating_y": r"across it $\operatorname{Im}\,Z\,e^{-i\omega t}$",
    "radial_velocity": "radial velocity $|Z|$′",
    "force": "contact force $F$",
    "contact_force": "contact force $F$",
    "peak_force": "peak force $F$",
    "restoring_x": "force $F_x$",
    "restoring_y": "force $F_y$",
}

# The words for the kinds of response.
KIND_WORDS = {
    "synchronous": "synchronous response",
    "contact_free": "contact-free response",
    "bouncing": "bouncing",
    "full_contact": "full contact",
    "unresolved": "unresolved",
}


def parameter_text(**values: float) -> str:
    r"""Return parameters as the title of a panel.

    Examples
    --------
    >>> parameter_text(zeta=0.07)
    '$\\zeta = 0.07$'
    """
    return ",  ".join(f"${SYMBOLS[name]} = {value:.4g}$" for name, value in values.items())


def with_error(value: float, error: float) -> str:
    """Return a value with the error of its last digits in brackets, five decimals at most.

    Examples
    --------
    >>> with_error(0.17123, 0.0098)
    '0.171(10)'
    """
    digits = next((digits for digits in range(1, 5) if error >= 0.5 * 10.0**-digits), 5)
    digits = min(digits + 1, 5)
    shown, last = f"{value:.{digits}f}", round(error * 10.0**digits)
    if float(shown) == 0.0:
        shown = shown.lstrip("-")
    return f"{shown}({last})" if last else shown
