"""Formulas spelled out in plain text, as HTML."""

from __future__ import annotations

import re
from collections.abc import Callable
from html import escape


def typeset(text: str) -> str:
    """Return plain text as HTML, with the Greek letters, powers and indices that it spells out.

    Examples
    --------
    >>> typeset("omega_0^2 = k sqrt(D)/m & delta0 > 1e-09")
    'ω<sub>0</sub><sup>2</sup> = k √D/m &amp; δ<sub>0</sub> &gt; 10<sup>−9</sup>'
    """
    shown = escape(text, quote=False)
    for pattern, put in _TYPESET:
        shown = re.sub(pattern, put, shown)
    return shown


def _greek(found: re.Match[str]) -> str:
    return _GREEK[found[1]] + (f"<sub>{found[2]}</sub>" if found[2] else "")


def _power_of_ten(found: re.Match[str]) -> str:
    factor = "" if found[1] == "1" else f"{found[1]}·"
    return f"{factor}10<sup>{found[2].replace('-', '−').lstrip('+')}{found[3]}</sup>"


_GREEK = {"omega": "ω", "zeta": "ζ", "delta": "δ", "lambda": "λ", "theta": "θ"}
# In this order: what the first have put, the next leave alone.
_TYPESET: tuple[tuple[str, str | Callable[[re.Match[str]], str]], ...] = (
    (r"\b(\d+(?:\.\d+)?)e([+-]?)0*(\d+)\b", _power_of_ten),
    (r"\b(omega|zeta|delta|lambda|theta)(?:_?(\d))?(?![A-Za-z])", _greek),
    (r"sqrt\((\w+)\)", r"√\1"),
    (r"\b([a-zA-Z])_(\w)\b", r"\1<sub>\2</sub>"),
    (r"\b([xyC])(\d)\b", r"\1<sub>\2</sub>"),
    (r"(?<=[xyz])'|(?<=[xy]<sub>0</sub>)'", "′"),
    (r"\^(-?\d*\.?\d+)", r"<sup>\1</sup>"),
    (r"(?<![\w.])-(?=\d)", "−"),
    (r" - ", " − "),
    (r"(?<=\))-(?=\()", "–"),
)
