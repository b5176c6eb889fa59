"""Go on with a study, as its own folder says what it computes."""

from __future__ import annotations

import os
from typing import Any, cast

import xarray as xr

from rotor_ida.basins import basin, shares
from rotor_ida.checks import State
from rotor_ida.ensemble import Progress
from rotor_ida.errors import ArchiveError
from rotor_ida.parameters import Rotor
from rotor_ida.studies import design_of
from rotor_ida.sweeps import sweep


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
        The folder that was given as `study` to `sweep`, `basin` or `shares`.
    workers, executor, progress
        As for the function that began it; they leave no trace in the result.

    Returns
    -------
    Dataset
        What that function returns, to the same bits as if nothing had interrupted it. Where all
        is done already, nothing is computed again.

    Raises
    ------
    InputError
        If there is no study, or it was begun with other versions of what computes.
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
        return _RUN[design["kind"]](
            design, study=folder, workers=workers, executor=executor, progress=progress
        )
    except (KeyError, TypeError) as error:
        raise ArchiveError(f"study {str(folder)!r} has a damaged design: {error!r}") from error


def _sweep(design: dict[str, Any], **how: Any) -> xr.Dataset:
    names = ("omega", "zeta", "delta0", "direction", "rtol", "atol", "method", "flight")
    starts = [cast(State, tuple(start)) for start in design["starts"]]
    return sweep(**{name: design[name] for name in names}, starts=starts, **how)


def _basin(design: dict[str, Any], **how: Any) -> xr.Dataset:
    return basin(_rotor(design), **_starts(design), rtol=design["rtol"], **how)


def _shares(design: dict[str, Any], **how: Any) -> xr.Dataset:
    drawn = {name: design[name] for name in ("starts", "seed", "rtol")}
    return shares(_rotor(design), **_starts(design), **drawn, **how)


def _rotor(design: dict[str, Any]) -> Rotor:
    return Rotor(**{name: design[name] for name in ("omega", "zeta", "delta0")})


def _starts(design: dict[str, Any]) -> dict[str, Any]:
    return {name: design[name] for name in ("x", "y", "vx", "vy")}


_RUN = {"sweep": _sweep, "basin": _basin, "shares": _shares}
