"""The command explore: an interactive page in the browser."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from rotor_ida.checks import COMPONENTS, State, check_state, shown
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.commands.plot import as_read
from rotor_ida.cli.output import check_file, working
from rotor_ida.cli.parsing import refuse_units
from rotor_ida.cli.rotor_options import RotorOptions
from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import ROTOR_ENDINGS, Question, machine_of, state_of
from rotor_ida.model.parameters import MACHINE_PARAMETERS, OPTIONAL, PARAMETERS
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.simulation.options import check_can_be_followed
from rotor_ida.texts import printable

# Packages that serve the page, not required otherwise.
NEEDED = ("starlette", "uvicorn", "websockets")
FIRST = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REVOLUTIONS = 60
PAGE = ".html"


@command("one", asks=(), file="[FILE]", reads=True, writes=False)
def explore(
    case: Case, *, start: State | str | None = None, port: int = 8765, no_browser: bool = False,
    export: Path | None = None, speeds: list[float] | None = None, force: bool = False,
) -> int:  # fmt: skip
    r"""Open an interactive page in the browser, with sliders for the parameters.

    The page is served on this computer only, until Ctrl-C:

        rotor-ida explore --omega 2 --zeta 0.07 --delta0 2

    A machine in SI units, with a shaft, a linear contact with damping, and its weight:

        rotor-ida explore --mass 8 --contact-stiffness 5e7 --damping 240 \
            --eccentricity 2e-5 --clearance 1e-4 --speed 700 --shaft-stiffness 2e6 \
            --contact-exponent 1 --contact-damping 7.5 --load 78.5

    Any file: a machine or a rotor system, as TOML; an archived run or drop, played or as rotor
    and initial state; or a measurement, beside a rotor:

        rotor-ida explore pump.toml
        rotor-ida explore run.nc
        rotor-ida explore probes.csv

    A measurement is read by the same options as by plot:

        rotor-ida explore probes.csv --sensitivity 7.87V/mm --gap=-10V

    As a page that needs no server, with a slider over the speeds of one disc:

        rotor-ida explore --omega 2 --zeta 0.07 --delta0 2 --export page.html \
            --speeds 1.9:2.1:3
    """
    state, served = _beginning(case.rotors, start, next(iter(case.measured), None))
    read = as_read(case.reading)
    if read and "measured" not in state:
        raise InputError(f"{next(iter(read))} must be left out without a measured file")
    if speeds is not None and "node" in state:
        raise InputError("speeds must be left out with a rotor system")
    if export is None:
        if speeds is not None:
            raise InputError("speeds must be left out without --export")
        _serve(state, port, not no_browser, served, read)
        return 0
    check_file("export", export, PAGE, force=force)
    return _write(export, _recorded(state, served, speeds), force)


def _serve(
    state: Mapping[str, object], port: int, browser: bool, file: Path | None,
    reading: Mapping[str, object],
) -> None:  # fmt: skip
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        raise InputError(
            f"explore needs {', '.join(missing)}: install it with pip install 'rotor-ida[explore]'"
        )
    from rotor_ida.explorer.explore import explore as serve  # noqa: PLC0415 - not for --help

    serve(state, port=port, browser=browser, report=_say, file=file, reading=reading)


def _beginning(
    rotor: RotorOptions, start: State | str | None, file: Path | None
) -> tuple[dict[str, object], Path | None]:
    """Return the initial state of the page, and the file that it needs."""
    given = rotor.machine is not None or bool(rotor.given)
    if file is not None and not file.is_file():
        raise InputError(f"file must be a file that exists, got {shown(file)}")
    is_rotor = file is not None and file.suffix.lower() in ROTOR_ENDINGS
    if file is not None and not is_rotor:
        if not given:
            return {"measured": file.name}, file.resolve()  # alone, without a rotor beside
        if rotor.machine is None and rotor.given.keys() == {"clearance"}:
            raise InputError(
                "clearance must be left out beside a measured file, whose panels have no circle of "
                "it, unless all of a rotor is given: plot with kind orbit or centreline draws it"
            )
    if file is None or not is_rotor:
        chosen = rotor.chosen() if given else FIRST
        first = _first_state(chosen, start)
        state = state_of(chosen, None if start is None else first, REVOLUTIONS)
        return (state, None) if file is None else (state | {"measured": file.name}, file.resolve())
    if given or start is not None:
        raise InputError("file must be given alone: it contains the rotor and the start")
    from rotor_ida.explorer.opening import state_in  # noqa: PLC0415 - heavy, and not for --help

    state, _ = state_in(file.resolve())
    return state, file.resolve() if "node" in state else None


def _first_state(chosen: Rotor | DimensionalRotor, start: State | str | None) -> State:
    """Return a start without dimensions, if it can be followed; a word is that of the rotor."""
    from rotor_ida.results.in_si import in_si, without_dimensions  # noqa: PLC0415 - heavy
    from rotor_ida.simulation.starts import start_of  # noqa: PLC0415

    rotor = chosen if isinstance(chosen, Rotor) else chosen.rotor()
    if isinstance(start, str | None):
        state = start_of(rotor, start)
    elif isinstance(chosen, Rotor):
        refuse_units({"start": start})
        state = start
    else:
        state = check_state("start", without_dimensions(chosen, {"start": start})["start"].tolist())
    try:
        check_can_be_followed(rotor, state)
    except InputError as error:
        raise error if isinstance(chosen, Rotor) else in_si(error, chosen) from error
    return state


def _recorded(state: Mapping[str, object], served: Path | None, speeds: list[float] | None) -> str:
    """Return a page that needs no server."""
    from rotor_ida.explorer import files  # noqa: PLC0415 - heavy, and not for --help
    from rotor_ida.simulation.starts import start_of  # noqa: PLC0415

    if "node" in state:
        asked = Question(about="html", number=0, path=served)
    elif served is not None:
        raise InputError("export must be of a rotor: a page without a program reads no measurement")
    else:
        names = (*PARAMETERS, *MACHINE_PARAMETERS, *OPTIONAL)
        machine = machine_of({name: state[name] for name in names if name in state})
        rotor = machine if isinstance(machine, Rotor) else machine.rotor()
        if rotor is machine:
            refuse_units({"speeds": speeds})
        first = [float(str(state[name])) for name in COMPONENTS if name in state]
        asked = Question(
            about="html", number=0, machine=machine,
            start=start_of(rotor, check_state("start", first) if first else None),
            revolutions=int(str(state.get("revolutions", REVOLUTIONS))),
        )  # fmt: skip
        speeds = files.check_speeds(machine, speeds)
    steps = files.recording(asked, speeds=speeds)
    with working("recording") as told:
        return files.finished(steps, told)


def _write(place: Path, page: str, force: bool) -> int:
    from rotor_ida.results.files import file_to_write  # noqa: PLC0415

    with file_to_write(place, overwrite=force) as part:
        part.write_text(page, encoding="utf-8")
    _say(f"wrote {place}")
    return 0


def _say(text: str) -> None:
    print(printable(text), file=sys.stderr, flush=True)
