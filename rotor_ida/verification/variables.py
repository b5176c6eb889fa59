"""Compare every variable of a result with that computed again, or say why it is not compared."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.schema import RESPONSE, by_number, flags_of
from rotor_ida.schema.tolerances import (
    DEPENDS_ON_ROUNDING,
    EACH_BY_ITSELF,
    STATED_ERROR,
    TOLERANCE,
    TOLERANCE_OF_VARIABLE,
    why_no_result,
)

# Responses whose numbers belong to the motion, not to one stretch of it; and the numbers that do
# so in fewer of them, as they are means over a stretch.
PERIODIC = ("contact_free", "synchronous", "bouncing", "full_contact")
CIRCULAR = ("contact_free", "synchronous")
# What is compared of every point, start and attractor.
OF_POINTS = ("response", "kind", "label", "count")
OF_CIRCLES = (
    "amplitude", "phase_lag", "node_amplitude", "node_phase_lag",
    *("rotating_x", "rotating_y", "rotating_vx", "rotating_vy"),
)  # fmt: skip
# Dimension of the states of a stroboscopic diagram.
CROSSING = "crossing"
# Error of the trace of a monodromy matrix by rounding, relative to its largest multiplier.
ROUNDING = 1e-14
NO_MORE = "not computed again"
# Attributes that another method changes, and the difference allowed for numbers in attributes.
OF_METHOD = ("method", "flight", "atol", "left_over_method")
TOLERANCE_OF_ATTRIBUTES = 1e-6
NOT_BY_METHOD = "not computed by this method"
OF_NO_CIRCLE = "of a motion that is no circle: it depends on where the window begins"
OF_ONE_STRETCH = "chaotic or undecided: another processor follows another stretch of the motion"


@dataclass
class Comparison:
    """What a comparison of all variables has found.

    Parameters
    ----------
    compared : list of str
        Variables whose numbers or words were compared.
    left_out : dict of str
        Why others were not compared, by name.
    attributes : list of str
        Attributes that were compared.
    attributes_left_out : dict of str
        Why others were not.
    values, differing : int
        The numbers of values that were compared, and of those that differ.
    largest : float
        The largest difference between numbers, relative to the largest of their variable.
    trouble : str
        The first difference in words; empty if there is none.
    """

    compared: list[str] = field(default_factory=list)
    left_out: dict[str, str] = field(default_factory=dict)
    attributes: list[str] = field(default_factory=list)
    attributes_left_out: dict[str, str] = field(default_factory=dict)
    values: int = 0
    differing: int = 0
    largest: float = 0.0
    trouble: str = ""


def compare_variables(
    again: xr.Dataset,
    archived: xr.Dataset,
    *,
    left_out: Mapping[str, str],
    tolerance: float = TOLERANCE,
    told: xr.Variable | None = None,
) -> Comparison:
    """Compare all variables of two results.

    Parameters
    ----------
    again, archived : Dataset
        The result computed again, and that of the archive.
    left_out : mapping of str
        Why variables are not compared, by name or by dimension; beside those of the schema.
    tolerance : float
        Difference allowed for real numbers, relative to the largest number of the variable; for
        angles in radians.
    told : Variable of bool, optional
        Where numbers are those of the motion on any processor. By default from the response.

    Returns
    -------
    Comparison
        What was compared, what was not, and the first difference.
    """
    found = Comparison()
    reasons = {**DEPENDS_ON_ROUNDING, **left_out}
    allowed = _errors_of_multipliers(archived)
    for name in map(str, archived.variables):
        keys = (name, *map(str, archived.variables[name].dims))
        reason = next(filter(None, map(reasons.get, keys)), "")
        if not reason and name not in again.variables:
            reason = NO_MORE
        known = _periodic(archived, name) if told is None else told
        where = _told(archived.variables[name], known)
        if not reason and where.size and not where.any():
            reason = OF_NO_CIRCLE if name in OF_CIRCLES else OF_ONE_STRETCH
        if reason:
            found.left_out[name] = reason
            continue
        found.compared.append(name)
        _compare(found, name, again, archived, where, tolerance, allowed.get(name))
    return found


def compare_attributes(
    found: Comparison, again: xr.Dataset, archived: xr.Dataset, tolerance: float, *, by_other: bool
) -> None:
    """Compare the attributes that are results or parts of the question, and add what was found.

    What another method changes is not compared where the result was computed again `by_other`.
    """
    for name, there in archived.attrs.items():
        reason = why_no_result(str(name)) or ("" if name in again.attrs else NO_MORE)
        computed = again.attrs.get(name)
        is_nan = isinstance(computed, float) and math.isnan(computed)
        if by_other and (name in OF_METHOD or is_nan):
            reason = NOT_BY_METHOD
        if reason:
            found.attributes_left_out[str(name)] = reason
            continue
        found.attributes.append(str(name))
        here, within = again.attrs[name], max(tolerance, TOLERANCE_OF_ATTRIBUTES)
        if not _is_same(here, there, within):
            found.differing += 1
            found.trouble = found.trouble or (
                f"attribute {name} differs: {shown(here)} computed again, {shown(there)} archived"
            )


def _is_same(here: object, there: object, tolerance: float) -> bool:
    """Return whether two attributes are the same words, or numbers within a tolerance."""
    one, other = np.asarray(here), np.asarray(there)
    if one.dtype.kind in "iufb" and other.dtype.kind in "iufb":
        return one.shape == other.shape and np.allclose(
            one, other, rtol=tolerance, atol=0.0, equal_nan=True
        )
    return one.shape == other.shape and bool(np.all(one == other))


def missing_in(again: xr.Dataset, archived: xr.Dataset) -> list[str]:
    """Return the variables of which a result has no number, and the archive has some."""

    def has_none(dataset: xr.Dataset, name: str) -> bool:
        return bool(np.isnan(dataset.variables[name].values).all())

    real = [str(name) for name, each in archived.variables.items() if each.dtype.kind == "f"]
    return [
        name for name in real
        if name in again.variables and has_none(again, name) and not has_none(archived, name)
    ]  # fmt: skip


def _compare(
    found: Comparison,
    name: str,
    again: xr.Dataset,
    archived: xr.Dataset,
    told: npt.NDArray[np.bool_],
    tolerance: float,
    allowed: Values | None,
) -> None:
    """Compare one variable where it is reproducible, and add the differences to those found."""
    here, there = again.variables[name], archived.variables[name]
    found.values += there.size
    if dict(here.sizes) != dict(there.sizes):
        found.differing += there.size
        found.trouble = found.trouble or (
            f"{name} has {dict(here.sizes)} computed again, {dict(there.sizes)} archived"
        )
        return
    one, other = here.transpose(*there.dims).values, there.values
    differs, largest = (one != other) & told, ""
    if here.dtype.kind == there.dtype.kind == "f":
        apart = np.where(told, _relative(name, one, other, there.attrs.get("units")), 0.0)
        limit = max(tolerance, TOLERANCE_OF_VARIABLE.get(name, 0.0))
        if CROSSING in there.dims and name in OF_CIRCLES and "response" in archived:
            axis = there.dims.index(CROSSING)
            apart = _in_any_order(apart, one, other, axis, limit)
        differs = apart > limit
        if allowed is not None:
            differs &= ~(abs(one - other) <= allowed)
        if stated := STATED_ERROR.get(name):
            differs = ~(abs(one - other) <= again[stated].values + archived[stated].values)
        found.largest = max(found.largest, float(apart.max(initial=0.0)))
        largest = f" by up to {apart.max(initial=0.0):.3g} of the largest"
    found.differing += int(differs.sum())
    if differs.any() and not found.trouble:
        first = np.unravel_index(int(differs.argmax()), differs.shape)
        words = by_number(flags_of(archived[name])) if "flag_meanings" in there.attrs else {}
        here_first, there_first = (words.get(each[first], each[first]) for each in (one, other))
        found.trouble = (
            f"{name} differs in {int(differs.sum())} of {there.size} places{largest}; the first: "
            f"{here_first} computed again, {there_first} archived"
        )


def _errors_of_multipliers(archived: xr.Dataset) -> dict[str, Values]:
    """Return by how much rounding may change multipliers: as stated, or by their distances.

    Two that nearly coincide are roots of a polynomial with nearly a double root, which a change of
    its coefficients by rounding moves by the square root of that change.
    """
    parts = ("multiplier_real", "multiplier_imag")
    if any(name not in archived.variables for name in parts):
        return {}
    dims = archived["multiplier_real"].dims
    if "multiplier_error" in archived.variables:
        stated = archived["multiplier_error"].transpose(*dims).values
        return dict.fromkeys(parts, 2.0 * stated)
    real, imag = (archived[name].transpose(..., "multiplier").values for name in parts)
    values = real + 1j * imag
    apart = np.abs(values[..., :, np.newaxis] - values[..., np.newaxis, :])
    apart += np.where(np.eye(values.shape[-1]) > 0.0, math.inf, 0.0)
    largest = np.abs(values).max(axis=-1, keepdims=True, initial=0.0)
    nearest = np.maximum(apart.min(axis=-1, initial=math.inf), math.sqrt(ROUNDING) * largest)
    errors = ROUNDING * largest**2 / np.where(nearest > 0.0, nearest, 1.0)
    whole = xr.Variable((*(dim for dim in dims if dim != "multiplier"), "multiplier"), errors)
    return dict.fromkeys(parts, whole.transpose(*dims).values)


def _in_any_order(apart: Values, here: Values, there: Values, axis: int, limit: float) -> Values:
    """Return differences of states once a revolution, which need not begin at the same one.

    Where they differ in order, each is compared with the nearest of the others. These resolve no
    more than their own distance, which is 0 where the motion repeats after whole revolutions.
    """
    apart, here, there = (np.moveaxis(each, axis, -1) for each in (apart, here, there))
    largest = np.abs(there).max(initial=0.0, where=np.isfinite(there))
    found = apart.copy()
    for place in zip(*np.nonzero((apart > limit).any(axis=-1)), strict=True):
        one, other = here[place], there[place]
        between = np.abs(one[:, np.newaxis] - other)
        far = np.maximum(between.min(axis=0), between.min(axis=1))
        spacing = min(map(_spacing, (one, other)))
        found[place] = np.where(far <= spacing, 0.0, np.nan_to_num(far / largest, nan=math.inf))
    return np.moveaxis(found, -1, axis)


def _spacing(values: Values) -> float:
    """Return the largest distance of a number from the nearest of the others."""
    gaps = np.diff(np.sort(values))
    return float(np.minimum(np.r_[np.inf, gaps], np.r_[gaps, np.inf]).max(initial=0.0))


def _periodic(archived: xr.Dataset, name: str) -> xr.Variable | None:
    """Return where the response has numbers of its own; None for a result without responses."""
    by = next((each for each in ("response", "kind") if each in archived.data_vars), None)
    if by is None or name in OF_POINTS:
        return None
    is_of_circles = name in OF_CIRCLES and CROSSING not in archived.variables[name].dims
    words = CIRCULAR if is_of_circles else PERIODIC
    response = archived.variables[by]
    known = np.isin(response.values, [RESPONSE[word] for word in words])
    return xr.Variable(response.dims, known)


def _told(variable: xr.Variable, known: xr.Variable | None) -> npt.NDArray[np.bool_]:
    """Return where the numbers of a variable are compared, in its shape."""
    if known is None or not known.dims or not set(known.dims) <= set(variable.dims):
        return np.ones(variable.shape, bool)
    dims = [dim for dim in variable.dims if dim in known.dims]
    axes = tuple(axis for axis, dim in enumerate(variable.dims) if dim not in known.dims)
    values = np.expand_dims(known.transpose(*dims).values, axes)
    return np.array(np.broadcast_to(values, variable.shape), dtype=np.bool_)


def _relative(name: str, here: Values, there: Values, unit: object) -> Values:
    """Return differences over the largest number, or each number; missing in both are equal."""
    same = (here == there) | (np.isnan(here) & np.isnan(there))
    finite = np.isfinite(there) & np.isfinite(here)
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        if unit in {"radian", "rad"}:
            apart = np.abs(np.remainder(here - there + math.pi, 2.0 * math.pi) - math.pi)
        elif name in EACH_BY_ITSELF:
            apart = np.abs(here - there) / np.abs(there)
        else:
            apart = np.abs(here - there) / np.abs(there).max(initial=0.0, where=finite)
    return np.where(same, 0.0, np.where(finite & np.isfinite(apart), apart, np.inf))
