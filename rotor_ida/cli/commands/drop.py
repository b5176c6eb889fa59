"""The command drop: a levitated rotor falls on its touchdown bearings, and a report on it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rotor_ida
from rotor_ida.checks import shown
from rotor_ida.cli import options
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.output import FORCED, again, working
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from rotor_ida.cli.pages import Pages
    from rotor_ida.model.rotor_system import RotorSystem

# What only one drop takes, what a system file gives by node, and what it may give.
NOT_OF_MANY = {"phase", "more_modes", "samples", "method"}
BY_NODE = ("start", "clearances", "capacities", "modes", "more_modes")
OF_FILE = ("speed", "duration", "phase", "drag")
# The study of many drops in the folder of their report, until all of this is written.
UNFINISHED = "unfinished"
# The archives of a report, of one drop and of many.
ONE, MANY = "drop.nc", "drops.nc"


@command("a system", label="drop [%]", without=BY_NODE, of_file=OF_FILE, writes=False)
def drop(
    case: Case, *, out: Path, drops: int | None = None, film: Path | None = None,
    jobs: options.JobOptions = options.JobOptions(), study: Path | None = None,
    as_json: bool = False, force: bool = False,
) -> Report:  # fmt: skip
    r"""Drop a levitated rotor on its touchdown bearings, and write a report.

    The system file gives magnetic bearings as [[supports]], touchdown bearings as [[contacts]], and
    duration, inertia and what varies in [drop], at random or on a grid:

        rotor-ida drop rotor.toml --out report

    The folder gets the report as HTML and PDF, and the archives of the drops. After an interruption
    the same command continues with the drops that are left:

        rotor-ida drop rotor.toml --out report --drops 1000

    Until then they are in report/unfinished, or in the folder of --study, which stays.
    """
    from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.cli.pages import HTML, PDF  # noqa: PLC0415
    from rotor_ida.plot.drops import check_film  # noqa: PLC0415
    from rotor_ida.results.files import check_target  # noqa: PLC0415
    from rotor_ida.steady.drop_words import sentence_of  # noqa: PLC0415

    (rotor, _), system = case.from_file, case.file
    if rotor.units != "SI":
        raise InputError(f"system must be in SI units for a report, got {shown(str(system))}")
    told = {**case.given, "drops": drops}
    vary = _asked(case, drops)
    if study is not None and not vary:
        raise InputError("study must be left out without drops")
    unfinished = out / UNFINISHED
    overwrite = force or (bool(vary) and unfinished.is_dir())
    if film is not None:
        check_film(film, overwrite=overwrite, permission=FORCED)
    archives = [out / ONE, *[out / MANY] * bool(vary)]
    made = _make(out)
    try:
        for path in (*archives, out / HTML, out / PDF):
            check_target("out", path, overwrite=overwrite, permission=FORCED)
        run = case.ask()
    except BaseException:
        with suppress(OSError):  # another program may have put a file there
            for folder in made:
                folder.rmdir()
        raise
    everything, before = None, ""
    if vary:
        kept = study or unfinished
        before = _saved_before(kept)
        everything = _many(rotor, case.given, vary, jobs, kept)
        unfinished.mkdir(exist_ok=True)
        rotor_ida.save(everything, out / MANY, overwrite=overwrite)
    rotor_ida.save(run, out / ONE, overwrite=overwrite)
    pages = _pages(case, out, run, everything, told).write(out, overwrite=overwrite)
    written = [*archives, *pages]
    if film is not None:
        from rotor_ida.plot import save_orbit_film  # noqa: PLC0415 - heavy

        written.append(save_orbit_film(run, film, overwrite=overwrite))
    shutil.rmtree(unfinished, ignore_errors=True)
    record, parts = describe(run, most=0)
    parts = [sentence_of(run, everything), *parts[1:2]]  # the bearings; the rest is in the report
    if everything is not None:
        record |= {"drops": describe(everything, most=0)[0]}
    parts += [*filter(None, [before]), *(f"wrote {each}" for each in written)]
    return Report(record=record, parts=parts, as_json=as_json)


def _pages(
    case: Case, folder: Path, run: xr.Dataset, drops: xr.Dataset | None,
    options: Mapping[str, Any],
) -> Pages:  # fmt: skip
    """Return the report on drops, computed with options."""
    from rotor_ida.cli import drop_tables, pages  # noqa: PLC0415 - heavy
    from rotor_ida.results.question import Question  # noqa: PLC0415
    from rotor_ida.steady.drop_words import sentence_of  # noqa: PLC0415

    given = {name: value if isinstance(value, str | list) else repr(value)
             for name, value in options.items() if value is not None}  # fmt: skip
    asked = Question("drop", {"rotor": case.file, "out": folder, **given})
    assert case.file is not None
    return pages.pages_of(
        run, [sentence_of(run, drops), *drop_tables.tables_of(run, drops)],
        rotor=case.rotor, files=[case.file], figures=_figures(run, drops),
        commands=[again(asked.command()), Question("verify", {"rotor": folder / ONE}).command()],
    )  # fmt: skip


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


def _make(folder: Path) -> list[Path]:
    """Make the folder of the report, and return the new folders, the innermost first."""
    from rotor_ida.cli.pages import OF_FILES  # noqa: PLC0415 - heavy

    if folder.suffix in OF_FILES:
        raise InputError(f"out must be a folder, got the name of a file, {shown(str(folder))}")
    new = [each for each in (folder, *folder.parents) if not each.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"out must be a folder, got {shown(str(folder))}: {error.strerror}"
        ) from error
    return new


def _saved_before(study: Path) -> str:
    """Return how many drops an interrupted command has left; empty if none."""
    try:
        found = rotor_ida.status(study)
    except InputError:
        return ""
    return f"continued: {found['done']} of {found['points']} drops were saved in {study}"


def _many(
    rotor: RotorSystem, given: dict[str, Any], vary: dict[str, Any], jobs: options.JobOptions,
    study: Path,
) -> Any:  # fmt: skip
    """Return the ensemble of drops."""
    ways = {name: each for name, each in given.items() if name not in NOT_OF_MANY}
    with working("drops", study) as progress:
        return rotor_ida.drop_ensemble(
            rotor, **ways, **vary, **jobs.on_every_core(), study=study, progress=progress
        )
