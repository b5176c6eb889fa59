"""The commands for files: show, compare and verify archives; continue studies."""

from __future__ import annotations

import math
import os
from dataclasses import asdict, replace
from datetime import timedelta
from typing import cast

import rotor_ida
from rotor_ida.checks import shown
from rotor_ida.cli import options
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.output import answer_whole, read, working
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError
from rotor_ida.results.sheets import facts
from rotor_ida.simulation.options import Method

# A longer remaining time [s] is shown as this one.
LONGEST_LEFT = 1e12
# What a comparison leaves out, with the titles of the reasons.
NOT_COMPARED = {
    "not_compared": "Not compared", "attributes_not_compared": "Attributes not compared",
}  # fmt: skip


@command("none", asks=(), file="FILE")
def show(case: Case) -> Report:
    """Show an archive: its kind, its origin and its first rows.

    The archive of the example of simulate, also as CSV files, then as a report:

        rotor-ida show run.nc --figure run.png --csv run.csv
        rotor-ida show run.nc --report report
    """
    (file,) = case.measured
    case.output.check()
    from rotor_ida.signals.files.columns import ENDINGS  # noqa: PLC0415 - heavy, likewise below

    measured = {ending for each in ENDINGS.values() for ending in each} | {".csv", ".txt", ".tsv"}
    if file.suffix.lower() in measured and os.path.isfile(file):
        raise InputError(
            f"file must be an archive, got {shown(file)}: rotor-ida plot draws measured files, and "
            "rotor-ida explore opens them"
        )
    from rotor_ida.cli.describe import origin  # noqa: PLC0415

    dataset = read(file)
    report = case.report(dataset)
    sizes = {str(dim): size for dim, size in dataset.sizes.items()}
    return replace(
        report,
        record={"file": str(file), **report.record, "dimensions": sizes},
        parts=[origin(dataset), *report.parts],
    )


@command("none", most=None, file="FILE")
def compare(case: Case) -> Report:
    """Compare an archived sweep with the exact whirls and limit cycles.

    The archive of the example of sweep:

        rotor-ida compare sweep.nc --out compared.nc
    """
    (file,), output = case.measured, case.output
    output.check()
    if output.figure is not None:
        raise InputError("figure must be left out: a comparison has none")
    if output.out is not None and os.path.realpath(output.out) == os.path.realpath(file):
        raise InputError(f"out must not be the file that is compared, got {shown(output.out)}")
    with working("comparison") as progress:
        found = rotor_ida.compare(read(file), **case.given, progress=progress)
    return case.report(found)


@command("none", asks=(), file="FILE", writes=False)
def verify(
    case: Case, *, method: Method | None = None, workers: int | None = None, as_json: bool = False
) -> Report:
    """Recompute an archived result and compare it with the archive.

    The archive of the example of simulate, by the same method and by another:

        rotor-ida verify run.nc
        rotor-ida verify run.nc --method taylor
    """
    (file,) = case.measured
    archived = read(file)
    from rotor_ida.verification.verify import differences, rerun  # noqa: PLC0415 - heavy

    with working("verify") as progress:
        again = rerun(archived, method=method, workers=workers, progress=progress)
    found = differences(again, archived)
    record = {"file": str(file), **found}
    told = {name: each for name, each in record.items()
            if name not in NOT_COMPARED and each not in ("", {})}  # fmt: skip
    parts = [facts("Computed again", told)]
    for name, title in NOT_COMPARED.items():
        reasons: dict[str, list[str]] = {}
        for each, why in cast(dict[str, str], found.get(name, {})).items():
            reasons.setdefault(why, []).append(each)
        if reasons:
            parts.append(facts(title, {why: ", ".join(each) for why, each in reasons.items()}))
    trouble = "" if found["agrees"] else f"{file} does not verify: {found['trouble']}"
    return Report(record=record, parts=parts, as_json=as_json, trouble=trouble)


@command("none", asks=(), file="FOLDER", writes=False)
def status(case: Case, *, as_json: bool = False) -> Report:
    """Show the progress of a study: points done, failed and left, and the time left.

    The study of the example of basin-fractions, even while it runs:

        rotor-ida status study
    """
    (folder,) = case.measured
    found = rotor_ida.status(folder)
    reasons, left = cast(list[str], found.pop("reasons")), cast(float, found["seconds_left"])
    rows = {name: entry for name, entry in found.items() if name != "seconds_left"}
    rounded = None if math.isnan(left) else round(min(left, LONGEST_LEFT))
    rows["time_left"] = "" if rounded is None else timedelta(seconds=rounded)
    rows |= {f"reason_{number}": reason for number, reason in enumerate(reasons, start=1)}
    record = {"folder": str(folder), **found, "reasons": reasons}
    return Report(record=record, parts=[facts(f"Study {folder}", rows)], as_json=as_json)


@command("none", asks=(), file="FOLDER")
def resume(case: Case, *, jobs: options.JobOptions = options.JobOptions()) -> Report:
    """Continue a study until it is complete, and write its result.

    The study of the example of basin-fractions:

        rotor-ida resume study
    """
    (folder,), output = case.measured, case.output
    output.check()
    with working("study", folder) as progress:
        dataset = rotor_ida.resume(folder, **asdict(jobs), progress=progress)
        return answer_whole(dataset, output, folder)
