"""Provenance of a result: the attributes by which a reader can judge and repeat it."""

from __future__ import annotations

import hashlib
import platform
import re
import shlex
import sys
from collections.abc import Mapping
from functools import cache, lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path, PurePath

from rotor_ida.core import sundials
from rotor_ida.core.library import build_info, why_missing

SOURCE = "rotor_ida: rotor with contact and clearance"

# The folder part of an absolute path, also after --option=; it means nothing on another machine.
_FOLDERS = re.compile(r"^(--?[\w-]+=)?(?:[/~]|[A-Za-z]:[\\/]).*[\\/](?=[^\\/])")
# Versions that do not change the bits of a result.
_INDIFFERENT = ("python_version", "xarray_version")
# Names of source files.
KINDS_OF_SOURCE = ("*.py", "*.c", "*.h")
# Folders and modules that draw, describe or store a result but do not compute it.
NOT_COMPUTING = (
    *("cli", "explorer", "paper", "plot", "results/archive"),
    *("scenarios", "signals", "testing", "verification"),
)


def provenance(how: Mapping[str, object]) -> dict[str, object]:
    """Return the attributes on how a result was computed: source, command, method, versions.

    Examples
    --------
    >>> sorted(provenance({"rtol": 1e-10}))[:4]
    ['command', 'core_compiler', 'core_flags', 'core_level']
    """
    return {"source": SOURCE, "command": command(), **how, **core(), **versions()}


@cache
def core() -> dict[str, str]:
    """Return the core's compiler, flags, processor level and a digest of its sources.

    Only the digest affects the bits of a result. Without a core there is none of these.
    """
    if why_missing():
        return {}
    said = build_info()
    told = {f"core_{name}": said[name] for name in ("compiler", "flags", "level")}
    return told | {"core_sources": said["sources"][:16]}


@cache
def versions() -> dict[str, object]:
    """Return the versions of all packages that compute, as attributes.

    That of scikit-sundae is empty where it is not installed.
    """
    names = {"rotor_ida": "rotor-ida"} | {name: name for name in ("numpy", "scipy", "xarray")}
    found: dict[str, object] = {f"{name}_version": version(names[name]) for name in names}
    try:
        found["scikit_sundae_version"] = version("scikit-sundae")
    except PackageNotFoundError:
        found["scikit_sundae_version"] = ""
    found["sundials_version"] = sundials.version()
    found["python_version"] = platform.python_version()
    return found


@cache
def computing() -> dict[str, str]:
    """Return what determines the bits of a result besides its parameters: versions and sources.

    Examples
    --------
    >>> sorted(computing())[:3]
    ['numpy_version', 'rotor_ida_version', 'scikit_sundae_version']
    """
    found = {name: str(each) for name, each in versions().items() if name not in _INDIFFERENT}
    return found | {"sources": sources_digest()}


@cache
def sources_digest() -> str:
    """Return the SHA-256 of all sources of this package that compute, in Python and in C.

    Examples
    --------
    >>> len(sources_digest())
    64
    """
    digest = hashlib.sha256()
    for name, path in computing_sources().items():
        digest.update(f"{name}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def computing_sources() -> dict[str, Path]:
    """Return all sources of this package that compute, by their names within it.

    Examples
    --------
    >>> {"core/events.c", "simulation/run.py", "schema/flags.py"} <= computing_sources().keys()
    True
    >>> [name for name in computing_sources() if name.startswith(("cli", "plot"))]
    []
    """
    package = Path(__file__).parents[1]
    found = sorted(path for kind in KINDS_OF_SOURCE for path in package.rglob(kind))
    names = {path.relative_to(package): path for path in found}
    return {
        name.as_posix(): path
        for name, path in names.items()
        if not any(name.with_suffix("").is_relative_to(part) for part in NOT_COMPUTING)
    }


def command() -> str:
    """Return the running script or program, in the form of `described`."""
    spec = getattr(sys.modules.get("__main__"), "__spec__", None)
    return described(tuple(sys.argv), module=spec.name if spec else "")


@lru_cache(maxsize=8)
def described(arguments: tuple[str, ...], *, module: str = "") -> str:
    """Return a command line, as in ``sys.argv``, without details of this machine.

    It is in the form for a shell, or in words if it cannot be typed again. `module` is the one
    that ``python -m`` runs, if any.

    Examples
    --------
    >>> described(("/home/me/bin/rotor-ida", "simulate", "--omega", "2", "--out=/tmp/run.nc"))
    'rotor-ida simulate --omega 2 --out=run.nc'
    >>> described(("/usr/lib/study/__main__.py", "--quick"), module="study.__main__")
    'python -m study --quick'
    >>> described(("",)), described(("/lib/ipykernel_launcher.py", "-f", "kernel.json"))
    ('interactive Python', 'a notebook')
    """
    program, *rest = arguments or [""]
    name = PurePath(program).name
    if "ipykernel" in name or module.startswith("ipykernel"):
        return "a notebook"
    if not name:
        return "interactive Python"
    if name in {"-", "-c"}:
        return f"python {name}"
    started = ["python", "-m", module.removesuffix(".__main__")] if module else [name]
    shown = shlex.join([*started, *(_FOLDERS.sub(r"\1", word) for word in rest)])
    # Arguments may be bytes that are not text, which an attribute cannot store.
    return shown.encode("utf-8", "backslashreplace").decode().replace("\n", " ")
