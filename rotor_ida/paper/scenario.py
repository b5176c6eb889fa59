"""Common parts of the scripts in `scenarios/`: options, folder, progress bar."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import xarray as xr
from cyclopts import App, CycloptsError, Parameter
from matplotlib.figure import Figure

from rotor_ida.checks import shown
from rotor_ida.errors import InputError, RotorError
from rotor_ida.paper.gallery import Entry, add_entry
from rotor_ida.parallel import count_workers
from rotor_ida.parallel.progress import progress_bar
from rotor_ida.plot import save_figure
from rotor_ida.plot.appearance import without_pyplot
from rotor_ida.results.archive import save

__all__ = ["Settings", "check_folder", "progress_bar", "run_script", "scientific"]

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

Quick = Annotated[
    bool, Parameter(help="Compute a coarse version, in seconds.", negative=(), show_default=False)
]
Out = Annotated[Path, Parameter(help="Write into a folder of the script's name in this one.")]
Workers = Annotated[int | None, Parameter(help="Number of processes; default: one per core.")]
Force = Annotated[
    bool, Parameter(help="Replace existing results.", negative=(), show_default=False)
]


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of a scenario run.

    Parameters
    ----------
    folder : Path
        Existing output folder.
    quick : bool
        Whether to compute a coarse version.
    workers : int
        Number of processes.
    force : bool
        Whether existing files may be replaced.
    """

    folder: Path
    quick: bool
    workers: int
    force: bool

    def keep(self, dataset: xr.Dataset, name: str) -> None:
        """Write a dataset to the archive `name`, without its ending, in the folder."""
        save(dataset, self.folder / f"{name}.nc", overwrite=self.force)

    def show(
        self,
        figure: Figure,
        name: str,
        *,
        archives: Sequence[str],
        shows: str,
        found: str,
        paper: str = "",
        verdict: str = "",
    ) -> None:
        """Write a figure as PNG and SVG, with its text in the gallery.

        File names, also those of `archives`, have no ending; for the texts see `gallery.Entry`.
        """
        save_figure(figure, self.folder / name, overwrite=self.force)
        files = tuple(f"{archive}.nc" for archive in archives)
        entry = Entry(
            figure=name, archives=files, shows=shows, paper=paper, found=found, verdict=verdict
        )
        add_entry(self.folder, entry)


def check_folder(folder: Path, *, force: bool) -> None:
    """Refuse a folder that is not empty, unless `force` is true.

    Raises
    ------
    InputError
        If it is not empty, or not a folder.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"the output must be a folder, got the file {shown(folder)}")
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise InputError(
            f"{shown(folder)} contains results already: choose another folder, or replace "
            "them with --force"
        )


def run_script(
    scenario: Callable[[Settings], None],
    *,
    description: str,
    script: str,
    arguments: Sequence[str] | None = None,
) -> int:
    """Run a scenario with the options of the command line.

    Parameters
    ----------
    scenario : callable
        Function that computes and writes.
    description : str
        Description for ``--help``.
    script : str
        File of the script; its name is that of the folder that it writes.
    arguments : sequence of str, optional
        Arguments; default: those of the command line.

    Returns
    -------
    int
        Exit status: 0 done, 1 the run failed, 2 bad input.
    """
    name = Path(script).stem

    def run(
        *,
        quick: Quick = False,
        out: Out = Path("results"),
        workers: Workers = None,
        force: Force = False,
    ) -> None:
        folder = out / name
        check_folder(folder, force=force)
        settings = Settings(folder, quick, count_workers(workers), force)
        folder.mkdir(parents=True, exist_ok=True)
        with without_pyplot():
            scenario(settings)
        print(f"written to {folder}")

    app = App(name=name, help=description, help_format="markdown", version_flags=())
    app.default(run)
    try:
        command, given = app.parse_args(arguments, print_error=False, exit_on_error=False)[:2]
        command(*given.args, **given.kwargs)
    except (CycloptsError, RotorError, OSError) as error:
        if isinstance(error, CycloptsError):
            error.verbose = False
        print(f"{name}: {error}", file=sys.stderr)
        return 2 if isinstance(error, CycloptsError | InputError) else 1
    return 0


def scientific(number: float) -> str:
    """Return a number as a digit and a power of ten, typeset.

    Examples
    --------
    >>> scientific(1.6e-10), scientific(1e3)
    ('2·10⁻¹⁰', '10³')
    """
    if not number:
        return "0"
    digit, power = f"{number:.0e}".split("e")
    ten = f"10{str(int(power)).translate(_RAISED)}"
    return ten if digit == "1" else f"{digit}·{ten}"
