"""The command show."""

from __future__ import annotations

from dataclasses import replace

from rotor_ida.cli import options
from rotor_ida.cli.archives import read
from rotor_ida.cli.report import Report
from rotor_ida.cli.targets import check_targets

FIRST_ROWS = 10


def show(
    file: options.File,
    /,
    *,
    figure: options.Figure = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    """Say what an archive holds: its kind, where it came from, its first rows.

    Of the run that the example of simulate wrote:

        rotor-ida show run.nc --figure run.png
    """
    targets = check_targets(figure=figure, force=force)
    from rotor_ida.cli.answer import answer  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.cli.describe import origin  # noqa: PLC0415

    dataset = read(file)
    report = answer(dataset, targets, as_json=as_json, most=FIRST_ROWS)
    sizes = {str(dim): size for dim, size in dataset.sizes.items()}
    return replace(
        report,
        record={"file": file, **report.record, "dimensions": sizes},
        parts=[origin(dataset), *report.parts],
    )
