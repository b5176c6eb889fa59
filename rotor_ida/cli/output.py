"""Output of a result: check its files before computing, then write them and the report."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import check_panels, shown
from rotor_ida.cli import options
from rotor_ida.cli.option_types import OUTPUT
from rotor_ida.cli.report import FAILED, INTERRUPTED, Report
from rotor_ida.errors import ArchiveError, InputError, RotorError, SimulationError
from rotor_ida.texts import in_shell

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

# Name of the result of a study in its folder.
RESULT = "result.nc"
OUT_ENDING = ".nc"
PICTURES = (".png", ".svg")
PDF = ".pdf"
FORCED = "--force is given"


@Parameter(name="*", group=OUTPUT)
@dataclass(frozen=True, kw_only=True)
class Output:
    """Where to write a result."""

    out: options.Out = None
    figure: options.Figure = None
    csv: options.Csv = None
    inch: options.Inch = False
    as_json: options.AsJson = False
    force: options.Force = False

    def check(self, *, panels: int = 1) -> None:
        """Refuse files that cannot be written, so that no result is lost."""
        from rotor_ida.results.files import check_target  # noqa: PLC0415 - takes a moment

        if self.out is not None:
            if self.out.suffix != OUT_ENDING:
                raise InputError(f"out must end in {OUT_ENDING}, got {shown(self.out)}")
            check_target("out", self.out, overwrite=self.force, permission=FORCED)
        if self.csv is not None:
            from rotor_ida.results.tables import check_tables  # noqa: PLC0415 - takes a moment

            check_tables("csv", self.csv, overwrite=self.force, permission=FORCED)
        if self.figure is not None:
            check_panels(panels)
            if self.figure.suffix not in {"", *PICTURES, PDF} or self.figure.name in {"", ".."}:
                word = shown(self.figure)
                raise InputError(f"figure must be NAME, NAME.png, NAME.svg or NAME.pdf, got {word}")
            for ending in _endings(self.figure):
                picture = self.figure.with_suffix(ending)
                check_target("figure", picture, overwrite=self.force, permission=FORCED)


def _endings(figure: Path) -> tuple[str, ...]:
    """Return the endings of the files of a figure."""
    return (PDF,) if figure.suffix == PDF else PICTURES


def write_figure(drawn: Figure, figure: Path, *, overwrite: bool) -> list[Path]:
    """Write a figure to the requested files."""
    from rotor_ida.plot import save_figure  # noqa: PLC0415 - only who draws needs it

    formats = [ending[1:] for ending in _endings(figure)]
    return save_figure(drawn, figure.with_suffix(""), overwrite=overwrite, formats=formats)


def answer(
    dataset: xr.Dataset, output: Output, *, most: int | None = None, result: Path | None = None
) -> Report:
    """Return the report on a dataset, and write its files.

    A file that cannot be written becomes the trouble of the report, so that the result is printed
    even then. Tables have `most` rows; `result` is the file of a study, which may be replaced.
    """
    from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help

    written, failures = [], []
    for path, overwrite in ((output.out, output.force), (result, True)):
        if path is not None:
            try:
                rotor_ida.save(dataset, path, overwrite=overwrite)
                written.append(f"wrote {path}")
            except (RotorError, OSError) as error:
                failures.append(str(error))
    if output.csv is not None:
        from rotor_ida.results.tables import save_tables  # noqa: PLC0415 - takes a moment

        try:
            tables = save_tables(dataset, output.csv, overwrite=output.force)
            written += [f"wrote {file}" for file in tables]
        except (RotorError, OSError) as error:
            failures.append(str(error))
    if output.figure is not None:
        from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415
        from rotor_ida.plot.figures import figure_of  # noqa: PLC0415 - only who draws needs it

        with without_pyplot():
            drawn = figure_of(dataset)
        try:
            files = write_figure(drawn, output.figure, overwrite=output.force)
            written += [f"wrote {file}" for file in files]
        except OSError as error:
            failures.append(f"cannot write {output.figure}: {error.strerror or error}")
    record, parts = describe(dataset, most=most)
    return Report(
        record=record,
        parts=[*parts, *written],
        as_json=output.as_json,
        trouble="; ".join(failures),
        system="inch" if output.inch else "metric",
    )


def summarised(summary: xr.Dataset, report: Report) -> Report:
    """Return a report that begins with a summary of its result."""
    from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help

    record, parts = describe(summary)
    told = {"summary": record | {"sentence": summary.attrs["sentence"]}}
    return replace(report, record=told | dict(report.record), parts=[*parts, *report.parts])


def answer_whole(dataset: xr.Dataset, output: Output, study: Path | None) -> Report:
    """Return the report on a sweep, basin, sample or branch, with trouble if it is incomplete."""
    in_study = None if study is None or output.out is not None else study / RESULT
    if "status" in dataset:
        report = answer(dataset, output, result=in_study)
        return troubled(report, _failures(dataset), FAILED)
    if "special_kind" in dataset:
        return answer(dataset, output, result=in_study)
    if "missed_fraction" in dataset:
        reason = dataset.attrs.get("not_computed_reason", "")
        report = answer(dataset, output, result=None if reason else in_study)
        return troubled(report, f"not all was computed: {reason}", FAILED) if reason else report
    missing = int(dataset["not_computed_count"])
    interrupted = bool(dataset.attrs["interrupted"])
    if not missing and not interrupted:
        return answer(dataset, output, result=in_study)
    # a study can continue, and has a result when complete
    report = answer(dataset, output if study is None else Output(as_json=output.as_json))
    trouble = f"{_reason(dataset, missing)}{going_on(study)}"
    return troubled(report, trouble, INTERRUPTED if interrupted else FAILED)


def troubled(report: Report, trouble: str, status: int) -> Report:
    """Return a report with trouble before that which it has."""
    both = "; ".join(filter(None, [trouble, report.trouble]))
    return replace(report, trouble=both, status=status)


def _failures(dataset: xr.Dataset) -> str:
    failed = dataset["status"].values != 0
    if not failed.any():
        return ""
    first = dataset["message"].values[failed][0]
    return f"{failed.sum()} of {failed.size} points failed; the first: {first}"


def _reason(dataset: xr.Dataset, missing: int) -> str:
    total = dataset["label"].size if "label" in dataset else int(dataset.attrs["starts"])
    done = f"{total - missing} of {total} starts are done"
    if dataset.attrs["interrupted"]:
        return f"interrupted: {done}"
    return f"{done}: {dataset.attrs.get('not_computed_reason', '')}"


def read(file: Path) -> xr.Dataset:
    """Return the dataset in an archive; an unusable one is an input error."""
    try:
        return rotor_ida.load(file)
    except ArchiveError as error:
        raise InputError(str(error)) from error


@contextmanager
def working(name: str, study: Path | None = None) -> Iterator[Callable[[int, int], None] | None]:
    """Show a progress bar on a terminal; after a failure, print how to continue the study."""
    from rotor_ida.parallel.progress import progress_bar  # noqa: PLC0415 - not for --help

    watched = sys.stderr is not None and sys.stderr.isatty()
    try:
        with progress_bar(name) if watched else nullcontext() as told:
            yield told
    except InputError:
        raise
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"interrupted{going_on(study)}") from None
    except SimulationError as error:
        raise RotorError(f"{error}{going_on(study)}") from error
    except (ArchiveError, MemoryError) as error:
        said = str(error) or "not enough memory for this much data"
        raise RotorError(f"{said}{going_on(study)}") from error


def going_on(study: Path | None) -> str:
    """Return how to continue a study; empty if there is none."""
    if study is None:
        return ""
    try:
        found = rotor_ida.status(study)
    except RotorError:
        return ""
    saved = f"; {found['done']} of {found['points']} points are saved in {study}; "
    if found["kind"] == "drop_ensemble":  # the command writes a report besides
        return f"{saved}the same command continues"
    return f"{saved}continue with rotor-ida resume {in_shell(study)}"


def check_varies(points: int) -> None:
    """Refuse a figure of an atlas in which nothing varies."""
    if points < 2:
        raise InputError("figure needs an atlas of several speeds, dampings or clearances, got one")
