"""Results of jobs, collected as they arrive: in memory, or in the folder of a study."""

from __future__ import annotations

import heapq
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from operator import itemgetter
from typing import Any, Generic, TypeVar

from rotor_ida.arrays import Arrays
from rotor_ida.errors import ArchiveError
from rotor_ida.results.studies.arrays import packed, unpacked
from rotor_ida.results.studies.store import PIECES, Piece, Study, opened

Result = TypeVar("Result")
Folder = str | os.PathLike[str]


@dataclass(frozen=True, slots=True)
class Form(Generic[Result]):
    """The name of a result, and its conversion to arrays and back.

    Examples
    --------
    >>> import numpy as np
    >>> form = Form("time", lambda time: {"t": np.array(time)}, lambda arrays: float(arrays["t"]))
    >>> form.unpack(form.pack(0.1))
    0.1
    >>> form.unpack(packed({}))
    Traceback (most recent call last):
    ...
    ValueError: it contains no time: 't'
    """

    word: str
    as_arrays: Callable[[Result], Arrays]
    from_arrays: Callable[[Arrays], Result]

    def pack(self, result: Result) -> bytes:
        """Return a result as bytes that `unpack` reads."""
        return packed(self.as_arrays(result))

    def unpack(self, content: bytes) -> Result:
        """Return the result packed by `pack`; raise `ValueError` if these are other bytes."""
        arrays = unpacked(content)
        try:
            return self.from_arrays(arrays)
        except (KeyError, TypeError, IndexError, ValueError) as error:
            raise ValueError(f"it contains no {self.word}: {error}") from error


class Results(Generic[Result]):
    """The results of jobs, by number: in a study, or by default in memory.

    Data larger than memory can go to `folder`, if there is one. The jobs in `done` are complete;
    `points_done` is the number of their points.
    """

    def __init__(self, study: Study | None = None, form: Form[Result] | None = None) -> None:
        self.folder = study.folder if study else None
        self.done = set(study.done) if study else set()
        self.points_done = study.points_done if study else 0
        self._study, self._form = study, form
        self._held: dict[int, Result] = {}  # those in memory
        self.lost = ""  # why one has no result

    def keep(
        self, number: int, result: Result, points: int, *, failed: int = 0, reason: str = ""
    ) -> None:
        """Keep the result of a job, with its number of points and of failed points."""
        if self._study is None or self._form is None:
            self._held[number] = result
        else:
            self._study.keep(Piece(number, points, failed, reason, self._form.pack(result)))
        self.done.add(number)
        self.points_done += points

    def hold(self, number: int, result: Result, points: int) -> None:
        """Keep the result of a job for this session only; the next session runs it again."""
        self._held[number] = result
        self.points_done += points

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
                    f"study {str(self.folder)!r} is damaged: {PIECES}/{number}: {error}"
                ) from error
            yield number, result


@contextmanager
def open_results(
    folder: Folder | None,
    design: Callable[[], Mapping[str, Any]],
    points: int,
    form: Form[Result],
) -> Iterator[Results[Result]]:
    """Collect results in the study in `folder`, as in `opened`, or in memory if it is None.

    Only a study has a design.
    """
    if folder is None:
        yield Results()
        return
    with opened(folder, design(), points) as study:
        yield Results(study, form)
