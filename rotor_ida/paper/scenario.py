"""What the scripts in `scenarios/` share: their options, their folder, their progress bar."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    Task,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.text import Text

from rotor_ida.errors import InputError, RotorError
from rotor_ida.paper.gallery import Entry, add_entry
from rotor_ida.parallel import count_workers
from rotor_ida.plot import save_figure
from rotor_ida.storage.archive import save

Report = Callable[[int, int], None]

DEFAULT_FOLDER = "results"


@dataclass(frozen=True, slots=True)
class Settings:
    """What a scenario script was asked for.

    Parameters
    ----------
    folder : Path
        Where to write; it exists.
    quick : bool
        Whether a coarse version will do.
    workers : int
        Number of processes.
    force : bool
        Whether files that are there may be replaced.
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
        """Write a figure as PNG and SVG, and what the gallery is to say of it.

        Parameters
        ----------
        figure : Figure
            The figure.
        name : str
            Name of its files, without the ending.
        archives : sequence of str
            Names of the archives that it was drawn from, without the ending.
        shows, found, paper : str
            What it shows, what is found, and what the paper says (empty for nothing).
        verdict : str
            In a few words, what becomes of that.
        """
        save_figure(figure, self.folder / name, overwrite=self.force)
        files = tuple(f"{archive}.nc" for archive in archives)
        entry = Entry(
            figure=name, archives=files, shows=shows, paper=paper, found=found, verdict=verdict
        )
        add_entry(self.folder, entry)


def output_folder(out: str | os.PathLike[str], name: str) -> Path:
    """Return the folder into which the scenario `name` writes: ``out/name``."""
    return Path(out) / name


def check_folder(folder: Path, *, force: bool) -> None:
    """Refuse a folder that holds something already, unless `force` is true.

    Raises
    ------
    InputError
        If it holds something, or is no folder.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"the output must be a folder, got the file {str(folder)!r}")
    if folder.is_dir() and any(folder.iterdir()) and not force:
        raise InputError(
            f"{str(folder)!r} holds results already: choose another folder, or replace them with "
            "--force"
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
        What computes and writes.
    description : str
        What it shows, for ``--help``.
    script : str
        File of the script; its name is that of the folder that it writes.
    arguments : sequence of str, optional
        By default those of the command line.

    Returns
    -------
    int
        Exit status: 0 done, 1 the run failed, 2 bad input.
    """
    name = Path(script).stem
    parser = argparse.ArgumentParser(
        prog=name, description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="a coarse version, in seconds")
    parser.add_argument(
        "--out", default=DEFAULT_FOLDER, metavar="FOLDER",
        help=f"write into FOLDER/{name} (default: {DEFAULT_FOLDER})",
    )  # fmt: skip
    parser.add_argument(
        "--workers", type=int, metavar="N", help="number of processes (default: one a core)"
    )
    parser.add_argument("--force", action="store_true", help="replace results that are there")
    given = parser.parse_args(arguments)
    folder = output_folder(given.out, name)
    try:
        check_folder(folder, force=given.force)
        workers = count_workers(given.workers)
        folder.mkdir(parents=True, exist_ok=True)
        scenario(Settings(folder, given.quick, workers, given.force))
    except InputError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    except (RotorError, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    print(f"written to {folder}")
    return 0


class _RateColumn(ProgressColumn):
    """Points a second."""

    def render(self, task: Task) -> Text:
        rate = task.finished_speed or task.speed
        return Text("" if rate is None else f"{rate:.3g}/s")


@contextmanager
def progress_bar(description: str) -> Iterator[Report]:
    """Show a progress bar with the time left on standard error.

    Yields
    ------
    callable
        To be called with the number of points done and their total, as by `rotor_ida.sweep`.
    """
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), _RateColumn(),
        TimeElapsedColumn(), TextColumn("left"), TimeRemainingColumn(),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(description, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
