"""The command doctor."""

from __future__ import annotations

from rotor_ida.cli import options
from rotor_ida.cli.report import Report


def doctor(*, as_json: options.AsJson = False) -> Report:
    """Say which solver, backends and versions are in use, and check that they work.

    To send along with a question:

        rotor-ida doctor --json
    """
    from rotor_ida.cli import health  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.cli.tables import pairs, table  # noqa: PLC0415

    by_backend = {name: health.check_backend(name) for name in health.backends()}
    checks = [*(check for checks in by_backend.values() for check in checks)]
    checks.append(health.check_archive())
    usable = [
        name
        for name, found in by_backend.items()
        if all(check.result == health.OK for check in found)
    ]
    versions, rows = health.versions(), [check.record() for check in checks]
    failed = sum(check.result == health.FAILED for check in checks)
    return Report(
        record={
            "versions": versions,
            "backends": usable,
            "executors": health.executors(),
            "checks": rows,
        },
        parts=[
            pairs("Versions", versions),
            f"Backends that can be used: {', '.join(usable) or 'none'}",
            f"Executors that can be used: {', '.join(health.executors())}",
            table("Checks", rows, list(rows[0])),
        ],
        as_json=as_json,
        trouble=f"{failed} of {len(checks)} checks failed" if failed else "",
    )
