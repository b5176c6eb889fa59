"""The command doctor: the versions of an installation, and small runs with a known outcome."""

from __future__ import annotations

import platform
import tempfile
from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import get_args

import rotor_ida
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.report import Report
from rotor_ida.core import sundials
from rotor_ida.results.sheets import Parts, facts, table
from rotor_ida.simulation.options import Backend, Flight, Method

PACKAGES = (
    *("rotor-ida", "scikit-sundae", "numpy", "scipy"),
    *("xarray", "netCDF4", "matplotlib", "distributed"),
)
# Distance from the axis at release, and the clearance, which is smaller.
RELEASE, CLEARANCE = 2.0, 0.5
LARGEST_ERROR = 1e-8

Check = dict[str, str]


@command("none", asks=(), writes=False)
def doctor(_case: Case, *, as_json: bool = False) -> Report:
    """Check the installation: versions, solvers and backends.

    To attach to a question:

        rotor-ida doctor --json
    """
    from rotor_ida.parallel.executors import EXECUTORS, why_not  # noqa: PLC0415 - not for --help

    backends = [name for name in get_args(Backend) if name != "auto"]
    by_backend = {name: _check_backend(name) for name in backends}
    core, check_of_core = _core()
    checks = [check_of_core, *(check for found in by_backend.values() for check in found)]
    checks.append(_attempt("archive: written and read back", _archive))
    usable = [name for name, found in by_backend.items()
              if all(check["result"] == "ok" for check in found)]  # fmt: skip
    executors = [name for name in EXECUTORS if name != "auto" and not why_not(name)]
    versions = _versions()
    failed = sum(check["result"] == "failed" for check in checks)
    record = {"versions": versions, "backends": usable, "executors": executors, "core": core,
              "checks": checks}  # fmt: skip
    parts: Parts = [
        facts("Versions", versions), *([facts("Core", core)] if core else []),
        f"Usable backends: {', '.join(usable) or 'none'}",
        f"Usable executors: {', '.join(executors)}", table("Checks", checks, list(checks[0])),
    ]  # fmt: skip
    trouble = f"{failed} of {len(checks)} checks failed" if failed else ""
    return Report(record=record, parts=parts, as_json=as_json, trouble=trouble)


def _versions() -> dict[str, object]:
    """Return the version of every part that computes, writes or draws; None where missing."""
    found: dict[str, object] = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = None
    return found | {"SUNDIALS": sundials.version()}


def _core() -> tuple[dict[str, object], Check]:
    """Return the properties of the core, and whether it can be used."""
    from rotor_ida.core.library import build_info  # noqa: PLC0415 - what is broken is said

    check = _attempt("core: loaded", lambda: f"level {build_info()['level']}")
    return dict(build_info()) if check["result"] == "ok" else {}, check


def _check_backend(backend: Backend) -> list[Check]:
    """Compare a free vibration across the clearance with its exact event times.

    Released at rest at A, the rotor leaves the stator after a quarter of the planar period of
    amplitude ``A - delta0`` without clearance, and crosses ``2 delta0`` at constant speed. An
    unavailable backend is listed as absent, with the reason; the others replace it. Taylor
    series need no solver.
    """
    free = f"{backend}: free vibration"
    compiled = backend == "compiled"
    reason = sundials.why_not()
    if not compiled and not reason.endswith("is not installed"):  # it needs the package alone
        reason = ""
    checks = [{"check": free, "result": "absent", "seen": reason}] if reason else [
        _attempt(f"{free}, flight {flight}", partial(_vibration, backend, flight, "adams"))
        for flight in get_args(Flight)
    ]  # fmt: skip
    if compiled:
        series = partial(_vibration, backend, "exact", "taylor")
        checks.append(_attempt(f"{free}, Taylor series", series))
    return checks


def _vibration(backend: Backend, flight: Flight, method: Method) -> str:
    from rotor_ida import closed_forms  # noqa: PLC0415 - heavy, and not for --help

    depth = RELEASE - CLEARANCE
    leaving = closed_forms.planar_period(depth) / 4.0
    crossing = 2.0 * CLEARANCE / closed_forms.centre_speed(depth)
    run = rotor_ida.simulate(
        rotor_ida.Rotor(omega=0.0, zeta=0.0, delta0=CLEARANCE), start=(RELEASE, 0.0, 0.0, 0.0),
        duration=leaving + crossing + 1.0, samples=2, method=method, flight=flight,
        backend=backend,
    )  # fmt: skip
    times = run["event_time"].values.tolist()
    if len(times) != 2:
        raise ArithmeticError(f"expected an exit and an entry, got {len(times)} events")
    error = max(abs(times[0] - leaving), abs(times[1] - leaving - crossing))
    if not error < LARGEST_ERROR:
        raise ArithmeticError(f"event times are wrong by {error:.1e}")
    return f"event times right to {error:.1e}"


def _archive() -> str:
    """Write a small archive and read it back."""
    whirls = rotor_ida.synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    with tempfile.TemporaryDirectory() as folder:
        again = rotor_ida.load(rotor_ida.save(whirls, Path(folder) / "whirls.nc"))
    if not again["amplitude"].identical(whirls["amplitude"]):
        raise ArithmeticError("what was read is not what was written")
    return "equal"


def _attempt(name: str, attempt: Callable[[], str]) -> Check:
    try:
        result, seen = "ok", attempt()
    except Exception as error:  # any error here is the result
        result, seen = "failed", " ".join(f"{type(error).__name__}: {error}".split())
    return {"check": name, "result": result, "seen": seen}
