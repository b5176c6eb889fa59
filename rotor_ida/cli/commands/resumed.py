"""The command resume."""

from __future__ import annotations

import math

import rotor_ida
from rotor_ida.cli import options, parsing
from rotor_ida.cli.progress import progress
from rotor_ida.cli.report import Report
from rotor_ida.cli.studied import studied
from rotor_ida.cli.targets import check_targets
from rotor_ida.errors import InputError
from rotor_ida.storage.studies import design_of


def resume(
    folder: options.Folder,
    /,
    *,
    workers: options.Workers = None,
    executor: options.Executor = "auto",
    out: options.Out = None,
    figure: options.Figure = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    """Go on with a study until it is done, and write its result.

    Of the study that the example of shares began:

        rotor-ida resume study
    """
    panels = 1 if figure is None else _panels(folder)
    targets = check_targets(out=out, study=folder, figure=figure, panels=panels, force=force)
    from rotor_ida.cli.endings import answered  # noqa: PLC0415 - heavy, and not for --help

    with studied(folder):
        with progress("study") as told:
            dataset = rotor_ida.resume(
                folder, workers=parsing.workers(workers), executor=executor, progress=told
            )
        return answered(dataset, targets, as_json=as_json)


def _panels(folder: str) -> int:
    """Return how many panels the figure of a study has; refuse a study that has none."""
    design = design_of(folder)
    if design.get("kind") == "basin_fractions":
        raise InputError("figure must be of a sweep or basin, got a study of shares")
    axes = (design.get(name) for name in ("zeta", "delta0"))
    return math.prod(len(axis) for axis in axes if isinstance(axis, list))
