"""What quantities, kinds of response and units are called in pictures.

A figure shows the units that its dataset carries (`rotor_ida.dimensional` chooses them).
"""

from __future__ import annotations

import re
from collections.abc import Mapping

import xarray as xr
from matplotlib.axis import Axis

from rotor_ida.errors import InputError
from rotor_ida.schema import QUANTITIES

LABELS = {
    "omega": r"spin speed $\omega$",
    "speed": r"spin speed $\omega$",
    "shaft_stiffness": r"stiffness of the shaft $\kappa$",
    "contact_damping": "contact damping $c$",
    "contact_exponent": "exponent of the contact $n$",
    "load": r"load $\gamma$",
    "friction": r"friction $\mu$",
    "disc_radius": r"radius of the disc $\rho$",
    "rate": "rate $a$",
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
    "normal_force": r"normal force $N$",
    "slip_speed": r"slip speed $v_s$",
    "whirl_speed": r"whirl speed $\Omega$",
    "zeta": r"damping ratio $\zeta$",
    "delta0": r"clearance $\delta_0$",
    "restoring_x": r"force $f_x$",
    "restoring_y": r"force $f_y$",
    "potential": r"potential $V$",
    "energy": r"energy $E$",
    "period": r"period $T$",
    "natural": r"natural frequency $2\pi/T$",
    "contact_force": r"contact force $f$",
    "multiplier_real": r"multiplier $\operatorname{Re}\,\mu$",
    "multiplier_imag": r"$\operatorname{Im}\,\mu$",
}
SYMBOLS = {
    "omega": r"\omega", "zeta": r"\zeta", "delta0": r"\delta_0", "shaft_stiffness": r"\kappa",
    "contact_exponent": "n", "contact_damping": "c", "load": r"\gamma",
    "friction": r"\mu", "disc_radius": r"\rho",
}  # fmt: skip

SEPARATOR = ",  "

# What is written with a capital where it has a unit, as in eqs (1)-(9).
IN_UNITS = {
    "t": "time $T$",
    "speed": "spin speed",
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
    "normal_force": "normal force $N$",
    "slip_speed": "slip speed $V_s$",
    "restoring_x": "force $F_x$",
    "restoring_y": "force $F_y$",
}

# The words for the kinds of response.
KIND_WORDS = {
    "synchronous": "synchronous response",
    "contact_free": "contact-free response",
    "bouncing": "bouncing",
    "full_contact": "full contact",
    "rolling": "rolling (dry whip)",
    "touching": "touching ever more slightly",
    "quasi_periodic": "quasi-periodic",
    "chaotic": "chaotic",
    "unresolved": "unresolved",
}


def parameter_text(values: Mapping[str, float]) -> str:
    r"""Return parameters as the title of a panel.

    Examples
    --------
    >>> parameter_text({"zeta": 0.07})
    '$\\zeta = 0.07$'
    """
    return SEPARATOR.join(f"${SYMBOLS[name]} = {value:.4g}$" for name, value in values.items())


def number_text(value: float, form: str = "#.3g") -> str:
    r"""Return a number as mathematical text, small and large ones with a power of ten.

    Examples
    --------
    >>> number_text(1.88), number_text(9.4e-6)
    ('1.88', '9.40 \\times 10^{-6}')
    """
    digits, _, power = format(value, form).partition("e")
    return rf"{digits} \times 10^{{{int(power)}}}" if power else digits


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


def unit_of(variable: xr.DataArray | xr.Variable) -> str:
    """Return the unit of a variable as a reader writes it; nothing for numbers and angles.

    Examples
    --------
    >>> unit_of(xr.DataArray([1.0], attrs={"units": "um s-1"}))
    'µm/s'
    """
    unit = _units(variable)
    if unit in ("", "1", "radian"):
        return ""
    return re.sub("^u", "µ", unit).replace(" s-1", "/s").replace("s-1", "1/s")


def label_of(name: str, variable: xr.DataArray, *, words: str | None = None) -> str:
    """Return the label of an axis: name and symbol, and the unit of the variable, if it has one.

    Examples
    --------
    >>> label_of("radius", xr.DataArray([1.0], attrs={"units": "um"}))
    'radius $|Z|$ [µm]'
    >>> label_of("radius", xr.DataArray([1.0], attrs={"units": "1"}))
    'radius $|z|$'
    """
    unit = unit_of(variable)
    if not unit:
        return words or LABELS[name]
    return f"{words or IN_UNITS.get(name, LABELS[name])} [{unit}]"


def label_axis(axis: Axis, name: str, variable: xr.DataArray, *, words: str | None = None) -> None:
    """Label an axis with a variable and its unit, and hold the axis to that unit."""
    hold_units(axis, variable)
    axis.set_label_text(label_of(name, variable, words=words))


def hold_units(axis: Axis, variable: xr.DataArray) -> None:
    """Refuse a variable in other units than those in which the axis shows values already.

    Axes that share an axis share its units.
    """
    here, there = _units(variable), axis.units
    if there is not None and here != there:
        raise InputError(
            f"what is drawn on one axis must have its units, {there!r} ('1' is dimensionless), "
            f"got {here!r}"
        )
    reached = [(ax, ax.dataLim.frozen()) for ax in axis.axes.figure.axes]
    axis.set_units(here)
    # at new units matplotlib looks at lines anew, and forgets how far bars and areas reach
    for ax, limits in reached:
        ax.dataLim.set(limits)


def scale_of(dataset: xr.Dataset, kind: str) -> float:
    """Return what a dimensionless 1 is in the units of the dataset: 1 where it has none."""
    return float(dataset.attrs.get(f"{kind}_scale", 1.0))


def check_same_units(name: str, dataset: xr.Dataset, shown: xr.Dataset) -> None:
    """Refuse two datasets for one picture whose units or scales differ."""
    here, there = _measures(dataset), _measures(shown)
    for kind in there:
        if here.get(kind, there[kind]) != there[kind]:
            raise InputError(
                f"{name} must have the {kind} scale and units of what it is drawn with, "
                f"{there[kind]}, got {here[kind]}"
            )


def _measures(dataset: xr.Dataset) -> dict[str, str]:
    """Return scale and units of each kind of quantity that a dataset holds."""
    kinds = {
        QUANTITIES[str(name)].scale: _units(variable)
        for name, variable in dataset.variables.items()
        if str(name) in QUANTITIES
    }
    return {
        kind: "dimensionless" if units == "1" else f"{scale_of(dataset, kind)!r} {units}"
        for kind, units in kinds.items()
        if kind
    }


def _units(variable: xr.DataArray | xr.Variable) -> str:
    return str(variable.attrs.get("units", "1"))
