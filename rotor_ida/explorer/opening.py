"""Open any file: a machine, a rotor system, an archive of any result, or a measurement."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from rotor_ida.explorer.archives import loaded
from rotor_ida.explorer.cases import case_in
from rotor_ida.explorer.messages import (
    MOST_REVOLUTIONS,
    ROTOR_ENDINGS,
    Answer,
    Upload,
    named,
    state_of,
)
from rotor_ida.model.data_sheet import KEYS, implausible
from rotor_ida.results.checked_run import rotor_of
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.machine_file import load_machine, read_data_sheet
from rotor_ida.results.si_units import dimensionless, machine_of


def show_upload(upload: Upload) -> Iterator[Answer]:
    """Yield what is in a file that the page has sent."""
    path = upload.path
    assert path is not None
    if path.suffix.lower() not in ROTOR_ENDINGS:
        from rotor_ida.explorer.measured import show_measured  # noqa: PLC0415 - slow to import

        yield from show_measured(upload)
        return
    with named(path, upload.name):
        state, notes = state_in(path)
    part = "system" if "node" in state else "machine"
    yield Answer(part, {"name": upload.name, "state": state, "notes": notes})


def state_in(path: Path) -> tuple[dict[str, object], list[str]]:
    """Return the state of a page that shows what is in the file of a rotor, and warnings.

    Of a rotor system it has a node, which is still to be chosen; the program keeps the file.
    """
    if path.suffix.lower() == ".toml":
        with named(path):
            entries = read_data_sheet(path)
            if "mass" in entries and entries.keys() <= KEYS.keys():
                machine = load_machine(path)
                return state_of(machine), implausible(machine)
        case_in(path)
        return {"node": ""}, []
    archived = loaded(path)
    if kind_of(archived) != "run" or "event_speed" in archived:
        return {"node": ""}, []
    run = dimensionless(archived)
    rotor = rotor_of(run)
    x, y, vx, vy = map(float, run.attrs["start"])
    turns = float(run.attrs["duration"]) * (rotor.omega or 1.0) / (2.0 * math.pi)
    revolutions = min(max(round(turns), 1), MOST_REVOLUTIONS)
    return state_of(machine_of(archived) or rotor, (x, y, vx, vy), revolutions), []
