"""What a study computes, and how that differs from what it was begun with."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Mapping
from typing import Any

from rotor_ida.errors import InputError

Design = dict[str, Any]

_SHOWN = reprlib.Repr()
_SHOWN.maxlist = 4
_SHOWN.maxstring = 80

_ABSENT = "nothing"


def as_text(design: Mapping[str, Any]) -> str:
    """Return a design as JSON in which every number keeps all its digits."""
    return json.dumps(design, sort_keys=True, allow_nan=False)


def refuse_another(folder: str, begun: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Refuse a design that differs from that with which the study in `folder` was begun.

    Raises
    ------
    InputError
        With the first difference named.

    Examples
    --------
    >>> refuse_another("study", {"rtol": 1e-10}, {"rtol": 1e-09})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: study 'study' was begun with rtol 1e-10, got 1e-09: go on with what
    it was begun with, or begin another in a folder of its own
    """
    for name in sorted({*begun, *wanted}):
        before, now = begun.get(name, _ABSENT), wanted.get(name, _ABSENT)
        # as text, since 0.0 and -0.0 are equal but give other bits
        if as_text({name: before}) != as_text({name: now}):
            raise InputError(
                f"study {folder!r} was begun with {name} {_shown(before)}, got {_shown(now)}: go "
                "on with what it was begun with, or begin another in a folder of its own"
            )


def _shown(value: object) -> str:
    counted = f" ({len(value)} values)" if isinstance(value, list) and len(value) > 4 else ""
    return f"{_SHOWN.repr(value)}{counted}"
