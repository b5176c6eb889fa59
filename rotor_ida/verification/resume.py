"""Go on with a study, as its own folder says what it computes."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.basins import basin, basin_fractions
from rotor_ida.basins.atlas import continue_attractors
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.continue_cycle import branch_from
from rotor_ida.cycles.guess import Guess
from rotor_ida.errors import ArchiveError
from rotor_ida.model.parameters import ALL_PARAMETERS, OPTIONAL, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress
from rotor_ida.results.kinds import STUDIES, loaded
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies import design_of, program_of
from rotor_ida.steady.run_ups import run_ups
from rotor_ida.steady.sweep import sweep

# What a study computes, as its folder has it; what does the work; and what goes on with it.
Design = Mapping[str, Any]
Jobs = Mapping[str, Any]
Resumed = Callable[..., xr.Dataset]
SOLVER = ("rtol", "atol", "method")


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
    jobs: Jobs = {"workers": workers, "executor": executor}
    try:
        resumed: Resumed = loaded(STUDIES[design["kind"]].resumed)(design, jobs)
    except (KeyError, TypeError) as error:
        raise ArchiveError(f"study {str(folder)!r} has a damaged design: {error!r}") from error
    found = resumed(study=folder, progress=progress)
    before = program_of(design)
    if before == program_of(computing()):
        return found
    said = ", ".join(f"{name} {value}" for name, value in sorted(before.items()))
    return found.assign_attrs(computed_with=said)


def resume_sweep(design: Design, jobs: Jobs) -> Resumed:
    """Return what goes on with a sweep."""
    given = _given(design, "direction", *SOLVER, "flight") | _axes(design)
    return partial(sweep, **given, starts=_starts(design), **jobs)


def resume_run_ups(design: Design, jobs: Jobs) -> Resumed:
    """Return what goes on with many run-ups."""
    given = _given(design, "to", "rate", "phase", *SOLVER) | _axes(design)
    return partial(run_ups, **given, starts=_starts(design), **jobs)


def resume_basin(design: Design, jobs: Jobs) -> Resumed:
    """Return what goes on with a basin."""
    return partial(basin, _rotor(design), **_given(design, *COMPONENTS, "rtol"), **jobs)


def resume_fractions(design: Design, jobs: Jobs) -> Resumed:
    """Return what goes on with basin fractions."""
    given = _given(design, *COMPONENTS, "rtol", "starts", "seed")
    return partial(basin_fractions, _rotor(design), **given, **jobs)


def resume_atlas(design: Design, jobs: Jobs) -> Resumed:
    """Return what goes on with an atlas; its starts may have been given, and not drawn."""
    given = _given(design, "rtol", "starts", "shocks") | _axes(design)
    drawn = _given(design, *(name for name in (*COMPONENTS, "seed") if name in design))
    return partial(continue_attractors, **given, **drawn, **jobs)


def resume_branch(design: Design, _jobs: Jobs) -> Resumed:
    """Return what goes on with a branch of limit cycles."""
    state = np.array(design["state"], dtype=np.float64)
    guess = Guess(_rotor(design), state, **_given(design, "period", "special", "slope"))
    given = _given(design, "parameter", "direction", "points")
    return partial(branch_from, guess=guess, limits=tuple(design["limits"]), **given)


def _given(design: Design, *names: str) -> dict[str, Any]:
    return {name: design[name] for name in names}


def _axes(design: Design) -> dict[str, Any]:
    """Return the parameters of the rotors of a study as it was given them."""
    return _given(design, *PARAMETERS, *(name for name in OPTIONAL if name in design))


def _rotor(design: Design) -> Rotor:
    return Rotor(**_given(design, *(name for name in ALL_PARAMETERS if name in design)))


def _starts(design: Design) -> list[tuple[float, ...]]:
    return [tuple(start) for start in design["starts"]]
