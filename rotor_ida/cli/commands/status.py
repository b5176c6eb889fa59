"""The command status."""

from __future__ import annotations

import rotor_ida
from rotor_ida.cli import options
from rotor_ida.cli.report import Report


def status(folder: options.Folder, /, *, as_json: options.AsJson = False) -> Report:
    """Say how far a study is: points done, failed and left, and how long these will take.

    Of the study that the example of shares began, even while it runs:

        rotor-ida status study
    """
    from rotor_ida.cli.tables import pairs  # noqa: PLC0415 - heavy, and not for --help

    found = rotor_ida.status(folder)
    reasons = found.pop("reasons")
    assert isinstance(reasons, list)
    rows = {**found, "time_left": _duration(found["seconds_left"])}
    rows |= {f"reason_{number}": reason for number, reason in enumerate(reasons, start=1)}
    del rows["seconds_left"]
    return Report(
        record={"folder": folder, **found, "reasons": reasons},
        parts=[pairs(f"Study {folder}", rows)],
        as_json=as_json,
    )


def _duration(seconds: object) -> str:
    """Return a time as hours, minutes and seconds.

    Examples
    --------
    >>> _duration(3725.2), _duration(float("nan"))
    ('1:02:05', '')
    """
    if not isinstance(seconds, float) or seconds != seconds:  # noqa: PLR0124 - NaN
        return ""
    whole = round(seconds)
    return f"{whole // 3600}:{whole // 60 % 60:02}:{whole % 60:02}"
