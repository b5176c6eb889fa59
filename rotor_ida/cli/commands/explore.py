"""The command explore: an interactive page in the browser."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from rotor_ida.checks import COMPONENTS, State, shown
from rotor_ida.cli import options
from rotor_ida.cli.machines import begun
from rotor_ida.cli.option_types import (
    IN_OUTPUT,
    count_option,
    flag_option,
    numbers_option,
    path_option,
)
from rotor_ida.cli.output import FORCED, read, working
from rotor_ida.cli.rotor_options import RotorOptions
from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import MOST_REVOLUTIONS, largest_speed
from rotor_ida.explorer.system_questions import ENDINGS, SYSTEM_RUNS
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.simulation.options import check_can_be_followed
from rotor_ida.texts import printable

# Packages that serve the page, not required otherwise.
NEEDED = ("starlette", "uvicorn", "websockets")
FIRST = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REVOLUTIONS = 60
PAGE = ".html"
FileToExplore = Annotated[
    Path | None, path_option("Archived run shown first, or a rotor system as TOML or .nc.")
]
Port = Annotated[int, count_option("Port on this computer; 0 picks a free one.", 0, 65_535)]
NoBrowser = Annotated[bool, flag_option("Print the address without opening a browser.")]
Export = Annotated[
    Path | None,
    path_option("Write a page that needs no server, for the speeds of --speeds, and stop."),
    IN_OUTPUT,
]
ExportedSpeeds = Annotated[
    list[float] | None, numbers_option("Speeds of the exported page: numbers, or START:STOP:COUNT.")
]


def explore(
    file: FileToExplore = None,
    *,
    rotor: RotorOptions = RotorOptions(),
    start: options.StartOrNone = None,
    port: Port = 8765,
    no_browser: NoBrowser = False,
    export: Export = None,
    speeds: ExportedSpeeds = None,
    force: options.Force = False,
) -> int:
    r"""Open an interactive page in the browser, with sliders for the parameters.

    The page is served on this computer only, until Ctrl-C:

        rotor-ida explore --omega 2 --zeta 0.07 --delta0 2

    A machine in SI units, with a shaft, a linear contact with damping, and its weight:

        rotor-ida explore --mass 8 --contact-stiffness 5e7 --damping 240 \
            --eccentricity 2e-5 --clearance 1e-4 --speed 700 --shaft-stiffness 2e6 \
            --contact-exponent 1 --contact-damping 7.5 --load 78.5

    From the rotor and initial state of an archived run:

        rotor-ida explore run.nc

    A rotor system, or the playback of a drop, from a system file or from an archive:

        rotor-ida explore rotor.toml

    As a page that needs no server, with a slider over the speeds of one disc:

        rotor-ida explore --omega 2 --zeta 0.07 --delta0 2 --export page.html \
            --speeds 1.9:2.1:3
    """
    system = _system(file, rotor, start)
    if system is not None:
        if speeds is not None:
            raise InputError("speeds must be left out with a rotor system")
        if export is not None:
            return _export_system(export, system, force)
        _serve({}, port, not no_browser, system)
        return 0
    chosen, first, revolutions = _beginning(rotor, start, file)
    if export is not None:
        return _export(export, chosen, first, revolutions, speeds, force)
    if speeds is not None:
        raise InputError("speeds must be left out without --export")
    _serve(_state(chosen, first, revolutions), port, not no_browser)
    return 0


def _serve(
    state: Mapping[str, object], port: int, browser: bool, system: Path | None = None
) -> None:
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise InputError(
            f"explore needs {', '.join(missing)}: install it with pip install 'rotor-ida[explore]'"
        )
    from rotor_ida.explorer.explore import explore as serve  # noqa: PLC0415 - not for --help

    serve(state, port=port, browser=browser, report=_say, system=system)


def _system(file: Path | None, rotor: RotorOptions, start: State | str | None) -> Path | None:
    """Return the file if it is of a rotor system that can be read; None for one disc."""
    from rotor_ida.results.kinds import kind_of  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.results.system_file import load_system  # noqa: PLC0415

    if file is None or file.suffix.lower() not in ENDINGS:
        return None
    is_toml = file.suffix.lower() == ".toml"
    if not is_toml and kind_of(read(file)) not in SYSTEM_RUNS:
        return None
    if rotor.machine is not None or rotor.given or start is not None:
        raise InputError("file must be given alone: it contains the rotor and the start")
    if is_toml:
        load_system(file)
    return file.resolve()


def _beginning(
    rotor: RotorOptions, start: State | str | None, file: Path | None
) -> tuple[Rotor | DimensionalRotor, State | None, int]:
    """Return the initial machine, its start, if given, and the number of revolutions."""
    given = rotor.machine is not None or bool(rotor.given)
    if file is None:
        chosen = rotor.chosen() if given else FIRST
        first = _checked_start(chosen, begun(start, chosen))
        return chosen, None if start is None else first, REVOLUTIONS
    if given or start is not None:
        raise InputError("file must be given alone: the archive contains the rotor and the start")
    from rotor_ida.results.run import check_one_speed, rotor_of  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.results.si_units import dimensionless, machine_of  # noqa: PLC0415

    archived = read(file)
    if "event_time" not in archived or "duration" not in archived.attrs:
        raise InputError(f"file must be an archive of a run, got {shown(file)}")
    run = dimensionless(archived)
    check_one_speed(run, "the explorer")
    found = rotor_of(run)
    x, y, vx, vy = map(float, run.attrs["start"])
    turns = float(run.attrs["duration"]) * (found.omega or 1.0) / (2.0 * math.pi)
    revolutions = min(max(round(turns), 1), MOST_REVOLUTIONS)
    return machine_of(archived) or found, (x, y, vx, vy), revolutions


def _checked_start(rotor: Rotor | DimensionalRotor, start: State) -> State:
    """Return a start of the page, without dimensions, if it can be followed."""
    if isinstance(rotor, Rotor):
        check_can_be_followed(rotor, start)
        return start
    from rotor_ida.results.in_si import in_si, without_dimensions  # noqa: PLC0415

    x, y, vx, vy = without_dimensions(rotor, {"start": start})["start"].tolist()
    try:
        check_can_be_followed(rotor.rotor(), (x, y, vx, vy))
    except InputError as error:
        raise in_si(error, rotor) from error
    return x, y, vx, vy


def _state(
    machine: Rotor | DimensionalRotor, start: State | None, revolutions: int
) -> Mapping[str, object]:
    """Return the state of the page, as in its address; without a start it hangs at rest."""
    from_start = {} if start is None else dict(zip(COMPONENTS, start, strict=True))
    shown = {} if isinstance(machine, Rotor) else {"fastest": largest_speed(machine)}
    return {**machine.given, **from_start, "revolutions": revolutions, **shown}


def _export(
    place: Path, machine: Rotor | DimensionalRotor, start: State | None, revolutions: int,
    speeds: list[float] | None, force: bool,
) -> int:  # fmt: skip
    from rotor_ida.explorer.files import check_speeds, record  # noqa: PLC0415
    from rotor_ida.model.disc_starts import hanging  # noqa: PLC0415

    _check_page(place, force)
    chosen = check_speeds(machine, speeds)
    first = start or hanging(machine if isinstance(machine, Rotor) else machine.rotor())
    with working("recording") as told:
        page = record(machine, start=first, revolutions=revolutions, speeds=chosen, progress=told)
    return _write(place, page, force)


def _export_system(place: Path, system: Path, force: bool) -> int:
    from rotor_ida.explorer.system_files import recorded_page  # noqa: PLC0415 - heavy
    from rotor_ida.explorer.system_questions import SystemQuestion  # noqa: PLC0415

    _check_page(place, force)
    with working("recording"):
        page = recorded_page(SystemQuestion(about="system_html", number=0, path=system))
    return _write(place, page, force)


def _check_page(place: Path, force: bool) -> None:
    """Refuse a file that cannot be written, before anything is computed."""
    from rotor_ida.results.files import check_target  # noqa: PLC0415

    if place.suffix != PAGE:
        raise InputError(f"export must end in {PAGE}, got {shown(place)}")
    check_target("export", place, overwrite=force, permission=FORCED)


def _write(place: Path, page: str, force: bool) -> int:
    from rotor_ida.results.files import file_to_write  # noqa: PLC0415

    with file_to_write("export", place, overwrite=force) as part:
        part.write_text(page, encoding="utf-8")
    _say(f"wrote {place}")
    return 0


def _say(text: str) -> None:
    print(printable(text), file=sys.stderr, flush=True)
