"""Means, quantiles and fractions of a random sample, with their sampling errors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from scipy.stats import binom, norm, t

from rotor_ida.arrays import Column, Flags, Values

QUANTILES = (0.05, 0.5, 0.95)
# Confidence of intervals, and the fewest drops whose range holds the median with it.
LEVEL = 0.95
FEWEST = 6


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
