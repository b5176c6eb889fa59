"""Categories: the number of each word in a dataset, and the words of numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

import numpy as np
import xarray as xr

from rotor_ida.errors import InputError

# As a condition: 1 is stable, 0 is not.
STABILITY = {"absent": -1, "unstable": 0, "stable": 1, "neutral": 2}
RESPONSE = {
    "unresolved": 0,
    "contact_free": 1,
    "synchronous": 2,
    "bouncing": 3,
    "full_contact": 4,
    "touching": 5,
    "chaotic": 6,
    "not_found": 7,
    "quasi_periodic": 8,
    "rolling": 9,
    "failed": -1,
}
# Events and modes of a contact, as in ``core/core.h``.
EXIT, ENTRY = -1, 1
PRESS, RELEASE = 4, -4
ROLL, SLIP, REVERSE = OF_FRICTION = (2, -2, 3)
EVENT_KIND = {"exit": EXIT, "entry": ENTRY}
# Added by contact damping: the force falls to zero while surfaces overlap, or rises from zero.
DAMPED_EVENT_KIND = EVENT_KIND | {"press": PRESS, "release": RELEASE}
# Added by friction: the disc begins to roll or to slip, or reverses its sliding.
OF_FRICTION_EVENT_KIND = {"roll": ROLL, "slip": SLIP, "reverse": REVERSE}
FLIES, SLIDES_FORWARDS, SLIDES_BACKWARDS, ROLLS, IS_LOOSE = 0, 1, -1, 2, 3
MODE = {
    "flight": FLIES, "slipping_forward": SLIDES_FORWARDS, "slipping_backward": SLIDES_BACKWARDS,
    "rolling": ROLLS, "loose": IS_LOOSE,
}  # fmt: skip
# Labels of a start besides the numbers of the attractors and the kinds of response.
FATE = {"not_computed": -2, "undecided": -1}
# Evidence for the trapping region of an attractor: a proof that no orbit leaves it, orbits that
# were simulated from it, or no region.
TRAPPING = {"none": 0, "estimated": 1, "proven": 2}
STATUS = {"done": 0, "failed": 1}
# How a run-up ends, after a time at the last speed.
ENDING = {"failed": -1, "unresolved": 0, "contact_free": 1, "rub": 2, "whip": 3}
ENDS_IN_WORDS = {
    "contact_free": "contact-free", "rub": "in a rub", "whip": "in dry whip",
    "unresolved": "undecided",
}  # fmt: skip
DIRECTION = {"down": -1, "from_start": 0, "up": 1}
PASSAGE = {"down": -1, "none": 0, "up": 1}
NO_YES = {"no": 0, "yes": 1}
VERDICT = {"passes": 0, "fails": 1, "touches": 2}
WHIRL_KIND = {"slipping": 0, "rolling": 1}
WHIRL_DIRECTION = {"backward": -1, "none": 0, "forward": 1}
EXACT = {"nothing": 0, "whirl": 1, "cycle": 2}
LINE_KIND = {"backward": -1, "spin": 0, "forward": 1, "static": 2}
SPECIAL = {
    "fold": 1,
    "period_doubling": 2,
    "graze": 3,
    "cusp": 4,
    "torus": 5,
    "sliding": 6,
    "hopf": 7,
    "discontinuous": 8,
    "threshold": 9,
}
END = {
    "not_found": -1, "none": 0, "fold": 1, "period_doubling": 2, "touch": 3, "hopf": 4, "torus": 5,
    "discontinuous": 6,
}  # fmt: skip
EXTREMUM = {"minimum": -1, "constant": 0, "maximum": 1}
# Attributes of flag numbers, which their words do not need.
OF_FLAGS = ("flag_values", "flag_meanings", "units")
Labelled = TypeVar("Labelled", xr.Dataset, xr.DataArray)


def by_number(flags: Mapping[str, int]) -> dict[int, str]:
    """Return the words of a table of flags by their numbers.

    Examples
    --------
    >>> by_number(FATE)[-1]
    'undecided'
    """
    return {number: word for word, number in flags.items()}


def flags_of(variable: xr.DataArray | xr.Variable) -> dict[str, int]:
    """Return the words and numbers of a flag variable from its attributes.

    Examples
    --------
    >>> from rotor_ida.schema import labelled
    >>> flags_of(xr.DataArray(labelled("event_kind", "event", [1])))
    {'exit': -1, 'entry': 1}
    """
    if "flag_meanings" not in variable.attrs:
        raise InputError(f"a flag variable must have flag_meanings, got one with {variable.attrs}")
    words = str(variable.attrs["flag_meanings"]).split()
    numbers = np.ravel(variable.attrs.get("flag_values", ())).tolist()
    if len(words) != len(numbers):
        raise InputError(
            f"a flag variable must have a number for each of {', '.join(words)}, got {numbers}"
        )
    return dict(zip(words, numbers, strict=True))


def check_flags(name: str, variable: xr.DataArray | xr.Variable) -> dict[int, str]:
    """Return the words of a flag variable by number; refuse a number of it that has none."""
    words = by_number(flags_of(variable))
    if variable.dtype.kind not in "iuf":
        raise InputError(f"{name} must be numbers of flags, got {variable.dtype}")
    numbers = np.unique(variable.values[~np.isnan(variable.values)])
    for number in numbers.tolist():
        if number not in words:
            raise InputError(f"{name} must be one of {', '.join(map(str, words))}, got {number!r}")
    return words


def words_of(variable: xr.DataArray | xr.Variable, name: object = None) -> list[str]:
    """Return the values of a flag variable as a flat list of words; empty where one is NaN.

    Examples
    --------
    >>> from rotor_ida.schema import labelled
    >>> words_of(xr.DataArray(labelled("event_kind", "event", [1, -1])))
    ['entry', 'exit']
    """
    words = check_flags(str(name or getattr(variable, "name", None) or "flags"), variable)
    return [words.get(number, "") for number in variable.values.ravel().tolist()]


def decode_flags(data: Labelled) -> Labelled:
    """Return a result with its flags as words instead of numbers.

    Parameters
    ----------
    data : Dataset or DataArray
        A result, or one of its flag variables, such as ``stability`` or ``response``.

    Returns
    -------
    Dataset or DataArray
        The same with strings, for tables, ``sel`` and ``where``; ``""`` where a value is missing.
        Other functions of this package need the numbers.

    Raises
    ------
    InputError
        If a DataArray has no ``flag_meanings``, or a number is none of its flags.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0).squeeze()
    >>> decode_flags(whirls.stability).values.tolist()
    ['stable', 'unstable', 'stable']
    >>> stable = decode_flags(whirls.stability) == "stable"
    >>> whirls.amplitude.where(stable, drop=True).values.round(4)
    array([1.8796, 9.4872])
    >>> decode_flags(whirls)[["amplitude", "stability"]].to_dataframe().stability.tolist()
    ['stable', 'unstable', 'stable']
    """
    if isinstance(data, xr.DataArray):
        decoded = _decoded(data.variable)
        return xr.DataArray(decoded.values, data.coords, data.dims, data.name, decoded.attrs)
    if not isinstance(data, xr.Dataset):
        raise InputError(f"data must be a Dataset or DataArray, got {type(data).__name__}")
    words = {
        name: _decoded(variable)
        for name, variable in data.variables.items()
        if "flag_meanings" in variable.attrs
    }
    on_axes = {name: variable for name, variable in words.items() if name in data.coords}
    others = {name: variable for name, variable in words.items() if name not in on_axes}
    return data.assign(others).assign_coords(on_axes)


def _decoded(variable: xr.Variable) -> xr.Variable:
    """Return a flag variable as words; empty where its number is NaN."""
    texts = words_of(variable)
    told = {name: value for name, value in variable.attrs.items() if name not in OF_FLAGS}
    return xr.Variable(variable.dims, np.reshape(np.array(texts, dtype=str), variable.shape), told)
