"""Results of jobs, gathered as they come: in memory, or in the folder of a study."""

from __future__ import annotations

import heapq
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

from rotor_ida.errors import ArchiveError
from rotor_ida.storage.studies.database import FILE
from rotor_ida.storage.studies.store import Piece, Study, opened

Result = TypeVar("Result")


class Results(Protocol[Result]):
    """The results of the jobs that are done, by number."""

    @property
    def folder(self) -> Path | None:
        """Where what is larger than memory can go; None where there is no such place."""

    @property
    def done(self) -> set[int]:
        """Numbers of the jobs that need not be done any more."""

    @property
    def points_done(self) -> int:
        """Number of points of these."""

    def keep(
        self, number: int, result: Result, points: int, *, failed: int = 0, reason: str = ""
    ) -> None:
        """Keep the result of a job, with so many points of which so many failed."""

    def hold(self, number: int, result: Result) -> None:
        """Keep the result of a job for this time only, so that the next session does it again."""

    def results(self) -> Iterator[tuple[int, Result]]:
        """Yield the number and the result of each job, in the order of the numbers."""


@dataclass(frozen=True, slots=True)
class Form(Generic[Result]):
    """How results become bytes and come back.

    Parameters
    ----------
    pack : callable
        Returns the bytes of a result.
    unpack : callable
        Returns the result again; raises `ValueError` if the bytes are none of `pack`.
    """

    pack: Callable[[Result], bytes]
    unpack: Callable[[bytes], Result]


@contextmanager
def open_results(
    folder: str | os.PathLike[str] | None,
    design: Mapping[str, Any],
    points: int,
    form: Form[Result],
) -> Iterator[Results[Result]]:
    """Gather results in the study in `folder`, or in memory if that is None.

    Parameters
    ----------
    folder, design, points
        As for `opened`.
    form : Form
        How results become bytes.

    Raises
    ------
    InputError, ArchiveError
        As `opened` does.
    """
    if folder is None:
        yield InMemory()
        return
    with opened(folder, design, points) as study:
        yield _InStudy(study, form)


class InMemory(Generic[Result]):
    """Results in memory."""

    folder: Path | None = None

    def __init__(self) -> None:
        self.points_done: int = 0
        self._results: dict[int, Result] = {}

    @property
    def done(self) -> set[int]:
        """Numbers of the jobs that are done."""
        return set(self._results)

    def keep(
        self, number: int, result: Result, points: int, *, failed: int = 0, reason: str = ""
    ) -> None:
        """Keep the result of a job."""
        del failed, reason
        self._results[number] = result
        self.points_done += points

    def hold(self, number: int, result: Result) -> None:
        """Keep the result of a job."""
        self._results[number] = result

    def results(self) -> Iterator[tuple[int, Result]]:
        """Yield the results in the order of the numbers."""
        yield from sorted(self._results.items(), key=lambda item: item[0])


class _InStudy(Generic[Result]):
    def __init__(self, study: Study, form: Form[Result]) -> None:
        self.folder: Path | None = study.folder
        self._study = study
        self._form = form
        self._held: dict[int, Result] = {}

    @property
    def done(self) -> set[int]:
        return self._study.done

    @property
    def points_done(self) -> int:
        return self._study.points_done

    def keep(
        self, number: int, result: Result, points: int, *, failed: int = 0, reason: str = ""
    ) -> None:
        self._study.keep(Piece(number, points, failed, reason, self._form.pack(result)))

    def hold(self, number: int, result: Result) -> None:
        self._held[number] = result

    def results(self) -> Iterator[tuple[int, Result]]:
        held = sorted(self._held.items(), key=itemgetter(0))
        yield from heapq.merge(held, self._stored(), key=itemgetter(0))

    def _stored(self) -> Iterator[tuple[int, Result]]:
        for number, content in self._study.contents():
            try:
                result = self._form.unpack(content)
            except ValueError as error:
                raise ArchiveError(
                    f"study {str(self.folder)!r} is damaged: piece {number} of {FILE}: {error}"
                ) from error
            yield number, result
