"""Resume a study: ask the question in its folder again."""

from __future__ import annotations

import os

import xarray as xr

from rotor_ida.errors import ArchiveError
from rotor_ida.parallel import Progress, shows_progress
from rotor_ida.results.in_si import in_units_of_study
from rotor_ida.results.provenance import computing
from rotor_ida.results.question import Question
from rotor_ida.results.studies import design_of, program_of


@shows_progress
def resume(
    folder: str | os.PathLike[str],
    *,
    workers: int | None = None,
    executor: str = "auto",
    progress: Progress | bool | None = None,
) -> xr.Dataset:
    """Resume the study in a folder and complete it.

    Parameters
    ----------
    folder : path-like
        The folder that was given as `study` to a function.
    workers, executor, progress
        As for the function that began it; they do not affect the result. A branch or curve is
        followed point by point, without workers.

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
    try:
        question = Question.of_design(design)
    except (KeyError, TypeError, ValueError) as error:
        raise ArchiveError(f"study {str(folder)!r} has a damaged design: {error!r}") from error
    found = in_units_of_study(
        question.ask(study=folder, workers=workers, executor=executor, progress=progress), folder
    )
    before = program_of(design)
    if before == program_of(computing()):
        return found
    said = ", ".join(f"{name} {value}" for name, value in sorted(before.items()))
    return found.assign_attrs(computed_with=said)
