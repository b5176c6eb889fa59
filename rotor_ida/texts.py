r"""Texts of users, such as names of nodes and files, in each kind of place that they reach.

Names come from files of others. A terminal obeys some characters, XML forbids some, figures read
``$`` as mathematics, and pages, shells and Python have marks that end a text. What is refused at
the border is in `unfit`; what is not, such as names of files, is written by the function of the
place. In HTML, the templates escape marks themselves.
"""

from __future__ import annotations

import json
import math
import os
import shlex
from collections.abc import Mapping
from pathlib import PurePath
from unicodedata import category

# Characters of the name of a node, as tables can show it, and of a title of a small panel.
LONGEST_NAME, LONGEST_IN_FIGURE = 80, 28
LONGEST_NOTE = 1000
# Control characters, halves of characters, and ends of lines and paragraphs.
_UNFIT = ("Cc", "Cs", "Zl", "Zp")
# These reverse what stands after them: a name would look like another one.
_DIRECTIONS = frozenset("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
_LINES = "\n\t"


def unfit(text: str, kept: str = "") -> str:
    r"""Return the first character that no name may have and is not one of those kept, or nothing.

    Examples
    --------
    >>> unfit("disc's 2nd <node>, $x$"), unfit("disc\x1b[31m"), unfit("a\nb", kept="\n")
    ('', '\x1b', '')
    """
    if text.isprintable():
        return ""
    return next((each for each in text if each not in kept and _is_unfit(each)), "")


def printable(text: str) -> str:
    r"""Return a text for a terminal or a page: its lines, without other control characters.

    Examples
    --------
    >>> printable("\x1b]0;title\x07 disc")
    '\\x1b]0;title\\x07 disc'
    """
    if not unfit(text, _LINES):
        return text
    return "".join(
        each.encode("unicode_escape").decode()
        if each not in _LINES and _is_unfit(each) else each for each in text
    )  # fmt: skip


def brief(text: str, longest: int = LONGEST_NAME) -> str:
    r"""Return a text in one short line.

    Examples
    --------
    >>> brief("a\nb"), brief("abcdefghij", longest=7)
    ('a\\nb', 'abc…hij')
    """
    line = printable(text).replace("\n", r"\n").replace("\t", r"\t")
    half = longest // 2
    return line if len(line) <= longest else f"{line[:half]}…{line[-half:]}"


def in_figure(text: str) -> str:
    r"""Return a text for a figure: no mathematics, and not hidden from legends by an underscore.

    Examples
    --------
    >>> in_figure(r"$\frac{1}{$"), in_figure("_disc")
    ('\\$\\frac{1}{\\$', ' _disc')
    """
    line = brief(text, LONGEST_IN_FIGURE).replace("$", r"\$")
    return f" {line}" if line.startswith("_") else line


def in_page(value: object) -> str:
    r"""Return a value as JSON for a script element, which no text in it can end.

    Examples
    --------
    >>> in_page({"node": "</script>"})
    '{"node": "\\u003c/script\\u003e"}'
    """
    text = json.dumps(value)
    for mark in "<>&":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return text


def in_shell(word: str | PurePath) -> str:
    r"""Return a word of a command line for a POSIX shell; a path never looks like an option.

    Examples
    --------
    >>> print(in_shell("my pump.toml"), in_shell(PurePath("-x.toml")), in_shell("a\nb"))
    'my pump.toml' ./-x.toml $'a\x0ab'
    """
    text = str(word)
    if isinstance(word, PurePath) and text.startswith("-"):
        text = os.path.join(os.curdir, text)
    if text.isprintable():
        return shlex.quote(text)
    # as a terminal would obey control characters within quotes
    letters = (chr(byte) if 32 <= byte < 127 and chr(byte) not in "'\\" else f"\\x{byte:02x}"
               for byte in os.fsencode(text))  # fmt: skip
    return f"$'{''.join(letters)}'"


def _is_unfit(letter: str) -> bool:
    code = ord(letter)
    is_none = code & 0xFFFE == 0xFFFE or 0xFDD0 <= code <= 0xFDEF
    return category(letter) in _UNFIT or letter in _DIRECTIONS or is_none


def plain(value: object) -> object:
    """Return a value for JSON: arrays as lists, and null for a number that is not finite.

    Examples
    --------
    >>> plain({"exit_time": float("nan"), "start": (1, 0.5)})
    {'exit_time': None, 'start': [1, 0.5]}
    """
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if hasattr(value, "tolist"):  # of NumPy
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
