"""The command verify."""

from __future__ import annotations

from rotor_ida.cli import options
from rotor_ida.cli.archives import read
from rotor_ida.cli.report import Report


def verify(
    file: options.File,
    /,
    *,
    as_json: options.AsJson = False,
) -> Report:
    """Run an archived simulation again, and hold its contact events against the archive.

    Of the run that the example of simulate wrote:

        rotor-ida verify run.nc
    """
    archived = read(file)
    from rotor_ida.cli.tables import pairs  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.verification import differences, rerun  # noqa: PLC0415

    again = rerun(archived)
    found = differences(again, archived)
    record = {"file": file, **found}
    trouble = "" if found["agrees"] else f"{file} does not verify: {found['trouble']}"
    return Report(
        record=record, parts=[pairs("Run again", record)], as_json=as_json, trouble=trouble
    )
