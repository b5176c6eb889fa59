"""Means, ranges and fractions over a grid of drops, and how far the grid resolves them.

A grid is not a sample: no sampling error applies. A mean over it is a quadrature, whose error shows
in what it changes by when every other value of an axis is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce

import numpy as np

from rotor_ida.arrays import Column, Values

# How much longer the gap between the last angle and the first may be than the longest other one,
# for the angles to go round.
SLACK = 1.0 + 1e-6


def grid_statistics_of(
    numbers: Mapping[str, Values], facts: Mapping[str, Values], axes: Mapping[str, Values],
    along: Mapping[str, str],
) -> dict[str, Column]:  # fmt: skip
    """Return statistics of figures and facts of shape (drop, contact) over a grid, by name.

    Parameters
    ----------
    numbers, facts : mapping
        Figures, and what is true (1) or false (0) of the drops; NaN where it is unknown.
    axes : mapping
        The values of what varies, whose combinations are the drops in the order of `product`.
    along : mapping
        The other dimension of a figure, where it is not the contact.
    """
    found: dict[str, Column] = {}
    full = [weights_of(each, circular=name == "phase") for name, each in axes.items()]
    weights, thinner = _product(full), _thinner(axes)
    for name, values in numbers.items():
        dim = along.get(name, "contact")
        for end, pick in (("min", np.fmin), ("max", np.fmax)):
            extreme = pick.reduce(values, axis=0)
            at = np.argmax(values == extreme, axis=0)  # the first of equals
            found[f"{name}_{end}"] = (dim, extreme)
            found[f"{name}_{end}_drop"] = (dim, np.where(np.isnan(extreme), -1, at))
        mean, change = _mean(values, weights, thinner)
        found[f"{name}_mean"], found[f"{name}_mean_change"] = (dim, mean), (dim, change)
    for name, flags in facts.items():
        mean, change = _mean(flags, weights, thinner)
        found[f"{name}_fraction"] = ("contact", mean)
        found[f"{name}_fraction_change"] = ("contact", change)
    return found


def cells_of(
    numbers: Mapping[str, Values], facts: Mapping[str, Values], axes: Mapping[str, Values]
) -> dict[str, Column]:
    """Return what happens in each cell of a grid, which is a combination of all but the phase.

    Of ``numbers`` the largest over the phases, of ``facts`` the fraction of the phases.
    """
    names = [name for name in axes if name != "phase"]
    shape = tuple(each.size for each in axes.values())
    at = list(axes).index("phase")
    weights = weights_of(axes["phase"], circular=True)

    def by_phase(values: Values) -> Values:
        whole = np.moveaxis(values.reshape(*shape, -1), at, -2)
        return whole.reshape(-1, axes["phase"].size, values.shape[1])

    places = np.meshgrid(*(axes[name] for name in names), indexing="ij")
    found: dict[str, Column] = {
        f"cell_{name}": ("cell", place.ravel()) for name, place in zip(names, places, strict=True)
    }
    both = ("cell", "contact")
    for name, values in numbers.items():
        found[f"cell_{name}"] = (both, np.fmax.reduce(by_phase(values), axis=1))
    for name, flags in facts.items():
        fractions = [_weighted(each, weights) for each in by_phase(flags)]
        found[f"cell_{name}_fraction"] = (both, np.array(fractions))
    return found


def weights_of(values: Values, *, circular: bool) -> Values:
    """Return the weights of a mean by the trapezoidal rule, which add up to 1.

    Angles that are spread round the circle count by the arcs around them.

    Examples
    --------
    >>> weights_of(np.array([0.0, 1.0, 3.0]), circular=False).round(3)
    array([0.167, 0.5  , 0.333])
    >>> weights_of(np.array([0.0, 2.0, 4.2]), circular=True).round(3)
    array([0.325, 0.334, 0.341])
    >>> weights_of(np.array([0.0, 0.1]), circular=True)
    array([0.5, 0.5])
    """
    order = np.argsort(values, kind="stable")
    gaps = np.diff(values[order])
    closing = _closing(gaps) if circular else 0.0
    widths = 0.5 * (np.append(gaps, closing) + np.append(closing, gaps))
    total = widths.sum()
    if not total > 0.0:
        return np.full(values.size, 1.0 / values.size)
    found = np.empty(values.size)
    found[order] = widths / total
    return found


def thinned(values: Values, *, circular: bool) -> Values | None:
    """Return weights with every other value left out; None if an end would have to go.

    Examples
    --------
    >>> thinned(np.array([0.0, 1.0, 2.0, 3.0]), circular=False).round(3)
    array([0.333, 0.   , 0.5  , 0.167])
    >>> thinned(np.array([0.0, 1.0]), circular=False) is None
    True
    """
    order = np.argsort(values, kind="stable")
    closed = circular and _closing(np.diff(values[order])) > 0.0
    if values.size < (2 if closed else 3):
        return None
    kept = order[::2] if closed else np.unique(np.append(order[::2], order[-1]))
    found = np.zeros(values.size)
    found[kept] = weights_of(values[kept], circular=circular)
    return found


def _closing(gaps: Values) -> float:
    """Return the gap from the last angle to the first if they go round the circle, else 0."""
    closing = max(0.0, math.tau - float(gaps.sum()))
    return closing if closing <= SLACK * float(gaps.max(initial=0.0)) else 0.0


def _thinner(axes: Mapping[str, Values]) -> list[Values] | None:
    """Return the weights with each axis thinned in turn; None if one that varies cannot be."""
    full = {name: weights_of(each, circular=name == "phase") for name, each in axes.items()}
    found = []
    for name, values in axes.items():
        if np.ptp(values) == 0.0:
            continue
        fewer = thinned(values, circular=name == "phase")
        if fewer is None:
            return None
        found.append(_product(list((full | {name: fewer}).values())))
    return found


def _product(weights: list[Values]) -> Values:
    return np.ravel(reduce(np.multiply.outer, weights))


def _mean(
    values: Values, weights: Values, thinner: list[Values] | None
) -> tuple[Values, Values]:  # fmt: skip
    """Return means over the drops, and the sum of their changes as each axis is thinned."""
    mean = _weighted(values, weights)
    if thinner is None:
        return mean, np.full(mean.shape, math.nan)
    changes = [np.abs(_weighted(values, each) - mean) for each in thinner]
    return mean, np.sum(changes, axis=0) + 0.0 * mean


def _weighted(values: Values, weights: Values) -> Values:
    """Return the mean of the known values, of shape (drop, contact)."""
    known = ~np.isnan(values)
    share = np.where(known, weights[:, np.newaxis], 0.0)
    total = share.sum(axis=0)
    sums = np.where(known, values * share, 0.0).sum(axis=0)
    found: Values = np.divide(sums, total, out=np.full(total.shape, math.nan), where=total > 0.0)
    return found
