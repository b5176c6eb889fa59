"""Read the matrices of a rotor system: .npz, .mat, or a folder of Matrix Market files.

Names are those of `RotorSystem`, or the letters of the equation: ``mass`` or ``M``, ``stiffness``
or ``K``, ``damping`` or ``C``, ``gyroscopic`` or ``G``, ``stiffness_rate`` or ``K_dot``. Nodes are
arrays ``node_NAME``: two indices, counted from 0, or two rows. A ``note`` is text.
"""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np

from rotor_ida.arrays import Values
from rotor_ida.checks import shown
from rotor_ida.errors import InputError
from rotor_ida.formats.matlab import HEAD, arrays_of, is_hdf5
from rotor_ida.formats.matrix_market import matrix_of
from rotor_ida.formats.npz import member_of
from rotor_ida.model.data_sheet import OF_LINEAR, in_si
from rotor_ida.model.rotor_system import MOST_COORDINATES, check_dimensions

NAMES = {
    "M": "mass", "K": "stiffness", "C": "damping", "G": "gyroscopic", "K_dot": "stiffness_rate",
}  # fmt: skip
OTHERS = ("translations", "static_force", "added_mass")
PAIRS = ("xx", "xy", "yx", "yy")
NODE, NOTE = "node_", "note"
# Names in a message.
MOST_SHOWN = 8
# Eight full matrices of the largest system, as numbers or as text.
MOST_BYTES = 8 * 8 * MOST_COORDINATES**2


def read_system(path: str | Path) -> dict[str, Any]:
    """Return the arguments of a `RotorSystem` from a file.

    Parameters
    ----------
    path : str or Path
        A file ``.npz`` or ``.mat`` (up to version 7.2), or a folder of ``.mtx`` files.

    Returns
    -------
    dict
        The arguments.

    Raises
    ------
    InputError
        If the file cannot be read, or has no mass or stiffness matrix.
    """
    place = Path(path)
    try:
        if place.is_dir():
            arrays = _matrix_market(place)
        elif place.suffix == ".npz":
            arrays = _numpy(place)
        elif place.suffix == ".mat":
            arrays = _matlab(place)
        else:
            raise InputError(
                "a system must be a .npz or .mat file, or a folder of .mtx files, got "
                f"{shown(place)}"
            )
    except InputError:
        raise
    except Exception as error:  # a damaged file can make the libraries raise anything
        told = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"cannot read the system {shown(place)}: {told[:200]}") from error
    return _arguments(arrays, shown(place))


def read_table(path: str | Path) -> dict[str, Any]:
    """Return the columns of a table of a bearing, by name, from a file .npz or .csv.

    Names are ``speed stiffness damping``, or ``kxx kxy kyx kyy cxx cxy cyx cyy`` for these. The
    first line of a .csv file has the names, each with its unit in brackets, if it is not the one in
    SI: ``speed [rpm],kxx [N/m],cxx [N s/m]``. Coefficients that are not there are those of the
    other direction, or 0 across.

    Returns
    -------
    dict
        ``speed``, ``stiffness`` and ``damping``.

    Raises
    ------
    InputError
        If the file cannot be read, or has other columns.
    """
    place = Path(path)
    _check_file(place)
    try:
        if place.suffix == ".npz":
            with np.load(place, allow_pickle=False) as file:
                columns = {name: np.asarray(file[name], float) for name in file.files}
        elif place.suffix == ".csv":
            columns = _csv(place)
        else:
            raise InputError(f"a table must be a .npz or .csv file, got {shown(place)}")
    except InputError:
        raise
    except (OSError, ValueError, IndexError, zipfile.BadZipFile) as error:
        told = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"cannot read the table {shown(place)}: {told[:200]}") from error
    known = ("speed", "stiffness", "damping", *(f"{letter}{pair}" for letter in "kc"
                                                 for pair in PAIRS))  # fmt: skip
    for name in columns:
        if name not in known:
            raise InputError(
                f"columns of {shown(place)} must be {', '.join(known)}, got {shown(name)}"
            )
    if "speed" not in columns or not {"stiffness", "kxx"} & columns.keys():
        raise InputError(f"{shown(place)} must hold speed and stiffness or kxx")
    return {"speed": columns["speed"], "stiffness": _coefficients(columns, "stiffness", "k"),
            "damping": _coefficients(columns, "damping", "c")}  # fmt: skip


