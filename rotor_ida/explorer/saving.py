"""What one keeps of what the page shows: archive, figure, the lines to make them, the page."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import xarray as xr

from rotor_ida.explorer.answers import Answer
from rotor_ida.explorer.motion import METHOD, duration_of, run_of, samples_of
from rotor_ida.explorer.questions import Question
from rotor_ida.explorer.recording import SHOWN, check_speeds, recording
from rotor_ida.model.parameters import DimensionalRotor
from rotor_ida.plot import plot_machine, plot_run, save_figure
from rotor_ida.results.archive import save
from rotor_ida.results.si_units import dimensional

NAME = "run"
LINES = '''\
"""The run that the explorer showed: its archive and its figure."""

from rotor_ida import {names}
from rotor_ida.plot import {plot}, save_figure

machine = {machine}
run = simulate(
    {rotor},
    start={start},
    duration={duration!r},
    samples={samples},
    method={method!r},
)
save(run, "{name}.nc", overwrite=True)
save_figure({plot}({shown}), "{name}", overwrite=True)
'''


def show_file(question: Question) -> Iterator[Answer]:
    """Yield a file, whole, with its name; before a page how much of it is recorded."""
    contents = b""
    if question.about == "html":
        steps = _recording(question)
        while not contents:
            try:
                done, total = next(steps)
            except StopIteration as end:
                contents = str(end.value).encode()
            else:
                yield Answer("progress", {"done": done, "total": total})
    else:
        contents = _contents(question)
    name = f"{NAME}.{question.about}"
    yield Answer("file", {"name": name}, {"contents": np.frombuffer(contents, dtype=np.int8)})


def _recording(question: Question) -> Generator[tuple[int, int], None, str]:
    """Record the page over the usual speeds, and at the one that is shown."""
    machine = question.machine
    speed, rate = question.rotor.omega, 1.0
    if isinstance(machine, DimensionalRotor):
        speed, rate = machine.speed, machine.reference_frequency
    low, high = (limit * rate for limit in SHOWN)
    own = {speed} if low <= speed <= high else set()
    speeds = sorted({*check_speeds(machine, None), *own})
    return recording(machine, start=question.start, revolutions=question.revolutions, speeds=speeds)


def command_of(question: Question) -> str:
    """Return the command line that makes archive and figure again, without dimensions.

    Examples
    --------
    >>> from rotor_ida.explorer.workers import example
    >>> command_of(example("sh", (1.7, 0.07, 0.5))).partition(" --start")[0]
    'rotor-ida simulate --omega 1.7 --zeta 0.07 --delta0 0.5'
    """
    given = question.rotor.given.items()
    rotor = " ".join(f"--{name.replace('_', '-')} {value!r}" for name, value in given)
    start = " ".join(repr(float(each)) for each in question.start)
    return (
        f"rotor-ida simulate {rotor} --start {start} --duration {duration_of(question)!r} "
        f"--samples {samples_of(question)} --method {METHOD} --out {NAME}.nc --figure {NAME}"
    )


def lines_of(question: Question) -> str:
    """Return the lines of Python that make archive and figure again.

    Examples
    --------
    >>> from rotor_ida.explorer.workers import example
    >>> print(lines_of(example("py", (1.7, 0.07, 0.5))).splitlines()[5])
    machine = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    """
    machine = question.machine
    in_si = isinstance(machine, DimensionalRotor)
    given = ", ".join(f"{name}={value!r}" for name, value in machine.given.items())
    return LINES.format(
        names="DimensionalRotor, dimensional, save, simulate" if in_si else "Rotor, save, simulate",
        plot="plot_machine" if in_si else "plot_run",
        machine=f"{type(machine).__name__}({given})",
        rotor="machine.rotor()" if in_si else "machine",
        start=question.start,
        duration=duration_of(question),
        samples=samples_of(question),
        method=METHOD,
        name=NAME,
        shown="dimensional(run, machine)" if in_si else "run",
    )


def _contents(question: Question) -> bytes:
    if question.about == "py":
        return lines_of(question).encode()
    if question.about == "sh":
        return f"{command_of(question)}\n".encode()
    run = run_of(question)
    with TemporaryDirectory() as folder:
        place = Path(folder) / NAME
        if question.about == "nc":
            save(run, place.with_suffix(".nc"))
        else:
            save_figure(_figure(question, run), place)
        return place.with_suffix(f".{question.about}").read_bytes()


def _figure(question: Question, run: xr.Dataset):  # type: ignore[no-untyped-def]
    machine = question.machine
    if isinstance(machine, DimensionalRotor):
        return plot_machine(dimensional(run, machine))
    return plot_run(run)
