"""Roots of many scalar functions at once, each kept between two points of opposite sign."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]
Rows = npt.NDArray[np.int_]
Evaluate = Callable[[Values, Rows], tuple[Values, Values]]

_MOST_ITERATIONS = 300  # bisection alone needs about 60 in u, and 1100 only from subnormals
_ENOUGH = 2.0**-52


def bracketed_newton(
    evaluate: Evaluate,
    low: Values,
    high: Values,
    rising: npt.NDArray[np.bool_],
    start: Values | None = None,
) -> Values:
    """Return the root of each function between `low` and `high`.

    Parameters
    ----------
    evaluate : callable
        ``evaluate(points, rows)`` gives values and slopes of the functions number `rows`.
    low, high : ndarray, shape (n,)
        Ends of the brackets; the function changes sign between them.
    rising : ndarray of bool, shape (n,)
        Whether the function is negative at `low`.
    start : ndarray, shape (n,), optional
        First guesses; the middle of the bracket if left out.

    Returns
    -------
    ndarray, shape (n,)
        The roots, to the last bit or two that `evaluate` can tell apart.

    Notes
    -----
    Newton's method, with bisection whenever a step would leave the bracket or fails to halve
    the one before (Press et al., "Numerical Recipes", ``rtsafe``).

    Examples
    --------
    >>> import numpy as np
    >>> square = lambda u, rows: (u**2 - 2.0, 2.0 * u)
    >>> bracketed_newton(square, np.array([0.0]), np.array([2.0]), np.array([True]))
    array([1.41421356])
    """
    low, high = low.copy(), high.copy()
    root = 0.5 * (low + high) if start is None else np.clip(start, low, high)
    step_before = high - low
    active = np.arange(root.size)
    for _ in range(_MOST_ITERATIONS):
        if not active.size:
            break
        point = root[active]
        value, slope = evaluate(point, active)
        above = (value > 0.0) == rising[active]
        high[active] = np.where(above, point, high[active])
        low[active] = np.where(above, low[active], point)
        step = np.divide(value, slope, out=np.full_like(value, np.inf), where=slope != 0.0)
        target = point - step
        bisect = (
            (target <= low[active])
            | (target >= high[active])
            | (2.0 * np.abs(step) > np.abs(step_before[active]))
        )
        bisect &= np.abs(step) > _ENOUGH * np.abs(point)
        middle = 0.5 * (low[active] + high[active])
        target = np.where(value == 0.0, point, np.where(bisect, middle, target))
        root[active] = target
        step_before[active] = target - point
        active = active[np.abs(target - point) > _ENOUGH * np.abs(target)]
    return root


def roots_between(
    evaluate: Evaluate, breakpoints: Values, at_breakpoints: Values
) -> tuple[Values, npt.NDArray[np.bool_]]:
    """Return the one root in each interval where a monotone function changes sign.

    Parameters
    ----------
    evaluate : callable
        ``evaluate(points, rows)`` gives values and slopes of the functions number `rows`.
    breakpoints : ndarray, shape (n, k + 1)
        Ascending ends of the intervals; an interval may be empty.
    at_breakpoints : ndarray, shape (n, k + 1)
        Values, or their signs, at `breakpoints`.

    Returns
    -------
    roots : ndarray, shape (n, k)
        The root in each interval, NaN where there is none.
    rising : ndarray of bool, shape (n, k)
        Whether the function goes from negative to positive there.

    Examples
    --------
    >>> import numpy as np
    >>> square = lambda u, rows: (u**2 - 2.0, 2.0 * u)
    >>> roots_between(square, np.array([[0.0, 2.0, 3.0]]), np.array([[-2.0, 2.0, 7.0]]))
    (array([[1.41421356,        nan]]), array([[ True, False]]))
    """
    left, right = np.sign(at_breakpoints[:, :-1]), np.sign(at_breakpoints[:, 1:])
    rows, columns = np.nonzero(left * right < 0.0)
    rising = (left < 0.0) & (right > 0.0)
    roots = np.full(left.shape, np.nan)
    roots[rows, columns] = bracketed_newton(
        lambda points, chosen: evaluate(points, rows[chosen]),
        breakpoints[rows, columns],
        breakpoints[rows, columns + 1],
        rising[rows, columns],
    )
    return roots, rising
