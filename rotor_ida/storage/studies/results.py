"""Results of jobs, gathered as they come: in memory, or in the folder of a study."""

from __future__ import annotations

import heapq
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Generic, TypeVar

from rotor_ida.errors import ArchiveError
from rotor_ida.storage.studies.database import FILE
from rotor_ida.storage.studies.store import Piece, Study, opened

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Form(Generic[Result]):
    """How results become bytes and come back; `unpack` raises `ValueError` for other bytes."""

    pack: Callable[[Result], bytes]
    unpack: Callable[[bytes], Result]


class Results(Generic[Result]):
    """The results of jobs, by number.

    Parameters
    ----------
    study : Study, optional
        Where they are kept; by default in memory.
    form : Form, optional
        How they become bytes there.

    Attributes
    ----------
    folder : Path or None
        Where what is larger than memory can go; None where there is no such place.
    done : set of int
        Numbers of the jobs that need not be done any more.
    points_done : int
        Number of points of these.
    """

    def __init__(self, study: Study | None = None, form: Form[Result] | None = None) -> None:
        self.folder = study.folder if study else None
        self.done = set(study.done) if study else set()
        self.points_done = study.points_done if study else 0
        self._study, self._form = study, form
        self._held: dict[int, Result] = {}  # those in memory

    def keep(
        self, number: int, result: Result, points: int, *, failed: int = 0, reason: str = ""
    ) -> None:
        """Keep the result of a job, with so many points of which so many failed."""
        if self._study is None or self._form is None:
            self._held[number] = result
        else:
            self._study.keep(Piece(number, points, failed, reason, self._form.pack(result)))
        self.done.add(number)
        self.points_done += points

    def hold(self, number: int, result: Result) -> None:
        """Keep the result of a job for this time only, so that the next session does it again."""
        self._held[number] = result

    def results(self) -> Iterator[tuple[int, Result]]:
        """Yield the number and the result of each job, in the order of the numbers."""
        held = sorted(self._held.items(), key=itemgetter(0))
        yield from heapq.merge(held, self._stored(), key=itemgetter(0))

    def _stored(self) -> Iterator[tuple[int, Result]]:
        if self._study is None or self._form is None:
            return
        for number, content in self._study.contents():
            try:
                result = self._form.unpack(content)
            except ValueError as error:
                raise ArchiveError(
                    f"study {str(self.folder)!r} is damaged: piece {number} of {FILE}: {error}"
                ) from error
            yield number, result


@contextmanager
def open_results(
    folder: str | os.PathLike[str] | None,
    design: Mapping[str, Any],
    points: int,
    form: Form[Result],
) -> Iterator[Results[Result]]:
    """Gather results in the study in `folder`, begun as by `opened`, or in memory if it is None."""
    if folder is None:
        yield Results()
        return
    with opened(folder, design, points) as study:
        yield Results(study, form)
