"""What a rotor has beyond the paper's: shaft, contact law, contact damping, friction, as axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import LARGEST_NUMBER, check_axis, check_nonnegative, is_scalar
from rotor_ida.errors import InputError
from rotor_ida.model.table import FRICTIONLESS, check_exponent
from rotor_ida.schema import Column

# The value of each with which it is the paper's rotor.
PAPERS = {**FRICTIONLESS, "friction": 0.0}


@dataclass(frozen=True, slots=True)
class Further:
    """Shaft, and exponent, damping and friction of the contact of many rotors, flat arrays."""

    shaft_stiffness: Values
    contact_exponent: Values
    contact_damping: Values
    friction: Values


@dataclass(frozen=True, slots=True)
class FurtherAxes:
    """Axes of these parameters, as a user gave them.

    Parameters
    ----------
    axes : dict of ndarray
        Each parameter as a vector; a number is a vector of one.
    dims : tuple of str
        Names of those that are a dimension of a result: all that were given as a vector.
    coordinates : dict
        Those that a result has as coordinates: a vector, or a number that is not the default.
    """

    axes: dict[str, Values]
    dims: tuple[str, ...]
    coordinates: dict[str, Column]

    @property
    def default(self) -> bool:
        """Whether all are the paper's."""
        return not self.coordinates

    @property
    def sizes(self) -> tuple[int, ...]:
        """Lengths of the dimensions."""
        return tuple(self.axes[name].size for name in self.dims)


def further_axes(
    *,
    shaft_stiffness: object,
    contact_exponent: object,
    contact_damping: object,
    friction: object,
    delta0: Values,
) -> FurtherAxes:
    """Return the axes, checked, of rotors with the clearances `delta0`.

    Examples
    --------
    >>> found = further_axes(
    ...     shaft_stiffness=[0.0, 0.25], contact_exponent=1.0, contact_damping=0.0,
    ...     friction=0.0, delta0=np.array([1.0]),
    ... )
    >>> found.dims, list(found.coordinates)
    (('shaft_stiffness',), ['shaft_stiffness', 'contact_exponent'])
    """
    given = {
        "shaft_stiffness": shaft_stiffness,
        "contact_exponent": contact_exponent,
        "contact_damping": contact_damping,
        "friction": friction,
    }
    axes = {name: check_axis(name, each, largest=LARGEST_NUMBER) for name, each in given.items()}
    check_law(axes["contact_exponent"], axes["contact_damping"], axes["friction"], delta0)
    coordinates: dict[str, Column] = {}
    for name, axis in axes.items():
        if not is_scalar(name, given[name]):
            coordinates[name] = (name, axis)
        elif axis[0] != PAPERS[name]:
            coordinates[name] = ((), axis[0])
    dims = tuple(name for name, (dim, _) in coordinates.items() if dim)
    return FurtherAxes(axes, dims, coordinates)


def check_law(exponent: Values, contact_damping: Values, friction: Values, delta0: Values) -> None:
    """Refuse exponents that are not known, and contact damping or friction without clearance."""
    for each in np.unique(exponent).tolist():
        check_exponent(each)
    for name, values in (("contact_damping", contact_damping), ("friction", friction)):
        if (values > 0.0).any() and (delta0 == 0.0).any():
            raise InputError(
                f"{name} must be 0 without clearance, where the radius may vanish in "
                f"contact, got {float(values.max())!r} with delta0 0.0"
            )


def check_exponents(values: object) -> Values:
    """Return exponents of the contact force, a number or a vector, as a 1-D array."""
    exponents = check_axis("contact_exponent", values)
    for each in np.unique(exponents).tolist():
        check_exponent(each)
    return exponents


def law_of(
    shaft_stiffness: object, contact_exponent: object
) -> tuple[float, float, dict[str, Column]]:
    """Return stiffness of the shaft and exponent of the contact, checked, and as coordinates.

    Examples
    --------
    >>> law_of(0.25, 1.5)
    (0.25, 1.5, {'shaft_stiffness': ((), 0.25)})
    """
    kappa = check_nonnegative("shaft_stiffness", shaft_stiffness, LARGEST_NUMBER)
    exponent = check_nonnegative("contact_exponent", contact_exponent)
    check_exponent(exponent)
    given = {"shaft_stiffness": kappa, "contact_exponent": exponent}
    return (
        kappa,
        exponent,
        {name: ((), value) for name, value in given.items() if value != FRICTIONLESS[name]},
    )
