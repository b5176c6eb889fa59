"""The first root of a function, with proof that there is none before it.

`function(order, ball)` encloses the derivative of that order over a ball (an interval).
"""

from flint import arb

from .motion import UnresolvedError

DEEPEST = 120
NARROWEST = 40  # bits by which a bracket is bisected before Newton's method takes over


def first_root(function, end, leading=0):
    """Return the first root in (0, end] of a function that starts negative, or None.

    At 0 the derivatives below `leading` are zero and that one is negative, so that the function
    is negative just after 0. A piece has no root where max(ends) + width^2 max|f''|/8 < 0, and
    at most one where f' keeps its sign; every other piece is halved, the left half first.
    """
    pieces = [(arb(0), end, 0)]
    while pieces:
        left, right, depth = pieces.pop()
        if depth > DEEPEST:
            raise UnresolvedError(f"a touch at {left} cannot be told from a miss")
        ball = left.union(right)
        if left == 0 and leading > 0:
            if function(leading, ball) < 0:
                continue
        else:
            low, high = function(0, left), function(0, right)
            bulge = (right - left) ** 2 / 8 * function(2, ball).abs_upper()
            if low + bulge < 0 and high + bulge < 0:
                continue
            if not function(1, ball).contains(0):
                if high < 0 and low < 0:
                    continue
                if low < 0 < high:
                    return polish(function, left, right)
        middle = ((left + right) / 2).mid()
        pieces += [(middle, right, depth + 1), (left, middle, depth + 1)]
    return None


def polish(function, left, right):
    """Return the only root between left and right, where the function rises through zero."""
    for _ in range(NARROWEST):
        middle = ((left + right) / 2).mid()
        if function(0, middle) < 0:
            left = middle
        else:
            right = middle
    root = middle
    for _ in range(10):
        root = (root - function(0, root) / function(1, root)).mid()
    return root
