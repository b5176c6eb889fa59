"""What decides on the bits of a result beside its parameters: versions and sources."""

from __future__ import annotations

from functools import cache

from rotor_ida.dataset.provenance import versions
from rotor_ida.sources import sources_digest

_INDIFFERENT = ("python_version", "xarray_version")


@cache
def computing() -> dict[str, str]:
    """Return versions of all that computes, and a digest of this package's own sources.

    Examples
    --------
    >>> sorted(computing())[:3]
    ['llvmlite_version', 'numba_version', 'numpy_version']
    """
    found = {name: str(each) for name, each in versions().items() if name not in _INDIFFERENT}
    return found | {"sources": sources_digest()}
