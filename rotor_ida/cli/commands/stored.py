"""The commands for files: show, compare and verify archives; continue studies."""

from __future__ import annotations

import math
import os
from dataclasses import asdict, replace
from datetime import timedelta
from pathlib import Path
from typing import Annotated, cast

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import check_one_varies, shown
from rotor_ida.cli import options
from rotor_ida.cli.option_types import IN_SOLVER, path_option
from rotor_ida.cli.output import Output, answer, answer_whole, check_varies, read, working
from rotor_ida.cli.report import FIRST_ROWS, Report
from rotor_ida.errors import InputError
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.results.sheets import facts
from rotor_ida.simulation.options import Method

# A longer remaining time [s] is shown as this one.
LONGEST_LEFT = 1e12
Witness = Annotated[
    Method | None,
    Parameter(help="Solver of the new computation. Default: that of the archive."),
    IN_SOLVER,
]
File = Annotated[Path, path_option("Archive written by rotor-ida (.nc).", name="FILE")]
Folder = Annotated[Path, path_option("Folder of a study.", name="FOLDER")]


def show(
    file: File,
    /,
    *,
    figure: options.Figure = None,
    csv: options.Csv = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    """Show an archive: its kind, its origin and its first rows.

    The archive of the example of simulate, also as CSV files:

        rotor-ida show run.nc --figure run.png --csv run.csv
    """
    output = Output(figure=figure, csv=csv, as_json=as_json, force=force)
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
    file: File,
    /,
    *,
    out: options.Out = None,
    csv: options.Csv = None,
    as_json: options.AsJson = False,
    force: options.Force = False,
) -> Report:
    """Compare an archived sweep with the exact whirls and limit cycles.

    The archive of the example of sweep:

        rotor-ida compare sweep.nc --out compared.nc
    """
    output = Output(out=out, csv=csv, as_json=as_json, force=force)
    output.check()
    if out is not None and os.path.realpath(out) == os.path.realpath(file):
        raise InputError(f"out must not be the file that is compared, got {shown(out)}")
    with working("comparison") as progress:
        compared = rotor_ida.compare(read(file), progress=progress)
    return answer(compared, output)


def verify(
    file: File,
    /,
    *,
    method: Witness = None,
    workers: options.Workers = None,
    as_json: options.AsJson = False,
) -> Report:
    """Recompute an archived result and compare it with the archive.

    The archive of the example of simulate, by the same method and by another:

        rotor-ida verify run.nc
        rotor-ida verify run.nc --method taylor
    """
    archived = read(file)
    from rotor_ida.verification.verify import differences, rerun  # noqa: PLC0415 - heavy

    with working("verify") as progress:
        again = rerun(archived, method=method, workers=workers, progress=progress)
    found = differences(again, archived)
    record = {"file": str(file), **found}
    told = {name: value for name, value in record.items() if value not in ("", {})}
    others = {
        title: cast(dict[str, str], told.pop(name, {}))
        for name, title in (
            ("not_compared", "Not compared"),
            ("attributes_not_compared", "Attributes not compared"),
        )
    }
    parts = [facts("Computed again", told)]
    for title, left_out in others.items():
        reasons = dict.fromkeys(left_out.values())
        names = {why: ", ".join(each for each in left_out if left_out[each] == why)
                 for why in reasons}  # fmt: skip
        parts += [facts(title, names)] if names else []
    trouble = "" if found["agrees"] else f"{file} does not verify: {found['trouble']}"
    return Report(record=record, parts=parts, as_json=as_json, trouble=trouble)


def status(folder: Folder, /, *, as_json: options.AsJson = False) -> Report:
    """Show the progress of a study: points done, failed and left, and the time left.

    The study of the example of basin-fractions, even while it runs:

        rotor-ida status study
    """
    found = rotor_ida.status(folder)
    reasons = found.pop("reasons")
    assert isinstance(reasons, list)
    rows = {name: entry for name, entry in found.items() if name != "seconds_left"}
    left = found["seconds_left"]
    assert isinstance(left, float)
    rows["time_left"] = (
        "" if math.isnan(left) else timedelta(seconds=round(min(left, LONGEST_LEFT)))
    )
    rows |= {f"reason_{number}": reason for number, reason in enumerate(reasons, start=1)}
    return Report(
        record={"folder": str(folder), **found, "reasons": reasons},
        parts=[facts(f"Study {folder}", rows)],
        as_json=as_json,
    )


def resume(
    folder: Folder,
    /,
    *,
    jobs: options.JobOptions = options.JobOptions(),
    output: Output = Output(),
) -> Report:
    """Continue a study until it is complete, and write its result.

    The study of the example of basin-fractions:

        rotor-ida resume study
    """
    output.check(panels=1 if output.figure is None else _panels(folder))
    with working("study", folder) as progress:
        dataset = rotor_ida.resume(folder, **asdict(jobs), progress=progress)
        return answer_whole(dataset, output, folder)


def _panels(folder: Path) -> int:
    """Return the number of panels of the figure of a study; refuse a study without figure."""
    from rotor_ida.results.studies import design_of  # noqa: PLC0415 - heavy, and not for --help

    design = design_of(folder)
    if design.get("verb") == "basin_fractions":
        raise InputError("figure must be of a sweep or basin, got a study of basin fractions")
    axes = {name: each for name in ALL_PARAMETERS if isinstance(each := design.get(name), list)}
    if design.get("verb") == "bifurcation_diagram":
        check_one_varies([name for name, each in axes.items() if len(each) > 1])
        return 1
    over_speed = design.get("verb") not in {"run_ups", "continue_attractors"}
    points = math.prod(
        len(each) for name, each in axes.items() if not over_speed or name != "omega"
    )
    if design.get("verb") == "continue_attractors":
        check_varies(points)
        return 1
    return points
