"""Where a result came from: the attributes that let a reader judge and repeat it."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import version

from sksundae import SUNDIALS_VERSION

from rotor_ida.invocation import command
from rotor_ida.schema import CONVENTIONS
from rotor_ida.simulator.options import Options

SOURCE = "rotor_ida: rotor with Hertz contact and clearance, simulated event by event"


def provenance(title: str, options: Options) -> dict[str, object]:
    """Return the global attributes of a simulated result: method, versions, command."""
    return {
        "Conventions": CONVENTIONS,
        "title": title,
        "source": SOURCE,
        "command": command(),
        "method": options.method,
        "flight": options.flight,
        "backend": options.backend,
        "rtol": options.rtol,
        "atol": options.atol,
        **versions(),
    }


@cache
def versions() -> dict[str, object]:
    """Return the versions of all that computes, as attributes."""
    names = {"rotor_ida": "rotor-ida", "scikit_sundae": "scikit-sundae"}
    names |= {name: name for name in ("numpy", "scipy", "numba", "llvmlite", "xarray")}
    found: dict[str, object] = {f"{name}_version": version(names[name]) for name in names}
    found["sundials_version"] = str(SUNDIALS_VERSION)
    found["python_version"] = platform.python_version()
    return found
