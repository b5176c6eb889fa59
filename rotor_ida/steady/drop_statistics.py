"""Means, quantiles and fractions of a random sample, with their sampling errors."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
from scipy.stats import binom, norm

from rotor_ida.arrays import Column, Flags, Values

QUANTILES = (0.05, 0.5, 0.95)
# Confidence of intervals.
LEVEL = 0.95


def statistics_of(
    numbers: Mapping[str, Values], facts: Mapping[str, Flags]
) -> tuple[dict[str, Column], Values]:
    """Return statistics of figures of shape (drop, contact), by name; and the quantiles.

    A figure that is NaN in a drop does not count there.
    """
    found: dict[str, Column] = {}
    levels = np.array(QUANTILES)
    for name, values in numbers.items():
        by_contact = [of_known(column[~np.isnan(column)], levels) for column in values.T]
        mean, error, quantile, low, high = map(np.array, zip(*by_contact, strict=True))
        found[f"{name}_mean"] = ("contact", mean)
        found[f"{name}_mean_error"] = ("contact", error)
        for word, each in (("", quantile), ("_low", low), ("_high", high)):
            found[f"{name}_quantile{word}"] = (("quantile", "contact"), each.T)
    for name, flags in facts.items():
        fraction, low, high = wilson(flags.sum(axis=0), len(flags))
        found[f"{name}_fraction"] = ("contact", fraction)
        found[f"{name}_fraction_low"] = ("contact", low)
        found[f"{name}_fraction_high"] = ("contact", high)
    return found, levels


def of_known(values: Values, levels: Values) -> tuple[float, float, Values, Values, Values]:
    """Return mean, its standard error, quantiles, and the ends of their intervals.

    The interval of a quantile ends at two order statistics. How many of the sample lie below the
    quantile is binomial, whatever the distribution.

    Examples
    --------
    >>> mean, error, middle, low, high = of_known(np.arange(1.0, 21.0), np.array([0.5]))
    >>> mean, round(error, 3), middle, low, high
    (10.5, 1.323, array([10.5]), array([6.]), array([15.]))
    """
    count = values.size
    if not count:
        blank = np.full(levels.size, np.nan)
        return np.nan, np.nan, blank, blank, blank
    ordered = np.sort(values)
    padded = np.concatenate([[-np.inf], ordered, [np.inf]])
    below = binom.ppf(0.5 * (1.0 - LEVEL), count, levels).astype(int)
    above = binom.ppf(0.5 * (1.0 + LEVEL), count, levels).astype(int) + 1
    spread = float(values.std(ddof=1)) / np.sqrt(count) if count > 1 else np.nan
    return (float(values.mean()), float(spread), np.quantile(ordered, levels),
            padded[below], padded[above])  # fmt: skip


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
