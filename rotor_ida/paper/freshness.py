"""Check whether the results of a scenario are up to date."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from rotor_ida.results.provenance import KINDS_OF_SOURCE, versions

RECORD = "digest.json"
# Packages that affect files and pictures, besides those that compute.
PACKAGES = ("netCDF4", "matplotlib")


def origin_of(script: Path, options: Sequence[str]) -> str:
    """Return a digest of everything that the results of a script depend on.

    Parameters
    ----------
    script : Path
        The script.
    options : sequence of str
        Options that change the results.

    Returns
    -------
    str
        SHA-256 of the script, the sources and versions of the packages, and the options.
    """
    digest = hashlib.sha256()
    package = Path(__file__).parents[1]
    files = (path for kind in KINDS_OF_SOURCE for path in package.rglob(kind))
    sources = [path for path in files if package / "scenarios" not in path.parents]
    for path in [script, *sorted(sources)]:
        name = path.name if path == script else path.relative_to(package).as_posix()
        digest.update(f"{name}\0".encode() + path.read_bytes() + b"\0")
    found = [*map(str, versions().values()), *map(version, PACKAGES)]
    digest.update("\0".join([*found, *options]).encode())
    return digest.hexdigest()


def is_fresh(folder: Path, origin: str) -> bool:
    """Return whether a folder contains the complete, unmodified results of this origin."""
    record = _read(folder)
    return record is not None and record[0] == origin and record[1] == _files(folder)


def is_ours(folder: Path) -> bool:
    """Return whether a folder contains only recorded, unmodified files, or incomplete results."""
    record = _read(folder)
    return record is not None and (record[1] is None or record[1] == _files(folder))


def begin(folder: Path) -> None:
    """Mark the results in a folder as incomplete, so that an interrupted run can be repeated."""
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder, "", None)


def record(folder: Path, origin: str) -> None:
    """Record the files of a folder and their origin; no origin if they are incomplete."""
    _write(folder, origin, _files(folder))


def _write(folder: Path, origin: str, files: dict[str, str] | None) -> None:
    noted = json.dumps({"origin": origin, "files": files}, indent=1)
    (folder / RECORD).write_text(noted + "\n", encoding="utf-8")


def _files(folder: Path) -> dict[str, str]:
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path != folder / RECORD:
            name = path.relative_to(folder).as_posix()
            found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def _read(folder: Path) -> tuple[str, dict[str, str] | None] | None:
    try:
        noted = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        files = noted["files"]
        return str(noted["origin"]), None if files is None else dict(files)
    except (OSError, ValueError, TypeError, KeyError):
        return None
