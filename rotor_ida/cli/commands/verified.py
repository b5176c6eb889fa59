"""The command verify."""

from __future__ import annotations

from rotor_ida.cli import options, parsing
from rotor_ida.cli.archives import read
from rotor_ida.cli.progress import progress
from rotor_ida.cli.report import Report


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
    from rotor_ida.analysis.verification import differences, rerun  # noqa: PLC0415
    from rotor_ida.cli.tables import pairs  # noqa: PLC0415 - heavy, and not for --help

    with progress("verify") as told:
        again = rerun(archived, workers=parsing.workers(workers), progress=told)
    found = differences(again, archived)
    record = {"file": file, **found}
    shown = {name: value for name, value in record.items() if value != ""}
    trouble = "" if found["agrees"] else f"{file} does not verify: {found['trouble']}"
    return Report(
        record=record, parts=[pairs("Computed again", shown)], as_json=as_json, trouble=trouble
    )
