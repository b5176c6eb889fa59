"""Output of a result: check its files before computing, then write them and the report."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

import rotor_ida
from rotor_ida.checks import check_panels, shown
from rotor_ida.cli.option_types import OUTPUT
from rotor_ida.cli.options import optioned
from rotor_ida.cli.report import FAILED, INTERRUPTED, Report
from rotor_ida.errors import ArchiveError, InputError, RotorError, SimulationError
from rotor_ida.results.sheets import Parts
from rotor_ida.texts import in_shell
from rotor_ida.units import UnitSystem

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    Figures = list[tuple[str, Figure]]

# Name of the result of a study in its folder.
RESULT = "result.nc"
OUT_ENDING = ".nc"
PICTURES = (".png", ".svg")
PDF = ".pdf"
FORCED = "--force"
# Most rows of a table in a report. The archive in the same folder has all of them.
MOST_IN_REPORT = 20


@Parameter(name="*", group=OUTPUT)
@optioned
@dataclass(frozen=True, kw_only=True)
class Output:
    """Where to write a result."""

    out: Path | None = None
    figure: Path | None = None
    csv: Path | None = None
    report: Path | None = None
    inch: bool = False
    as_json: bool = False
    force: bool = False
    # Whether the same command began the report before, which may then be replaced.
    continues: Annotated[bool, Parameter(parse=False)] = False
    # The node of a figure, and the line that was typed, for a report.
    node: Annotated[str | None, Parameter(parse=False)] = None
    line: Annotated[str, Parameter(parse=False)] = ""

    @property
    def system(self) -> UnitSystem:
        """The system of units of tables."""
        return "inch" if self.inch else "metric"

    def check(self, *, panels: int = 1) -> None:
        """Refuse files that cannot be written, so that no result is lost."""
        from rotor_ida.results.files import check_target  # noqa: PLC0415 - takes a moment

        if self.out is not None:
            check_file("out", self.out, OUT_ENDING, force=self.force)
        if self.csv is not None:
            from rotor_ida.results.tables import check_tables  # noqa: PLC0415 - takes a moment

            check_tables("csv", self.csv, overwrite=self.force, permission=FORCED)
        if self.report is not None:
            from rotor_ida.cli.pages import check_folder  # noqa: PLC0415 - heavy

            check_folder(
                "report", self.report, overwrite=self.force or self.continues, permission=FORCED
            )
        if self.figure is not None:
            check_panels(panels)
            if self.figure.suffix not in {"", *PICTURES, PDF} or self.figure.name in {"", ".."}:
                word = shown(self.figure)
                raise InputError(f"figure must be NAME, NAME.png, NAME.svg or NAME.pdf, got {word}")
            for ending in _endings(self.figure):
                picture = self.figure.with_suffix(ending)
                check_target("figure", picture, overwrite=self.force, permission=FORCED)


def check_file(name: str, path: Path, ending: str, *, force: bool) -> None:
    """Refuse a file that cannot be written, or whose name does not tell what is in it."""
    from rotor_ida.results.files import check_target  # noqa: PLC0415 - takes a moment

    if path.suffix != ending:
        raise InputError(f"{name} must end in {ending}, got {shown(path)}")
    check_target(name, path, overwrite=force, permission=FORCED)


def _endings(figure: Path) -> tuple[str, ...]:
    """Return the endings of the files of a figure."""
    return (PDF,) if figure.suffix == PDF else PICTURES


def write_figure(drawn: Figure, figure: Path, *, overwrite: bool) -> list[Path]:
    """Write a figure to the requested files."""
    from rotor_ida.plot import save_figure  # noqa: PLC0415 - only who draws needs it

    formats = [ending[1:] for ending in _endings(figure)]
    return save_figure(drawn, figure.with_suffix(""), overwrite=overwrite, formats=formats)


def answer(
    dataset: xr.Dataset,
    output: Output,
    *,
    most: int | None = None,
    result: Path | None = None,
    told: Callable[[int | None], tuple[dict[str, object], Parts]] | None = None,
    figures: Callable[[], Figures] | None = None,
    beside: Mapping[str, xr.Dataset] | None = None,
    rotor: Any = None,
    files: Sequence[Path] = (),
) -> Report:
    """Return the answer with a dataset, and write its files.

    A file that cannot be written becomes the trouble of the answer, so that the result is printed
    even then. Tables have `most` rows; `result` is the file of a study, which may be replaced. A
    report has the `rotor` and its `files`.

    A command that has words or figures of its own gives `told`, which returns record and parts
    with a largest number of rows of a table, and `figures`, the last of which is the one drawn to
    a file. Results that lie `beside` in the folder of a report are given by the names of files.
    """
    from rotor_ida.cli.describe import describe  # noqa: PLC0415 - heavy, and not for --help

    told = told or (lambda rows: describe(dataset, most=rows))
    draw = cache(figures or (lambda: [("Figure", _figure(dataset, output))]))
    record, parts = told(most)
    written: list[Path] = []
    failures: list[str] = []
    for path, overwrite in ((output.out, output.force), (result, True)):
        with _noting(failures):
            if path is not None:
                written.append(Path(rotor_ida.save(dataset, path, overwrite=overwrite)))
    with _noting(failures):
        if output.csv is not None:
            from rotor_ida.results.tables import save_tables  # noqa: PLC0415 - takes a moment

            written += save_tables(_with_angle(dataset), output.csv, overwrite=output.force)
    drawn = [] if output.figure is None else draw()
    with _noting(failures, f"cannot write {output.figure}: "):
        if output.figure is not None:
            written += write_figure(drawn[-1][1], output.figure, overwrite=output.force)
    with _noting(failures):
        if output.report is not None:
            if not drawn:  # a result without a figure has a report too
                with suppress(InputError):
                    drawn = draw()
            written += _write_report(
                {RESULT: dataset, **(beside or {})}, output, told(MOST_IN_REPORT)[1], drawn, rotor,
                files,
            )  # fmt: skip
    return Report(
        record=record | ({"written": [str(each) for each in written]} if written else {}),
        parts=[*parts, *(f"wrote {each}" for each in written)],
        as_json=output.as_json,
        trouble="; ".join(failures),
        system=output.system,
    )


def _with_angle(dataset: xr.Dataset) -> xr.Dataset:
    """Return a run with the angle of the rotor, without which no table can be fitted."""
    if "event_time" not in dataset or "t" not in dataset.dims or "angle" in dataset:
        return dataset
    from rotor_ida.schema import labelled  # noqa: PLC0415 - takes a moment
    from rotor_ida.signals.sampling import run_angles  # noqa: PLC0415

    times, speed = dataset["t"].values, dataset.attrs.get("speed")
    is_disc = "omega" in dataset.variables
    angles = run_angles(dataset, times) if is_disc or speed is None else speed * times
    return dataset if angles is None else dataset.assign(angle=labelled("angle", "t", angles))


@contextmanager
def _noting(failures: list[str], before: str = "") -> Iterator[None]:
    """Keep the message of an error of a file instead of raising it."""
    try:
        yield
    except (RotorError, OSError) as error:
        said = getattr(error, "strerror", None) if before else None
        failures.append(f"{before}{said or error}" if said else str(error))


def _figure(dataset: xr.Dataset, output: Output) -> Figure:
    """Return the figure of a dataset, at a node if one is given."""
    from rotor_ida.plot.appearance import without_pyplot  # noqa: PLC0415
    from rotor_ida.plot.figures import figure_of  # noqa: PLC0415 - only who draws needs it

    with without_pyplot():
        return figure_of(dataset, node=output.node)


def _write_report(
    results: Mapping[str, xr.Dataset], output: Output, parts: Parts, figures: Figures, rotor: Any,
    files: Sequence[Path],
) -> list[Path]:  # fmt: skip
    """Write a report on the first result, with the archives of all, into a folder."""
    from rotor_ida.cli.pages import write_pages  # noqa: PLC0415 - heavy
    from rotor_ida.results.question import VERBS, Question  # noqa: PLC0415

    folder = output.report
    assert folder is not None
    folder.mkdir(exist_ok=True)
    force = output.force or output.continues
    archives = [Path(rotor_ida.save(each, folder / name, overwrite=force))
                for name, each in results.items()]  # fmt: skip
    dataset = next(iter(results.values()))
    question = Question.of_result(dataset)
    can_be_checked = question is not None and question.verb in VERBS
    check = [f"rotor-ida verify {in_shell(archives[0])}"] if can_be_checked else []
    pages = write_pages(
        folder, dataset, parts, rotor=rotor, files=files, commands=[again(output.line), *check],
        figures=figures, system=output.system, overwrite=force,
    )  # fmt: skip
    return [*archives, *pages]


def again(line: str) -> str:
    """Return a command line that works where the files that it wrote are still there.

    Examples
    --------
    >>> again("rotor-ida drop rotor.toml --report report")
    'rotor-ida drop rotor.toml --report report --force'
    """
    return line if "--force" in line.split() else f"{line} --force"


def answer_whole(dataset: xr.Dataset, output: Output, study: Path | None, **more: Any) -> Report:
    """Return the answer with a sweep, basin, sample or branch, with trouble if it is incomplete."""
    in_study = None if study is None or output.out is not None else study / RESULT
    if "status" in dataset:
        report = answer(dataset, output, result=in_study, **more)
        return troubled(report, _failures(dataset), FAILED)
    if "special_kind" in dataset:
        return answer(dataset, output, result=in_study, **more)
    if "missed_fraction" in dataset:
        reason = dataset.attrs.get("not_computed_reason", "")
        report = answer(dataset, output, result=None if reason else in_study, **more)
        return troubled(report, f"not all was computed: {reason}", FAILED) if reason else report
    missing = int(dataset["not_computed_count"])
    interrupted = bool(dataset.attrs["interrupted"])
    if not missing and not interrupted:
        return answer(dataset, output, result=in_study, **more)
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
def working(name: str, study: Path | None = None) -> Iterator[Callable[[int, int], None]]:
    """Show a progress bar, or lines of it; after a failure, print how to continue the study."""
    from rotor_ida.parallel.progress import progress_bar, progress_lines  # noqa: PLC0415 - heavy

    watched = sys.stderr is not None and sys.stderr.isatty()
    try:
        with (progress_bar if watched else progress_lines)(name) as told:
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
