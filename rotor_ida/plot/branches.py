"""Join the whirls found at each speed to the branches of a response curve.

From one speed to the next every whirl moves a little. Where two are gone (or new) they have met
at a fold, and the branch turns round there.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]
Flags = npt.NDArray[np.int8]


@dataclass(slots=True)
class Branch:
    """A piece of a response curve whose whirls are all stable, all unstable or all neutral.

    Parameters
    ----------
    stability : int
        The flag of its whirls.
    omega, value : list of float
        Speeds [1] and what is drawn over them.
    """

    stability: int
    omega: list[float] = field(default_factory=list)
    value: list[float] = field(default_factory=list)


def trace_branches(
    omega: Values,
    amplitude: Values,
    value: Values,
    stability: Flags,
    *,
    unstable: int,
    fold_omega: Values,
    fold_value: Values,
) -> list[Branch]:
    """Return the branches of a response curve.

    Parameters
    ----------
    omega : ndarray, shape (n,)
        Speeds, increasing [1].
    amplitude, value, stability : ndarray, shape (n, b)
        The whirls at each speed in order of amplitude, NaN where there are fewer: amplitude
        [1], what is drawn, and the flag of stability.
    unstable : int
        The flag of an unstable whirl.
    fold_omega, fold_value : ndarray, shape (m,)
        The folds, where known: a branch that ends is drawn as far as its fold.
    """
    counts = np.isfinite(amplitude).sum(axis=1)
    done: list[Branch] = []
    live = [
        Branch(int(stability[0, j]), [float(omega[0])], [float(value[0, j])])
        for j in range(counts[0])
    ]
    for i in range(1, omega.size):
        left = _Whirls(amplitude[i - 1, : counts[i - 1]], stability[i - 1, : counts[i - 1]])
        right = _Whirls(amplitude[i, : counts[i]], stability[i, : counts[i]])
        lost, new = _unmatched(left, right, unstable)
        between = (fold_omega >= omega[i - 1]) & (fold_omega <= omega[i])
        folds = (fold_omega[between], fold_value[between])
        _turn([live[j] for j in lost], *folds, at_end=True)
        done += [live[j] for j in lost]
        kept = [branch for j, branch in enumerate(live) if j not in lost]
        live = []
        for k in range(counts[i]):
            point, flag = (float(omega[i]), float(value[i, k])), int(stability[i, k])
            branch = Branch(flag) if k in new else kept.pop(0)
            if branch.stability != flag:
                done.append(branch)
                branch = Branch(flag, [branch.omega[-1]], [branch.value[-1]])
            branch.omega.append(point[0])
            branch.value.append(point[1])
            live.append(branch)
        _turn([live[k] for k in new], *folds, at_end=False)
    return done + live


@dataclass(frozen=True, slots=True)
class _Whirls:
    amplitude: Values
    stability: Flags


def _unmatched(
    left: _Whirls, right: _Whirls, unstable: int
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return which whirls of the left have no successor and which of the right are new."""
    if left.amplitude.size == right.amplitude.size:
        return (), ()
    fewer, more = sorted((left, right), key=lambda whirls: whirls.amplitude.size)
    surplus = more.amplitude.size - fewer.amplitude.size

    def cost(dropped: tuple[int, ...]) -> tuple[int, int, float]:
        keep = [j for j in range(more.amplitude.size) if j not in dropped]
        jumps = np.abs(np.log1p(more.amplitude[keep]) - np.log1p(fewer.amplitude))
        changed = int((more.stability[keep] != fewer.stability).sum())
        odd = sum(not _can_meet(pair, more, unstable) for pair in _pairs(dropped))
        return odd, changed, float(jumps.sum())

    dropped = min(combinations(range(more.amplitude.size), surplus), key=cost)
    return (dropped, ()) if more is left else ((), dropped)


def _pairs(numbers: tuple[int, ...]) -> list[tuple[int, int]]:
    return list(zip(numbers[::2], numbers[1::2], strict=False))


def _can_meet(pair: tuple[int, int], whirls: _Whirls, unstable: int) -> bool:
    """Return whether two whirls are neighbours of which one is unstable."""
    neighbours = pair[1] - pair[0] == 1
    return neighbours and (whirls.stability[list(pair)] == unstable).sum() == 1


def _turn(branches: list[Branch], fold_omega: Values, fold_value: Values, *, at_end: bool) -> None:
    """Join the ends of branches that meet at a fold: at the fold itself, or half way."""
    end = -1 if at_end else 0
    for lower, upper in zip(branches[::2], branches[1::2], strict=False):
        omega, value = lower.omega[end], 0.5 * (lower.value[end] + upper.value[end])
        if fold_omega.size:
            nearest = int(np.abs(fold_value - value).argmin())
            omega, value = float(fold_omega[nearest]), float(fold_value[nearest])
        for branch in (lower, upper):
            place = len(branch.omega) if at_end else 0
            branch.omega.insert(place, omega)
            branch.value.insert(place, value)
