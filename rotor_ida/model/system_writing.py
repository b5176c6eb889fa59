"""Write a rotor system as a system file: TOML, with its matrices in an .npz file."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import MISSING, fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.formats.replacing import put
from rotor_ida.model.contact import HERTZ_EXPONENT
from rotor_ida.model.rotor_system import RotorSystem
from rotor_ida.model.system_files import NODE
from rotor_ida.model.system_parts import Contact, Stator, stators_of

ENDING, MATRICES = ".toml", ".npz"
ARRAYS = (
    "mass", "stiffness", "damping", "gyroscopic", "stiffness_rate", "translations", "static_force",
    "added_mass",
)  # fmt: skip
PARTS = ("contacts", "unbalance", "supports", "bearings")


def write_system(system: RotorSystem, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write a system: see `RotorSystem.to_file`."""
    place = Path(path)
    if place.suffix != ENDING:
        raise InputError(f"path must end in {ENDING}, got {shown(place)}")
    if system.gravity_in_static_force is not None:
        raise InputError(
            "gravity_in_static_force must be None for a file, which has the weight by its gravity"
        )
    force = system.static_force
    if force is not None and force.size > system.size:
        raise InputError("static_force must act on the rotor alone for a file, got one on stators")
    beside = place.with_suffix(MATRICES)
    for each in (place, beside):
        if each.exists() and not overwrite:
            raise InputError(f"{shown(each)} already exists; pass overwrite=True to replace it")
    arrays: dict[str, Any] = {
        name: value for name in ARRAYS if (value := getattr(system, name)) is not None
    }
    arrays |= {f"{NODE}{name}": np.asarray(given) for name, given in system.nodes.items()}
    if system.note:
        arrays["note"] = np.array(system.note)
    try:
        # whole, or not at all: without room what is there stays
        with TemporaryDirectory(dir=place.parent, prefix=".rotor-") as name:
            written = Path(name, place.name), Path(name, beside.name)
            with written[1].open("wb") as file:
                np.savez(file, allow_pickle=False, **arrays)
            lines = "\n".join(_lines(system, beside.name)) + "\n"
            written[0].write_text(lines, encoding="utf-8")
            for part, target in zip(written, (place, beside), strict=True):
                put(part, target)
    except OSError as error:
        raise InputError(f"cannot write {shown(place)}: {error.strerror or error}") from error
    return place


def _lines(system: RotorSystem, matrices: str) -> Iterator[str]:
    """Yield the lines of a system file."""
    yield "# A rotor system for rotor_ida; its matrices are in the .npz file."
    if system.units != "SI":
        yield f"units = {_text(system.units)}"
    if system.gravity is not None:
        yield f"gravity = {_value(system.gravity)}"
    yield from ("", "[system]", f"file = {_text(matrices)}")
    if system.positions is not None:
        yield from ("", "[system.positions]")
        for name, position in system.positions.items():
            yield f"{_text(name)} = {_value(position)}"
    stators = stators_of(system.contacts)
    for number, stator in enumerate(stators):
        yield from ("", f"[stators.{_text(_name_of(system, number))}]", *_entries(stator))
    for part in PARTS:
        for each in getattr(system, part):
            yield from ("", f"[[{part}]]")
            yield from _entries(each)
            if isinstance(each, Contact) and isinstance(each.stator, Stator):
                yield f"stator = {_text(_name_of(system, stators.index(each.stator)))}"


def _name_of(system: RotorSystem, number: int) -> str:
    """Return the name of a stator, which no node has."""
    name = f"stator {number}"
    while name in system.nodes:
        name += "'"
    return name


def _entries(part: Any) -> Iterator[str]:
    """Yield the fields of a part that are not their defaults."""
    for each in fields(part):
        value = getattr(part, each.name)
        known = each.default is not MISSING and value is each.default
        is_own = each.name == "exponent" or (each.name == "stator" and isinstance(value, Stator))
        if not each.init or known or value is None or is_own:
            continue
        yield f"{each.name} = {_value(value)}"
    if isinstance(part, Contact):
        yield f"exponent = {part.exponent if part.exponent == HERTZ_EXPONENT else 1.0}"


def _value(value: Any) -> str:
    """Return a value in TOML."""
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float | int):
        return repr(float(value))
    if isinstance(value, np.ndarray | list | tuple):
        return f"[{', '.join(map(_value, np.asarray(value).tolist()))}]"
    entries = ", ".join(_entries(value))
    return f"{{ {entries} }}"


def _text(text: str | os.PathLike[str]) -> str:
    return json.dumps(str(text), ensure_ascii=False)
