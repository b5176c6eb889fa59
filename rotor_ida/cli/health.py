"""Whether this installation works: its versions, and small runs with a known outcome."""

from __future__ import annotations

import importlib
import platform
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, cast

import rotor_ida

PACKAGES = (
    *("rotor-ida", "scikit-sundae", "numpy", "scipy", "numba"),
    *("xarray", "netCDF4", "matplotlib", "distributed"),
)
# Released at rest at this distance from the axis, outside a ring of this clearance.
RELEASE, CLEARANCE = 2.0, 0.5
LARGEST_ERROR = 1e-8
OK, FAILED, ABSENT = "ok", "failed", "absent"


@dataclass(frozen=True, slots=True)
class Check:
    """One check: its name, its result (ok, failed or absent), and what was seen."""

    name: str
    result: str
    seen: str

    def record(self) -> dict[str, object]:
        """Return it as a row of a table."""
        return {"check": self.name, "result": self.result, "seen": self.seen}


def versions() -> dict[str, object]:
    """Return the version of every part that computes, writes or draws; None where missing."""
    found: dict[str, object] = {"python": platform.python_version()}
    found |= {name: _version(name) for name in PACKAGES}
    try:
        solver = importlib.import_module("rotor_ida.provenance").versions()
    except ImportError:
        solver = {}
    return found | {"SUNDIALS": solver.get("sundials_version")}


def backends() -> list[str]:
    """Return the ways to call the solver that this version knows."""
    known = importlib.import_module("rotor_ida.simulation.options").BACKENDS
    return [name for name in known if name != "auto"]


def executors() -> list[str]:
    """Return what can do the work of a sweep or a basin here."""
    choice = importlib.import_module("rotor_ida.parallel.executors")
    return [name for name in choice.EXECUTORS if name != "auto" and not choice.why_not(name)]


def check_backend(backend: str) -> list[Check]:
    """Compare a free vibration across the clearance with its exact event times.

    Released at rest at A, the rotor leaves the ring after a quarter of the planar period of
    amplitude ``A - delta0`` without clearance, and crosses ``2 delta0`` at constant speed. A
    backend that cannot be had here is absent, with the reason; the others do its work.
    """
    reason = _why_not(backend)
    if reason:
        return [Check(f"{backend}: free vibration", ABSENT, reason)]
    return [
        _check(
            f"{backend}: free vibration, flight {flight}",
            partial(_vibration, backend, flight),
        )
        for flight in ("exact", "cvode")
    ]


def check_archive() -> Check:
    """Write a small archive and read it back."""
    return _check("archive: written and read back", _archive)


def _why_not(backend: str) -> str:
    if backend != "compiled":
        return ""
    try:
        return str(importlib.import_module("rotor_ida.simulation.cvode.libraries").why_not())
    except ImportError as error:
        return f"ImportError: {error}"


def _vibration(backend: str, flight: str) -> str:
    closed_forms = importlib.import_module("rotor_ida.closed_forms")
    depth = RELEASE - CLEARANCE
    leaving = closed_forms.planar_period(depth) / 4.0
    crossing = 2.0 * CLEARANCE / closed_forms.centre_speed(depth)
    run = rotor_ida.simulate(
        rotor_ida.Rotor(omega=0.0, zeta=0.0, delta0=CLEARANCE),
        start=(RELEASE, 0.0, 0.0, 0.0),
        duration=leaving + crossing + 1.0,
        samples=2,
        flight=cast(Any, flight),
        backend=cast(Any, backend),
    )
    times = run["event_time"].values.tolist()
    if len(times) != 2:
        raise ArithmeticError(f"expected an exit and an entry, got {len(times)} events")
    error = max(abs(times[0] - leaving), abs(times[1] - leaving - crossing))
    if not error < LARGEST_ERROR:
        raise ArithmeticError(f"event times are wrong by {error:.1e}")
    return f"event times right to {error:.1e}"


def _archive() -> str:
    whirls = rotor_ida.synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    with tempfile.TemporaryDirectory() as folder:
        again = rotor_ida.load(rotor_ida.save(whirls, Path(folder) / "whirls.nc"))
    if not again["amplitude"].identical(whirls["amplitude"]):
        raise ArithmeticError("what was read is not what was written")
    return "equal"


def _check(name: str, attempt: Callable[[], str]) -> Check:
    try:
        return Check(name, OK, attempt())
    except Exception as error:  # whatever is broken here is the answer
        return Check(name, FAILED, " ".join(f"{type(error).__name__}: {error}".split()))


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
