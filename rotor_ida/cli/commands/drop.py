"""The command drop: a levitated rotor falls on its touchdown bearings, once or many times."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rotor_ida
from rotor_ida.checks import shown
from rotor_ida.cli import options
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.output import FORCED, working
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from rotor_ida.cli.variables import Description
    from rotor_ida.model.rotor_system import RotorSystem

# What only one drop takes, what a system file gives by node, and what it may give.
NOT_OF_MANY = {"phase", "more_modes", "samples", "method"}
BY_NODE = ("start", "clearances", "capacities", "modes", "more_modes")
OF_FILE = ("speed", "duration", "phase", "drag")
# The study of many drops in the folder of their report, until all of it is written.
UNFINISHED = "unfinished"
# The archive of one drop beside that of many.
ONE = "drop.nc"


@command("a system", label="drop [%]", without=BY_NODE, of_file=OF_FILE)
def drop(
    case: Case, *, drops: int | None = None, film: Path | None = None,
    jobs: options.JobOptions = options.JobOptions(), study: Path | None = None,
) -> Report:  # fmt: skip
    r"""Drop a levitated rotor on its touchdown bearings, once or many times.

    The system file gives magnetic bearings as [[supports]], touchdown bearings as [[contacts]], and
    duration, inertia and what varies in [drop], at random or on a grid:

        rotor-ida drop rotor.toml --report report

    After an interruption the same command continues with the drops that are left:

        rotor-ida drop rotor.toml --report report --drops 1000

    Until then they are in report/unfinished, or in the folder of --study, which stays.
    """
    (rotor, _), system = case.from_file, case.file
    if rotor.units != "SI":
        raise InputError(f"system must be in SI units for a drop, got {shown(str(system))}")
    vary, folder = _asked(case, drops), case.output.report
    if study is not None and not vary:
        raise InputError("study must be left out without drops")
    unfinished = None if folder is None or not vary else folder / UNFINISHED
    if unfinished is not None and unfinished.is_dir():
        case.output = replace(case.output, continues=True)
    force = case.output.force or case.output.continues
    if film is not None:
        from rotor_ida.plot.drops import check_film  # noqa: PLC0415 - heavy, and not for --help

        check_film(film, overwrite=force, permission=FORCED)
    run, everything, before = case.ask(), None, ""
    if vary:
        kept = study or unfinished
        before = "" if kept is None else _saved_before(kept)
        everything = _many(rotor, case.given, vary, jobs, kept)
        if unfinished is not None:  # what is written from here on may be replaced
            unfinished.mkdir(parents=True, exist_ok=True)

    def told(_most: int | None) -> Description:
        """Return the figures of one drop and of many; their events are in the archive."""
        from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help
        from rotor_ida.cli.drop_tables import tables_of  # noqa: PLC0415
        from rotor_ida.steady.drop_words import sentence_of  # noqa: PLC0415

        record = describe(run, most=0)[0]
        if everything is not None:
            record |= {"drops": describe(everything, most=0)[0]}
        return record, [sentence_of(run, everything), *tables_of(run, everything)]

    report = case.report(
        run if everything is None else everything, told=told,
        figures=lambda: _figures(run, everything),
        beside={} if everything is None else {ONE: run},
    )  # fmt: skip
    more = [before] if before else []
    if film is not None:
        from rotor_ida.plot import save_orbit_film  # noqa: PLC0415 - heavy

        more.append(f"wrote {save_orbit_film(run, film, overwrite=force)}")
    if unfinished is not None and not report.trouble:
        shutil.rmtree(unfinished, ignore_errors=True)
    return replace(report, parts=[*report.parts, *more])


def _figures(run: xr.Dataset, drops: xr.Dataset | None) -> list[tuple[str, Figure]]:
    """Return the figures with their titles."""
    from rotor_ida.plot import plot_drops, plot_run, plot_run_up  # noqa: PLC0415 - heavy
    from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415

    with without_pyplot():
        found = [("One drop: radius, force and speeds", plot_run_up(run)),
                 ("One drop: orbits and forces", plot_run(run))]  # fmt: skip
        if drops is not None:
            words = (
                "Grid: ranges (shaded) and means (dots)"
                if "cell" in drops.sizes
                else "Distributions over many drops"
            )
            found.append((words, plot_drops(drops)))
    return found


def _asked(case: Case, drops: int | None) -> dict[str, Any]:
    """Let the file complete the arguments of one drop; return those that many have besides.

    There are none if there is one drop only. What varies is checked before anything is computed.
    """
    from rotor_ida.steady.drop_ensemble import design_of  # noqa: PLC0415 - heavy

    course = case.from_file[1]
    case.given = given = {**course.drop, **case.given}
    vary = dict(course.grid or course.vary)
    for name in ("speed", "duration"):
        if given.get(name) is None:
            raise InputError(f"{name} must be given with --{name} or in {case.file}")
    if course.grid and drops is not None:
        raise InputError(f"drops must be left out with the drop.grid of {case.file}")
    if course.grid:
        vary.setdefault("phase", [given.get("phase", 0.0)])
    elif drops is not None:
        vary["drops"] = drops
    if not (course.grid or "drops" in vary):
        return {}
    if "start" in given:
        raise InputError(
            f"start must be left out of {case.file} for many drops, which start levitated"
        )
    varied = {name: each for name, each in vary.items() if name not in {"drops", "seed"}}
    design_of(varied, vary.get("drops"), vary.get("seed", 0))
    return vary


def _saved_before(study: Path) -> str:
    """Return how many drops an interrupted command has left; empty if none."""
    try:
        found = rotor_ida.status(study)
    except InputError:
        return ""
    return f"continued: {found['done']} of {found['points']} drops were saved in {study}"


def _many(
    rotor: RotorSystem, given: dict[str, Any], vary: dict[str, Any], jobs: options.JobOptions,
    study: Path | None,
) -> xr.Dataset:  # fmt: skip
    """Return the ensemble of drops."""
    ways = {name: each for name, each in given.items() if name not in NOT_OF_MANY}
    with working("drops", study) as progress:
        return rotor_ida.drop_ensemble(
            rotor, **ways, **vary, **jobs.on_every_core(), study=study, progress=progress
        )
