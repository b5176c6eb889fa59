"""The commands show, compare and verify: what an archive holds, and whether it holds."""

from __future__ import annotations

import os
from dataclasses import replace

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.output import Output, answer, read, working
from rotor_ida.cli.report import Report, pairs
from rotor_ida.errors import InputError

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
    output = Output(figure=figure, as_json=as_json, force=force)
    output.check()
    from rotor_ida.cli.describe import origin  # noqa: PLC0415 - heavy, and not for --help

    dataset = read(file)
    report = answer(dataset, output, most=FIRST_ROWS)
    sizes = {str(dim): size for dim, size in dataset.sizes.items()}
    return replace(
        report,
        record={"file": str(file), **report.record, "dimensions": sizes},
        parts=[origin(dataset), *report.parts],
    )


def compare(
    file: options.File,
    /,
    *,
    out: options.Out = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    """Hold an archived sweep against the exact synchronous whirls.

    Of the sweep that the example of sweep wrote:

        rotor-ida compare sweep.nc --out compared.nc
    """
    output = Output(out=out, as_json=as_json, force=force)
    output.check()
    if out is not None and os.path.realpath(out) == os.path.realpath(file):
        raise InputError(f"out must not be the file that is compared, got {str(out)!r}")
    return answer(rotor_ida.compare(read(file)), output)


def verify(
    file: options.File,
    /,
    *,
    workers: options.Workers = None,
    as_json: options.AsJson = False,
) -> Report:
    """Compute an archived run, sweep or basin again, and hold it against the archive.

    Of the run that the example of simulate wrote:

        rotor-ida verify run.nc
    """
    archived = read(file)
    from rotor_ida.analysis.verification import differences, rerun  # noqa: PLC0415 - heavy

    with working("verify") as progress:
        again = rerun(archived, workers=workers, progress=progress)
    found = differences(again, archived)
    record = {"file": str(file), **found}
    shown = {name: value for name, value in record.items() if value != ""}
    trouble = "" if found["agrees"] else f"{file} does not verify: {found['trouble']}"
    return Report(
        record=record, parts=[pairs("Computed again", shown)], as_json=as_json, trouble=trouble
    )
