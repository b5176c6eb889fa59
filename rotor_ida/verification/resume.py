"""Go on with a study, as its own folder says what it computes."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.basins import basin, basin_fractions
from rotor_ida.basins.atlas import continue_attractors
from rotor_ida.cycles.continue_cycle import branch_from
from rotor_ida.cycles.guess import Guess
from rotor_ida.errors import ArchiveError
from rotor_ida.model.parameters import Rotor
from rotor_ida.model.table import ALL_PARAMETERS, OPTIONAL, PARAMETERS
from rotor_ida.parallel import Progress
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies import design_of, program_of
from rotor_ida.steady.run_ups import run_ups
from rotor_ida.steady.sweep import sweep


def resume(
    folder: str | os.PathLike[str],
    *,
    workers: int | None = None,
    executor: str = "auto",
    progress: Progress | None = None,
) -> xr.Dataset:
    """Go on with the study in a folder until it is done.

    Parameters
    ----------
    folder : path-like
        The folder that was given as `study` to `sweep`, `run_ups`, `basin`, `basin_fractions`,
        `continue_attractors` or `continue_cycle`.
    workers, executor, progress
        As for the function that began it; they leave no trace in the result. A branch is followed
        point by point, and needs no workers.

    Returns
    -------
    Dataset
        What that function returns, to the same bits as if nothing had interrupted it. Where all
        is done already, nothing is computed again; then the program may be another than the one
        that did it, of which the attribute ``computed_with`` tells the versions.

    Raises
    ------
    InputError
        If there is no study, or it is not done and was begun with other versions of what computes.
    ArchiveError
        If another process is at work on it, or its file is damaged or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> from rotor_ida import sweep
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     begun = sweep(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, study=folder)
    ...     resume(folder).identical(begun)
    True
    """
    design = design_of(folder)
    try:
        function, given = _call(design)
    except (KeyError, TypeError) as error:
        raise ArchiveError(f"study {str(folder)!r} has a damaged design: {error!r}") from error
    if design["kind"] != "branch":
        given |= {"workers": workers, "executor": executor}
    found = function(**given, study=folder, progress=progress)
    before = program_of(design)
    if before == program_of(computing()):
        return found
    said = ", ".join(f"{name} {value}" for name, value in sorted(before.items()))
    return found.assign_attrs(computed_with=said)


def _call(design: dict[str, Any]) -> tuple[Callable[..., xr.Dataset], dict[str, Any]]:
    """Return the function that a design is of, and what it was given."""
    kind = design["kind"]
    functions: dict[str, Callable[..., xr.Dataset]]
    functions = {
        "sweep": sweep, "run_ups": run_ups, "basin": basin, "basin_fractions": basin_fractions,
        "branch": branch_from,
    }  # fmt: skip
    given = {name: design[name] for name in _GIVEN[kind]}
    beyond = {name: design[name] for name in OPTIONAL if name in design}
    if kind in {"sweep", "run_ups"}:
        starts = [tuple(start) for start in design["starts"]]
        return functions[kind], {**given, **beyond, "starts": starts}
    if kind == "continue_attractors":
        drawn = {name: design[name] for name in _DRAWN if name in design}
        return continue_attractors, {**given, **beyond, **drawn}
    rotor = Rotor(**{name: design[name] for name in ALL_PARAMETERS if name in design})
    if kind == "branch":
        guess = {name: design[name] for name in ("period", "special", "slope")}
        given["guess"] = Guess(rotor, np.array(design["state"], dtype=np.float64), **guess)
        given["limits"] = tuple(given["limits"])
        return branch_from, given
    return functions[kind], {**given, "rotor": rotor}


_GIVEN = {
    "sweep": ("omega", "zeta", "delta0", "direction", "rtol", "atol", "method", "flight"),
    "run_ups": (*PARAMETERS, "to", "rate", "phase", "rtol", "atol", "method"),
    "basin": ("x", "y", "vx", "vy", "rtol"),
    "basin_fractions": ("x", "y", "vx", "vy", "rtol", "starts", "seed"),
    "branch": ("parameter", "limits", "direction", "points"),
    "continue_attractors": (*PARAMETERS, "rtol", "starts", "shocks"),
}
# What starts are drawn from; none of it where they were given.
_DRAWN = ("x", "y", "vx", "vy", "seed")
