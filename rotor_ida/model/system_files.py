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

from rotor_ida.errors import InputError

NAMES = {
    "M": "mass", "K": "stiffness", "C": "damping", "G": "gyroscopic", "K_dot": "stiffness_rate",
}  # fmt: skip
OTHERS = ("translations", "static_force", "added_mass")
NODE = "node_"


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
            with np.load(place, allow_pickle=False) as held:
                arrays = {name: held[name] for name in held.files}
        elif place.suffix == ".mat":
            arrays = _matlab(place)
        else:
            raise InputError(
                "a system must be a .npz or .mat file, or a folder of .mtx files, got "
                f"{str(path)!r}"
            )
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError, NotImplementedError, EOFError,
            zipfile.BadZipFile, MemoryError) as error:  # fmt: skip
        told = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"cannot read the system {str(path)!r}: {told}") from error
    return _arguments(arrays, str(path))


def _arguments(arrays: dict[str, Any], path: str) -> dict[str, Any]:
    """Return arrays by the names of arguments."""
    found: dict[str, Any] = {}
    nodes: dict[str, Any] = {}
    for name, values in arrays.items():
        own = NAMES.get(name, name)
        if own in {*NAMES.values(), *OTHERS}:
            if own in found:
                raise InputError(f"{path!r} must name the matrix {own} once, got it twice")
            given = values.toarray() if hasattr(values, "toarray") else np.asarray(values)
            found[own] = given.ravel() if own == "static_force" else given
        elif name == "note":
            found["note"] = " ".join(map(str, np.ravel(values)))
        elif name.startswith(NODE):
            node = np.asarray(values.toarray() if hasattr(values, "toarray") else values)
            nodes[name.removeprefix(NODE)] = node.ravel() if node.size == 2 else node
    missing = [name for name in ("mass", "stiffness") if name not in found]
    if missing:
        held = ", ".join(sorted(arrays)) or "nothing"
        raise InputError(f"{path!r} must hold {' and '.join(missing)}, got {held}")
    return found | {"nodes": nodes}


def _matlab(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat  # noqa: PLC0415
    from scipy.io.matlab import MatReadError  # noqa: PLC0415

    try:
        held = loadmat(path)
    except MatReadError as error:
        raise InputError(f"cannot read the system {str(path)!r}: {error}") from error
    return {name: values for name, values in held.items() if not name.startswith("__")}


def _matrix_market(folder: Path) -> dict[str, Any]:
    from scipy.io import mmread  # noqa: PLC0415

    return {path.stem: mmread(path) for path in sorted(folder.glob("*.mtx"))}
