"""From a dataset to the answer of a command: write what is wanted, then say what there is."""

from __future__ import annotations

import xarray as xr

import rotor_ida
from rotor_ida.cli.describe import describe
from rotor_ida.cli.report import FAILED, Report
from rotor_ida.cli.targets import Targets
from rotor_ida.errors import RotorError

# What the result of a study is called in its folder.
RESULT = "result.nc"


def answer(
    dataset: xr.Dataset,
    targets: Targets,
    *,
    as_json: bool,
    most: int | None = None,
    trouble: str = "",
    status: int = FAILED,
) -> Report:
    """Return the report on a dataset that has been computed, and written where it is wanted.

    A file that cannot be written is the report's trouble, so that what was computed is printed
    even then.
    """
    written, failures = _write(dataset, targets)
    record, parts = describe(dataset, most=most)
    return Report(
        record=record,
        parts=[*parts, *written],
        as_json=as_json,
        trouble="; ".join(filter(None, [trouble, *failures])),
        status=status if trouble else FAILED,
    )


def _write(dataset: xr.Dataset, targets: Targets) -> tuple[list[str], list[str]]:
    """Return a line for each file that was written, and one for each that could not be."""
    written, failures = [], []
    own = targets.study / RESULT if targets.study is not None and targets.out is None else None
    out = targets.out or own
    if out is not None:
        try:
            # the result of a study is its own, and the same each time
            rotor_ida.save(dataset, out, overwrite=targets.force or out == own)
            written.append(f"wrote {out}")
        except (RotorError, OSError) as error:
            failures.append(str(error))
    if targets.figure is not None:
        from rotor_ida.cli.figures import draw  # noqa: PLC0415 - only who draws needs it

        try:
            files = draw(dataset, targets.figure, overwrite=targets.force)
            written += [f"wrote {file}" for file in files]
        except OSError as error:
            failures.append(f"cannot write {targets.figure}: {error.strerror or error}")
    return written, failures
