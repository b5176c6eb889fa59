"""The command reproduce."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rotor_ida.cli import options, parsing


def reproduce(
    *,
    out: Annotated[str, Parameter(help="Folder for archives and figures.")] = "results",
    quick: Annotated[bool, Parameter(help="Coarser and faster.", negative=())] = False,
    only: Annotated[str | None, Parameter(help="Name of the one scenario to run.")] = None,
    workers: options.Workers = None,
    force: options.Force = False,
) -> int:
    """Compute every figure of the paper and every study again.

    All of them, quickly:

        rotor-ida reproduce --quick --out results
    """
    from rotor_ida import reproduction  # noqa: PLC0415 - heavy, and not for --help

    processes = None if workers is None else parsing.whole_number("workers", workers)
    return reproduction.reproduce(Path(out), quick=quick, only=only, workers=processes, force=force)
