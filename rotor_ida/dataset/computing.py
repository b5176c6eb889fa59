"""What decides on the bits of a result beside its parameters: versions and sources."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from rotor_ida.dataset.provenance import versions

# Without these folders and modules, a result is drawn, told or kept otherwise, but not computed so.
NO_PART = frozenset(
    [
        *("analysis", "archive", "cli", "errata", "plot", "printed", "scenarios"),
        *("comparison", "freshness", "gallery", "reproduction", "scenario", "testing"),
        *("resuming", "verification"),
    ]
)
_INDIFFERENT = ("python_version", "xarray_version")


@cache
def computing() -> dict[str, str]:
    """Return versions of all that computes, and a digest of this package's own sources.

    Examples
    --------
    >>> sorted(computing())[:2]
    ['numba_version', 'numpy_version']
    """
    found = {name: str(each) for name, each in versions().items() if name not in _INDIFFERENT}
    return found | {"sources": _digest()}


def _digest() -> str:
    digest = hashlib.sha256()
    package = Path(__file__).parents[1]
    for path in sorted(package.rglob("*.py")):
        name = path.relative_to(package)
        if name.parts[0].removesuffix(".py") not in NO_PART:
            digest.update(f"{name.as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()
