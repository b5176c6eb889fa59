"""The command from-ross: from a saved rotor of ROSS to a system file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rotor_ida.checks import shown
from rotor_ida.cli.command import Case, command
from rotor_ida.cli.output import FORCED
from rotor_ida.cli.report import Report
from rotor_ida.errors import InputError, InstallationError, MissingFileError
from rotor_ida.model.bearing import Bearing
from rotor_ida.results.files import already_there
from rotor_ida.results.sheets import Line, Parts, Sheet, facts


@command("none", asks=(), file="FILE", writes=False)
def from_ross(
    case: Case, *, speed: float | None = None, out: Path, as_json: bool = False, force: bool = False
) -> Report:
    r"""Turn a saved rotor of ROSS into a system file, with the tables of its bearings and seals.

    The file is one that its method save has written. ROSS must be installed:

        rotor-ida from-ross compressor.toml --out rotor.toml
    """
    from rotor_ida.model.rotor_system import RotorSystem  # noqa: PLC0415 - takes a moment

    (file,) = case.measured
    if not file.exists():
        raise MissingFileError(f"file must be a file that exists, got {shown(file)}")
    if out.exists() and not force:
        raise already_there(out, FORCED)
    try:
        import ross  # noqa: PLC0415 - takes seconds
    except ImportError as error:
        raise InstallationError(
            f"from-ross needs ROSS: pip install ross-rotordynamics ({error})"
        ) from error
    try:
        rotor = ross.Rotor.load(file)
    except Exception as error:  # a damaged file can make it raise anything
        told = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"cannot read the rotor {shown(file)}: {told[:200]}") from error
    system = RotorSystem.from_ross(rotor, speed=speed)
    system.to_file(out, overwrite=force)
    numbers: dict[str, float] = {
        "degrees of freedom": system.size, "nodes": len(system.nodes),
        "bearings and seals": len(system.bearings),
    }  # fmt: skip
    record = {"system": numbers, "bearings": [
        {"name": each.name, "node": each.node, "stator": each.stator,
         "speeds": np.ravel([] if each.speed is None else each.speed).tolist()}
        for each in system.bearings
    ]}  # fmt: skip
    parts: Parts = [facts("System", numbers), *_bearings(system.bearings), f"wrote {out}"]
    return Report(record=record, parts=parts, as_json=as_json)


def _bearings(bearings: Sequence[Bearing]) -> list[Sheet]:
    """Return the names of bearings and seals, their nodes and the ends of their tables."""
    if not bearings:
        return []
    ends = [(each.knots[[0, -1]] if each.varies else (None, None)) for each in bearings]
    lines = [Line("name", [each.name or "" for each in bearings]),
             Line("node", [each.node for each in bearings]),
             Line("held by node", [each.stator or "ground" for each in bearings])]  # fmt: skip
    lines += [Line(name, [end[place] for end in ends], "rad/s")
              for place, name in enumerate(("table from", "table to"))]  # fmt: skip
    return [Sheet("Bearings and seals", lines)]
