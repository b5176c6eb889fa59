"""Resume a study from the design in its folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from rotor_ida.basins.atlas.continue_attractors import continue_attractors
from rotor_ida.basins.basin import basin, basin_fractions
from rotor_ida.checks import COMPONENTS
from rotor_ida.cycles.continue_cycle import branch_from
from rotor_ida.cycles.guess import Guess
from rotor_ida.cycles.system_branch import branch_from as branch_of_system
from rotor_ida.cycles.system_branch import guess_in
from rotor_ida.cycles.system_guess import CycleProblem
from rotor_ida.errors import ArchiveError
from rotor_ida.model.parameters import ALL_PARAMETERS, OPTIONAL, PARAMETERS
from rotor_ida.model.rotor import Rotor
from rotor_ida.parallel import Progress
from rotor_ida.results.in_si import in_units_of_study
from rotor_ida.results.kinds import STUDIES, loaded
from rotor_ida.results.provenance import computing
from rotor_ida.results.studies import design_of, program_of
from rotor_ida.steady.drop_ensemble import drop_ensemble
from rotor_ida.steady.run_ups import run_ups
from rotor_ida.steady.sweep import sweep
from rotor_ida.steady.system_sweep import sweep_system
from rotor_ida.systems.archived import problem_in
from rotor_ida.systems.drop_design import case_from

# The design of a study, as in its folder; the arguments for its jobs; the function that resumes it.
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
    """Resume the study in a folder and complete it.

    Parameters
    ----------
    folder : path-like
        The folder that was given as `study` to `sweep`, `run_ups`, `basin`, `basin_fractions`,
        `continue_attractors`, `continue_cycle` or `drop_ensemble`.
    workers, executor, progress
        As for the function that began it; they do not affect the result. A branch is followed
        point by point, without workers.

    Returns
    -------
    Dataset
        The result of that function, equal bit for bit to that of an uninterrupted study. If the
        study is complete, nothing is computed again, and the versions of the program may differ
        from those that computed it, which the attribute ``computed_with`` gives. That of a machine
        is in SI units.

    Raises
    ------
    InputError
        If there is no study, or if it is incomplete and was begun with other versions.
    ArchiveError
        If another process is working on it, or its file is damaged or cannot be written.

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
    found = in_units_of_study(resumed(study=folder, progress=progress), folder)
    before = program_of(design)
    if before == program_of(computing()):
        return found
    said = ", ".join(f"{name} {value}" for name, value in sorted(before.items()))
    return found.assign_attrs(computed_with=said)


def resume_sweep(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes a sweep."""
    given = _given(design, "direction", *SOLVER, "flight") | _axes(design)
    given["along"] = design.get("along")
    return partial(sweep, **given, starts=_starts(design), **jobs)


def resume_system_sweep(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes a sweep of a rotor system."""
    system, around = problem_in(design["problem"])
    return partial(
        sweep_system, system, **around, **_given(design, "speed", "direction", "rtol"), **jobs
    )


def resume_run_ups(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes many run-ups."""
    given = _given(design, "to", "rate", "phase", *SOLVER) | _axes(design)
    return partial(run_ups, **given, starts=_starts(design), **jobs)


def resume_drops(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes many drops of a rotor system."""
    given = case_from(design) | design["varied"]
    return partial(drop_ensemble, **given, **_given(design, "drops", "seed"), **jobs)


def resume_basin(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes a basin."""
    return partial(basin, _rotor(design), **_given(design, *COMPONENTS, "rtol"), **jobs)


def resume_fractions(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes basin fractions."""
    given = _given(design, *COMPONENTS, "rtol", "starts", "seed")
    return partial(basin_fractions, _rotor(design), **given, **jobs)


def resume_atlas(design: Design, jobs: Jobs) -> Resumed:
    """Return the function that resumes an atlas; its starts may be given instead of drawn."""
    given = _given(design, "rtol", "starts", "shocks") | _axes(design)
    drawn = _given(design, *(name for name in (*COMPONENTS, "seed") if name in design))
    return partial(continue_attractors, **given, **drawn, **jobs)


def resume_branch(design: Design, _jobs: Jobs) -> Resumed:
    """Return the function that resumes a branch of limit cycles."""
    state = np.array(design["state"], dtype=np.float64)
    guess = Guess(_rotor(design), state, **_given(design, "period", "special", "slope"))
    given = _given(design, "parameter", "direction", "points")
    return partial(branch_from, guess=guess, limits=tuple(design["limits"]), **given)


def resume_system_branch(design: Design, _jobs: Jobs) -> Resumed:
    """Return the function that resumes a branch of limit cycles of a rotor system."""
    system, around = problem_in(design["problem"])
    problem, _ = CycleProblem.of(None, {"system": system, **around, "start": None}, None)
    guess = guess_in(problem, design, np.array(design["start"]))
    given = _given(design, "direction", "points")
    limits = tuple(design["limits"])
    return partial(branch_of_system, problem, guess, limits, **given)


def _given(design: Design, *names: str) -> dict[str, Any]:
    return {name: design[name] for name in names}


def _axes(design: Design) -> dict[str, Any]:
    """Return the parameters of the rotors of a study, as they were given."""
    return _given(design, *PARAMETERS, *(name for name in OPTIONAL if name in design))


def _rotor(design: Design) -> Rotor:
    return Rotor(**_given(design, *(name for name in ALL_PARAMETERS if name in design)))


def _starts(design: Design) -> list[tuple[float, ...]]:
    return [tuple(start) for start in design["starts"]]
