"""The command reproduce."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rotor_ida.cli import options

Only = Annotated[
    list[str] | None,
    Parameter(
        help="Names of the scenarios to run, or how they begin.", consume_multiple=True, negative=()
    ),
]


def reproduce(
    *,
    out: Annotated[Path, Parameter(help="Folder for archives and figures.")] = Path("results"),
    quick: Annotated[
        bool, Parameter(help="Coarser and faster.", negative=(), show_default=False)
    ] = False,
    only: Only = None,
    workers: options.Workers = None,
    force: options.Force = False,
) -> int:
    """Compute every figure of the paper and every study again, on a page index.html.

    What is up to date is left alone; one that fails does not stop the others. One of them, coarse
    but quick, named in full or by how it begins:

        rotor-ida reproduce --only fig06_jumps --quick --out results
    """
    from rotor_ida.paper import reproduction  # noqa: PLC0415 - heavy, and not for --help

    return reproduction.reproduce(out, quick=quick, only=only, workers=workers, force=force)
