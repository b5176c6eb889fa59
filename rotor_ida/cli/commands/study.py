"""The commands status and resume: how far a study is, and going on with it."""

from __future__ import annotations

import math
from pathlib import Path

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer_whole, working
from rotor_ida.cli.report import Report, pairs
from rotor_ida.errors import InputError


def status(folder: options.Folder, /, *, as_json: options.AsJson = False) -> Report:
    """Say how far a study is: points done, failed and left, and how long these will take.

    Of the study that the example of fractions began, even while it runs:

        rotor-ida status study
    """
    found = rotor_ida.status(folder)
    reasons = found.pop("reasons")
    assert isinstance(reasons, list)
    rows = {**found, "time_left": _duration(found["seconds_left"])}
    rows |= {f"reason_{number}": reason for number, reason in enumerate(reasons, start=1)}
    del rows["seconds_left"]
    return Report(
        record={"folder": str(folder), **found, "reasons": reasons},
        parts=[pairs(f"Study {folder}", rows)],
        as_json=as_json,
    )


def resume(
    folder: options.Folder,
    /,
    *,
    jobs: options.JobOptions = options.JobOptions(),
    output: Output = Output(),
) -> Report:
    """Go on with a study until it is done, and write its result.

    Of the study that the example of fractions began:

        rotor-ida resume study
    """
    output.check(panels=1 if output.figure is None else _panels(folder))
    with working("study", folder) as progress:
        dataset = rotor_ida.resume(
            folder, workers=jobs.workers, executor=jobs.executor, progress=progress
        )
        return answer_whole(dataset, output, folder)


def _duration(seconds: object) -> str:
    """Return a time as hours, minutes and seconds.

    Examples
    --------
    >>> _duration(3725.2), _duration(float("nan"))
    ('1:02:05', '')
    """
    if not isinstance(seconds, float) or math.isnan(seconds):
        return ""
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"


def _panels(folder: Path) -> int:
    """Return how many panels the figure of a study has; refuse a study that has none."""
    from rotor_ida.storage.studies import design_of  # noqa: PLC0415 - heavy, and not for --help

    design = design_of(folder)
    if design.get("kind") == "basin_fractions":
        raise InputError("figure must be of a sweep or basin, got a study of basin fractions")
    axes = (design.get(name) for name in ("zeta", "delta0"))
    return math.prod(len(axis) for axis in axes if isinstance(axis, list))
