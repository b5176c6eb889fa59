"""Which of this package's own sources decide on the bits of a result."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

# Without these folders and modules, a result is drawn, told or kept otherwise, but not computed so.
NO_PART = frozenset(
    [
        *("analysis", "archive", "cli", "errata", "plot", "printed", "scenarios"),
        *("comparison", "freshness", "gallery", "reproduction", "scenario", "testing"),
        *("resuming", "typesetting", "verification"),
    ]
)


@cache
def sources_digest() -> str:
    """Return the SHA-256 of all sources that compute.

    Examples
    --------
    >>> len(sources_digest())
    64
    """
    digest = hashlib.sha256()
    package = Path(__file__).parent
    for path in sorted(package.rglob("*.py")):
        name = path.relative_to(package)
        if name.parts[0].removesuffix(".py") not in NO_PART:
            digest.update(f"{name.as_posix()}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()
