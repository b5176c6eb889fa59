"""The design of a study: all that determines the bits of its result, as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from rotor_ida.checks import shown
from rotor_ida.errors import InputError

Design = dict[str, Any]


def program_of(design: Mapping[str, Any]) -> Design:
    """Return the program in a design: versions, and a digest of sources.

    Examples
    --------
    >>> program_of({"rtol": 1e-10, "numpy_version": "2.4", "sources": "ab"})
    {'numpy_version': '2.4', 'sources': 'ab'}
    """
    return {
        name: said
        for name, said in design.items()
        if name == "sources" or name.endswith("_version")
    }


def as_text(design: Mapping[str, Any]) -> str:
    """Return a design as JSON in which every number has all its digits."""
    return json.dumps(design, sort_keys=True, allow_nan=False)


def refuse_another(folder: str, begun: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Raise `InputError` if a design differs from that of the existing study in `folder`.

    Examples
    --------
    >>> refuse_another("study", {"rtol": 1e-10}, {"rtol": 1e-09})
    Traceback (most recent call last):
    ...
    rotor_ida.errors.InputError: study 'study' was begun with rtol 1e-10, got 1e-09: resume it with
    the same arguments, or begin another in a separate folder
    """
    for name in sorted({*begun, *wanted}):
        before, now = begun.get(name, "nothing"), wanted.get(name, "nothing")
        if _differ(before, now):
            where, before, now = _part_apart(name, before, now)
            raise InputError(
                f"study {folder!r} was begun with {where} {_shown(before)}, got {_shown(now)}: "
                "resume it with the same arguments, or begin another in a separate folder"
            )


def _differ(one: object, other: object) -> bool:
    """Return whether values differ as text: 0.0 and -0.0 are equal but give other bits."""
    return as_text({"": one}) != as_text({"": other})


def _part_apart(name: str, before: Any, now: Any) -> tuple[str, Any, Any]:
    """Return the name and the values of the first part that differs, small enough to be shown."""
    parts: list[tuple[str, Any, Any]] = []
    if isinstance(before, dict) and isinstance(now, dict):
        keys = sorted({*before, *now})
        parts = [(key, before.get(key, "nothing"), now.get(key, "nothing")) for key in keys]
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        pairs = list(zip(before, now, strict=True))
        is_long = _shown(before) == _shown(now)
        if is_long or any(isinstance(each, list | dict) for pair in pairs for each in pair):
            parts = [(str(place), *pair) for place, pair in enumerate(pairs)]
    for part, one, other in parts:
        if _differ(one, other):
            return _part_apart(f"{name} {part}", one, other)
    return name, before, now


def _shown(value: object) -> str:
    counted = f" ({len(value)} values)" if isinstance(value, list) and len(value) > 6 else ""
    return f"{shown(value)}{counted}"
