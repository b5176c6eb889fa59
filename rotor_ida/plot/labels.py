"""Labels of quantities, kinds of response and units in plots, and titles.

A figure shows the units of its dataset (`rotor_ida.dimensional` chooses them); metres and other
units without a prefix get one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, MaxNLocator, ScalarFormatter

from rotor_ida import schema
from rotor_ida.arrays import Values
from rotor_ida.model.parameters import OF_ROTOR, OPTIONAL, PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.plot.datasets import hold_units, is_of_disc, one_value, units_in
from rotor_ida.results.checked_run import course_of
from rotor_ida.results.si_units import in_rpm, machine_of, si_of
from rotor_ida.texts import in_figure
from rotor_ida.units import SPEED_UNITS, UNITS, number, quantity, read_in, spelled

SEPARATOR = ",  "
# Most characters in a line of a title.
MOST_CHARACTERS = 58

# Words and symbol of each quantity, and its symbol where it has a unit, as in eqs (1)-(9), if that
# is another.
_QUANTITIES: dict[str, tuple[str, ...]] = {
    **{name: (each.label, f"${each.symbol}$") for name, each in OF_ROTOR.items()},
    "speed": ("spin speed", r"$\omega$", ""),
    "rate": ("rate", "$a$"),
    "amplitude": ("amplitude", "$A$"),
    "phase_lag": ("phase lag", r"$\theta$"),
    "t": ("time", "$t$", "$T$"),
    "x": ("displacement", "$x$", "$X$"),
    "y": ("displacement", "$y$", "$Y$"),
    "vx": ("velocity", "$x$′", "$X$′"),
    "vy": ("velocity", "$y$′", "$Y$′"),
    "displacement": ("displacement", "$z$", "$Z$"),
    "axial_position": ("axial position", "$s$"),
    "deviation": ("distance from the simulated", "$z$", "$Z$"),
    "x_alone": ("", "$x$", "$X$"),
    "y_alone": ("", "$y$", "$Y$"),
    "radius": ("radius", "$|z|$", "$|Z|$"),
    "rotating_x": (
        "along the unbalance",
        r"$\operatorname{Re}\,z\,e^{-i\omega t}$",
        r"$\operatorname{Re}\,Z\,e^{-i\omega t}$",
    ),
    "rotating_y": (
        "across it",
        r"$\operatorname{Im}\,z\,e^{-i\omega t}$",
        r"$\operatorname{Im}\,Z\,e^{-i\omega t}$",
    ),
    "angle": ("angle from the unbalance", r"$\arg z\,e^{-i\omega t}$ [rad]"),
    "radial_velocity": ("radial velocity", "$|z|$′", "$|Z|$′"),
    "frequency_over_omega": ("frequency over spin speed", r"$\Omega/\omega$"),
    "frequency": ("frequency", r"$\Omega$", ""),
    "whirl_amplitude": ("whirl amplitude, zero to peak", "$|c|$"),
    "whirl_speed": ("whirl speed", r"$\Omega$"),
    "force": ("contact force", "$f$", "$F$"),
    "peak_force": ("peak force", "$f$", "$F$"),
    "peak_fraction": ("fraction of contacts up to this force", ""),
    "normal_force": ("normal force", "$N$"),
    "slip_speed": ("slip speed", "$v_s$", "$V_s$"),
    "running_exponent": ("Lyapunov exponent", r"$\lambda$"),
    "restoring_x": ("force", "$f_x$", "$F_x$"),
    "restoring_y": ("force", "$f_y$", "$F_y$"),
    "potential": ("potential", "$V$"),
    "energy": ("energy", "$E$"),
    "period": ("period", "$T$"),
    "natural": ("natural frequency", r"$2\pi/T$"),
    "multiplier_real": ("multiplier", r"$\operatorname{Re}\,\mu$"),
    "multiplier_imag": ("", r"$\operatorname{Im}\,\mu$"),
}
LABELS = {name: f"{words} {symbols[0]}".strip() for name, (words, *symbols) in _QUANTITIES.items()}
IN_UNITS = {
    name: f"{words} {symbols[-1]}".strip() for name, (words, *symbols) in _QUANTITIES.items()
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
    return SEPARATOR.join(
        f"${OF_ROTOR[name].symbol} = {value:.4g}$" for name, value in values.items()
    )


def number_text(value: float, form: str = "#.3g") -> str:
    r"""Return a number as mathematical text, small and large ones with a power of ten.

    Examples
    --------
    >>> number_text(1.88), number_text(156.2), number_text(9.4e-6)
    ('1.88', '156', '9.40 \\times 10^{-6}')
    """
    return typeset(format(value, form)).strip("$")


def typeset(said: str) -> str:
    r"""Return a number with its unit as mathematical text.

    Examples
    --------
    >>> typeset("16.9 um"), typeset("4.12(2)e+06 N/m"), typeset("6,112 rpm")
    ('$16.9$ µm', '$4.12(2) \\times 10^{6}$ N/m', '6,112 rpm')
    """
    number, _, unit = said.partition(" ")
    digits, _, power = number.replace(".e", "e").removesuffix(".").partition("e")
    unit = re.sub("^u", "µ", unit)
    if "," in digits:  # mathematics would put a space after it
        return f"{digits} {unit}".rstrip()
    ten = rf" \times 10^{{{int(power)}}}" if power else ""
    return f"${digits}{ten}$ {unit}".rstrip()


def lengths_text(unit: str, *lengths: float) -> tuple[list[str], str]:
    """Return lengths as numbers in the unit in which the largest of them is read, and this unit.

    Examples
    --------
    >>> lengths_text("um", 109.2, 23318.0), lengths_text("1", 1.88), lengths_text("mil", 3.0)
    ((['0.109', '23.3'], 'mm'), (['1.88'], ''), (['3'], 'mil'))
    """
    size = metres_in(unit)
    if size is None:
        return [number(each, 3) for each in lengths], unit.removeprefix("1")
    in_metres = [size * each for each in lengths]
    shown, parts = read_in("m", in_metres, system="inch" if unit == "mil" else "metric")
    return [number(each / parts, 3) for each in in_metres], re.sub("^u", "µ", shown)


def metres_in(unit: str) -> float | None:
    """Return the metres in a unit of length; None for any other unit."""
    known = UNITS.get(unit)
    return known.in_si("1") if known and known.dimension == UNITS["m"].dimension else None


def unit_of(variable: xr.DataArray | xr.Variable) -> str:
    """Return the unit of a variable in common notation; empty for numbers and angles.

    Examples
    --------
    >>> unit_of(xr.DataArray([1.0], attrs={"units": "um s-1"}))
    'µm/s'
    """
    unit = units_in(variable)
    return "" if unit == "radian" else in_figure(re.sub("^u", "µ", spelled(unit)))


def label_of(name: str, variable: xr.DataArray, *, words: str | None = None) -> str:
    r"""Return the label of an axis: name and symbol, and the unit of the variable, if it has one.

    Examples
    --------
    >>> label_of("radius", xr.DataArray([1.0], attrs={"units": "um"}))
    'radius $|Z|$ [µm]'
    >>> label_of("radius", xr.DataArray([1.0], attrs={"units": "1"}))
    'radius $|z|$'
    >>> label_of("whirl_speed", xr.DataArray([1.0], attrs={"units": "s-1"}))
    'whirl speed $\\Omega$ [rad/s]'
    """
    unit = unit_of(variable)
    label = words or (IN_UNITS if unit else LABELS)[name]
    if "node" in variable.coords:  # the phases of a system's unbalance are counted from its mark
        label = label.replace(" the unbalance", " the mark")
    if schema.unit_of(name, units_in(variable)) == "rad/s":
        unit = "rad/s" if unit else ""
    return f"{label} [{unit}]" if unit else label


def label_axis(axis: Axis, name: str, variable: xr.DataArray, *, words: str | None = None) -> None:
    """Label an axis with a variable and its unit, and fix the axis to that unit."""
    hold_units(axis, variable)
    axis.set_label_text(label_of(name, variable, words=words))


def label_parameter(axis: Axis, name: str, dataset: xr.Dataset) -> Values:
    """Label an axis of a parameter of any rotor, and return its values as they are drawn there.

    Spin speeds of a result in SI units are shown in rpm. Parameters of one disc stay dimensionless
    as they are drawn, and of a machine the ticks are in the units of the field.
    """
    if name == SPEED:
        speeds = speeds_in(dataset[name])
        label_axis(axis, name, speeds)
        return np.asarray(speeds.values)
    values = np.asarray(dataset[name].values if name in dataset.variables else [])
    known = si_of(dataset, name)
    if name in PARAMETERS_OF_SYSTEM and not is_of_disc(dataset):
        label_axis(axis, name, dataset[name], words=PARAMETERS_OF_SYSTEM[name].label)
        axis.set_major_formatter(ScalarFormatter(useMathText=True))  # an unbalance has many digits
    elif known is None:
        axis.set_label_text(LABELS[name])
    else:
        words, _, unit = known[0].removesuffix("]").partition(" [")
        shown, parts = read_in(unit, np.ravel(known[1] * values).tolist())
        scale = known[1] / parts
        axis.set_major_locator(_ScaledLocator(scale))
        axis.set_major_formatter(FuncFormatter(lambda at, _: f"{at * scale:.6g}"))
        axis.set_label_text(f"{'spin ' * (name == 'omega')}{words} [{shown}]".replace("[u", "[µ"))
    return values


def speeds_in(speeds: xr.DataArray) -> xr.DataArray:
    """Return speeds in rpm, or as they are where they have no unit."""
    turns = in_rpm(speeds)
    return speeds if turns is None else speeds.copy(data=turns).assign_attrs(units="rpm")


class _ScaledLocator(MaxNLocator):
    """Places ticks at round numbers of a multiple of the plotted data."""

    def __init__(self, factor: float) -> None:
        super().__init__(nbins="auto", steps=[1, 2, 2.5, 5, 10])
        self.factor = factor

    def tick_values(self, vmin: float, vmax: float) -> Any:
        """Return the places of the ticks, as drawn."""
        return np.asarray(super().tick_values(vmin * self.factor, vmax * self.factor)) / self.factor


def title_of(name: str, dataset: xr.Dataset, parameters: Sequence[str] = PARAMETERS) -> str:
    """Return the parameters of a dataset, with one value of each, as a title.

    Of a result of a rotor system it is the node, if there is only one, and the speed, if that is
    known.
    """
    if not is_of_disc(dataset):
        has_node = "node" in dataset.coords and not dataset["node"].ndim
        node = [f"node {in_figure(str(dataset['node'].values))}"] * has_node
        return SEPARATOR.join([*node, *_speed_in(dataset)])
    # what varies along a branch is on its axis
    optional = [each for each in OPTIONAL if each in dataset.variables and not dataset[each].ndim]
    values = {each: one_value(name, dataset, each) for each in (*parameters, *optional)}
    if "event_speed" in dataset.variables:  # omega is only the first
        del values["omega"]
        return wrapped([*_speed_in(dataset), text_of(dataset, values)])
    return text_of(dataset, values)


def _speed_in(dataset: xr.Dataset) -> list[str]:
    """Return the speed of a run-up or of a result of a rotor system, if it has only one."""
    if "event_speed" in dataset.variables:
        speeds = course_of(dataset[SPEED].values)
        return [speed_text(xr.DataArray(speeds, attrs=dataset[SPEED].attrs))]
    if SPEED in dataset.variables:
        return [speed_text(dataset[SPEED])] if dataset[SPEED].size == 1 else []
    speed, units = (dataset.attrs.get(name) for name in ("speed", "speed_units"))
    return [] if speed is None else [speed_text(xr.DataArray(speed, attrs={"units": units}))]


def speed_text(speeds: xr.DataArray) -> str:
    """Return a speed as in a title, or its course, in rpm or without a unit.

    Examples
    --------
    >>> speed_text(xr.DataArray(1.35))
    'speed 1.35'
    >>> speed_text(xr.DataArray([314.16, 628.32], attrs={"units": "s-1"}))
    '3,000 to 6,000 rpm'
    """
    turns, rpm = in_rpm(speeds), SPEED_UNITS["rpm"]
    if turns is None:
        return f"speed {span_text(np.ravel(speeds).tolist())}"
    said = [quantity(each * rpm, "rad/s").removesuffix(" rpm") for each in np.ravel(turns).tolist()]
    return f"{_joined(said)} rpm"


def span_text(values: Sequence[float]) -> str:
    """Return numbers that follow each other, as far as they differ as written.

    Examples
    --------
    >>> span_text([0.0014671, 0.0014673]), span_text([0.0, 2.0, 0.0])
    ('0.001467', '0 to 2 to 0')
    """
    return _joined(map(number, values))


def _joined(said: Iterable[str]) -> str:
    return " to ".join(each for each, _ in groupby(said))


def text_of(dataset: xr.Dataset, values: Mapping[str, float]) -> str:
    """Return parameters as a title: dimensionless, or in SI units if the dataset has a machine."""
    return wrapped([_one_text(dataset, name, value) for name, value in values.items()])


def _one_text(dataset: xr.Dataset, name: str, value: float) -> str:
    """Return a parameter with its value, in words with a unit if it has one."""
    if not is_of_disc(dataset):
        if name == SPEED:
            return speed_text(xr.DataArray(value, attrs=dataset[name].attrs))
        words = PARAMETERS_OF_SYSTEM[name].label if name in PARAMETERS_OF_SYSTEM else name
        return f"{words} {number(value)} {unit_of(dataset[name])}".rstrip()
    if machine_of(dataset) is None:
        return parameter_text({name: value})
    known = si_of(dataset, name)
    if known is None:
        return f"{name.replace('_', ' ')} {number(value)}"
    words, _, unit = known[0].removesuffix("]").partition(" [")
    return f"{words} {typeset(quantity(value * known[1], unit))}"


def wrapped(parts: Sequence[str]) -> str:
    r"""Return parts of a title in lines that no figure cuts off.

    Examples
    --------
    >>> wrapped([*4 * [r"$\zeta = 0.0725$"], "clearance $2$ µm"]).count("\n")
    1
    """
    lines = list(parts[:1])
    for part in parts[1:]:
        longer = f"{lines[-1]}{SEPARATOR}{part}"
        # a symbol is one letter wide
        if len(re.sub(r"\\[a-z]+|[$_{}]", lambda each: each[0][1:2], longer)) <= MOST_CHARACTERS:
            lines[-1] = longer
        else:
            lines.append(part)
    return "\n".join(lines)
