"""Means, quantiles and fractions of many drops: of a random sample, or over a grid.

A sample has sampling errors. A grid is none: a mean over it is a quadrature, whose error shows in
what it changes by when every other value of an axis is left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce

import numpy as np
import numpy.typing as npt
from scipy.stats import binom, norm, t

from rotor_ida.arrays import Column, Flags, Values

QUANTILES = (0.05, 0.5, 0.95)
# Confidence of intervals, and the fewest drops whose range holds the median with it.
LEVEL = 0.95
FEWEST = 6
# How much longer the gap between the last angle and the first may be than the longest other one,
# for the angles to go round.
SLACK = 1.0 + 1e-6


def statistics_of(
    numbers: Mapping[str, Values],
    facts: Mapping[str, Flags],
    along: Mapping[str, str],
    possible: Mapping[str, tuple[float, float]],
) -> dict[str, Column]:
    """Return statistics of figures of shape (drop, contact), by name.

    A figure that is NaN in a drop does not count there; one that fewer than `FEWEST` have has no
    quantiles and no intervals. ``along`` names its other dimension, where it is not the contact,
    and ``possible`` its least and its largest value, which bound the interval of the mean.
    """
    found: dict[str, Column] = {}
    levels = np.array(QUANTILES)
    for name, values in numbers.items():
        dim = along.get(name, "contact")
        columns = [column[~np.isnan(column)] for column in values.T]
        means = np.array([mean_of(column) for column in columns])
        few = np.array([column.size < FEWEST for column in columns])
        means[:, 2:] = np.clip(means[:, 2:], *possible[name])
        means[few, 2:] = np.nan
        for word, each in zip(("", "_error", "_low", "_high"), means.T, strict=True):
            found[f"{name}_mean{word}"] = (dim, each)
        of_all = [quantiles_of(column, levels) for column in columns]
        quantile, low, high = map(np.array, zip(*of_all, strict=True))
        for word, each in (("", quantile), ("_low", low), ("_high", high)):
            each[few] = np.nan
            found[f"{name}_quantile{word}"] = (("quantile", dim), each.T)
    for name, flags in facts.items():
        fraction, low, high = wilson(flags.sum(axis=0), len(flags))
        found[f"{name}_fraction"] = ("contact", fraction)
        found[f"{name}_fraction_low"] = ("contact", low)
        found[f"{name}_fraction_high"] = ("contact", high)
    return found


def mean_of(values: Values) -> tuple[float, float, float, float]:
    """Return a mean, its standard error, and the ends of its interval.

    Notes
    -----
    The interval holds both Student's and Hall's. Student's alone holds the mean of a skew figure
    too seldom; Hall's transformation of Student's T removes the skewness g, for a sample of n:
    ``T + g T**2/(3 sqrt(n)) + g**2 T**3/(27 n) + g/(6 sqrt(n))``.

    References
    ----------
    P. Hall, J. R. Stat. Soc. B 54 (1992) 221.

    Examples
    --------
    >>> [round(each, 3) for each in mean_of(np.arange(1.0, 21.0))]
    [10.5, 1.323, 7.731, 13.269]
    >>> [round(each) for each in mean_of(np.arange(1.0, 21.0) ** 4)]
    [36133, 10813, 13502, 68851]
    """
    count = values.size
    if not count:
        return np.nan, np.nan, np.nan, np.nan
    mean = float(values.mean())
    if count == 1:
        return mean, np.nan, -np.inf, np.inf
    error = float(values.std(ddof=1) / np.sqrt(count))
    bound = float(t.ppf(0.5 * (1.0 + LEVEL), count - 1))
    skewness = _skewness(values - mean)
    ends = np.array([-bound, bound])
    if skewness != 0.0:
        part = 3.0 * np.sqrt(count) / skewness
        ends = part * (np.cbrt(1.0 + 3.0 * ends / part - 1.5 / part**2) - 1.0)
    below, above = max(bound, float(ends[1])), max(bound, float(-ends[0]))
    return mean, error, mean - error * below, mean + error * above


def _skewness(deviations: Values) -> float:
    """Return the skewness of a sample, corrected for its size; 0 for two or where all agree."""
    count, square = deviations.size, float(np.mean(deviations**2))
    if count < 3 or square == 0.0:
        return 0.0
    factor = np.sqrt(count * (count - 1)) / (count - 2)
    return float(factor * np.mean(deviations**3) / square**1.5)


def quantiles_of(values: Values, levels: Values) -> tuple[Values, Values, Values]:
    """Return quantiles and the ends of their intervals.

    An interval ends at two order statistics. How many of the sample lie below the quantile is
    binomial, whatever the distribution.

    Examples
    --------
    >>> quantiles_of(np.arange(1.0, 21.0), np.array([0.5]))
    (array([10.5]), array([6.]), array([15.]))
    """
    count = values.size
    if not count:
        blank = np.full(levels.size, np.nan)
        return blank, blank, blank
    ordered = np.sort(values)
    padded = np.concatenate([[-np.inf], ordered, [np.inf]])
    below = binom.ppf(0.5 * (1.0 - LEVEL), count, levels).astype(int)
    above = binom.ppf(0.5 * (1.0 + LEVEL), count, levels).astype(int) + 1
    return np.quantile(ordered, levels), padded[below], padded[above]


def wilson(counts: npt.NDArray[np.integer], total: int) -> tuple[Values, Values, Values]:
    """Return fractions and the ends of Wilson's 95 % intervals.

    References
    ----------
    E. B. Wilson, J. Am. Stat. Assoc. 22 (1927) 209.

    Examples
    --------
    >>> [each.round(3).tolist() for each in wilson(np.array([0, 5]), 10)]
    [[0.0, 0.5], [0.0, 0.237], [0.278, 0.763]]
    """
    fraction = np.asarray(counts, float) / total if total else np.full(np.shape(counts), np.nan)
    if not total:
        return fraction, fraction, fraction
    z = float(norm.ppf(0.5 * (1.0 + LEVEL)))
    middle = (fraction + z**2 / (2 * total)) / (1.0 + z**2 / total)
    half = z * np.sqrt(fraction * (1.0 - fraction) / total + (z / (2 * total)) ** 2)
    half /= 1.0 + z**2 / total
    low = np.where(fraction == 0.0, 0.0, middle - half)  # exactly: rounding may leave it above
    return fraction, low, np.where(fraction == 1.0, 1.0, middle + half)


# ---- Over a grid ----


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