def _coefficients(columns: dict[str, Values], name: str, letter: str) -> Values:
    """Return a column of matrices, or one of them made of its entries."""
    if name in columns:
        return columns[name]
    zero = np.zeros_like(columns["speed"])
    xx = columns.get(f"{letter}xx", zero)
    rows = [[xx, columns.get(f"{letter}xy", zero)],
            [columns.get(f"{letter}yx", zero), columns.get(f"{letter}yy", xx)]]  # fmt: skip
    return np.moveaxis(np.array(rows), -1, 0)


def _csv(place: Path) -> dict[str, Values]:
    """Return the columns of a .csv file in SI units."""
    _check_bytes(place, place.stat().st_size)
    head, *lines = place.read_text(encoding="utf-8-sig").splitlines()
    if ";" in head:
        raise InputError(
            f"{shown(place)} must have commas between its columns and points in its numbers, got "
            "semicolons"
        )
    rows = [line.split(",") for line in lines if line.strip()]
    numbers = np.array([list(map(float, row)) for row in rows]).reshape(len(rows), -1)
    found = {}
    for number, title in enumerate(head.split(",")):
        name, _, unit = title.strip().rstrip("]").partition("[")
        name = name.strip()
        wanted = {"s": "rad s-1", "k": OF_LINEAR, "c": "N s m-1"}.get(name[:1], "1")
        factor = in_si(f"the unit of {name}", f"1 {unit.strip()}", wanted) if unit.strip() else 1.0
        found[name] = factor * numbers[:, number]
    return found


def _arguments(arrays: dict[str, Any], path: str) -> dict[str, Any]:
    """Return arrays by the names of arguments."""
    found: dict[str, Any] = {}
    nodes: dict[str, Any] = {}
    for name, values in arrays.items():
        own = NAMES.get(name, name)
        if not _is_wanted(name):
            continue
        check_dimensions(shown(name), getattr(values, "shape", ()))
        given = values.toarray() if hasattr(values, "toarray") else np.asarray(values)
        if name == NOTE:
            found[NOTE] = " ".join(" ".join(map(str, np.ravel(values))).split())
        elif name.startswith(NODE):
            nodes[name.removeprefix(NODE)] = given.ravel() if given.size == 2 else given
        elif own in found:
            raise InputError(f"{path} must name the matrix {own} once, got it twice")
        else:
            found[own] = given.ravel() if own == "static_force" else given
    missing = [name for name in ("mass", "stiffness") if name not in found]
    if missing:
        held = ", ".join(map(shown, sorted(arrays)[:MOST_SHOWN])) or "nothing"
        raise InputError(f"{path} must hold {' and '.join(missing)}, got {held}")
    return found | {"nodes": nodes}


def _is_wanted(name: str) -> bool:
    own = NAMES.get(name, name)
    return own in {*NAMES.values(), *OTHERS, NOTE} or name.startswith(NODE)


def _numpy(path: Path) -> dict[str, Any]:
    """Return the arrays of a system in a .npz file; of others the name alone."""
    found: dict[str, Any] = {}
    _check_file(path)
    with zipfile.ZipFile(path) as archive:
        members = {each.filename.removesuffix(".npy"): each for each in archive.infolist()}
        wanted = {name: each for name, each in members.items() if _is_wanted(name)}
        _check_bytes(path, sum(each.file_size for each in wanted.values()))
        for name, member in members.items():
            found[name] = member_of(archive, member) if name in wanted else None
    return found


def _matlab(path: Path) -> dict[str, Any]:
    _check_file(path)
    _check_bytes(path, path.stat().st_size)
    held = path.read_bytes()
    if is_hdf5(held[:HEAD]):
        raise InputError(f"{shown(path)} must be a .mat file of version 7, save it with -v7")
    return arrays_of(held, MOST_BYTES)


def _matrix_market(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for path in sorted(folder.glob("*.mtx")):
        found[path.stem] = None
        if _is_wanted(path.stem):
            _check_file(path)
            _check_bytes(path, path.stat().st_size)
            try:
                found[path.stem] = matrix_of(path, MOST_COORDINATES)
            except ValueError as error:
                raise ValueError(f"{shown(path.name)}: {error}") from error
    return found


def _check_file(path: Path) -> None:
    """Refuse what a reader would wait for."""
    if path.exists() and not path.is_file():
        raise InputError(f"a system must be a file, got the device or pipe {shown(path)}")


def _check_bytes(path: Path, count: int) -> None:
    """Refuse more than the matrices of the largest system."""
    if count > MOST_BYTES:
        raise InputError(
            f"{shown(path)} must have at most {MOST_BYTES} bytes, which hold the matrices of "
            f"{MOST_COORDINATES} degrees of freedom, got {count}"
        )
