"""A question of one motion, asked at each point of a `Varied`, with labelled answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from rotor_ida.arrays import Stop
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, Workers
from rotor_ida.results.question import Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.steady.grid import (
    Answer,
    Answers,
    check_size,
    labelled_points,
    run_study,
)
from rotor_ida.steady.ramps import Ramps

Point = TypeVar("Point")
Work = Callable[[Point, Stop], Mapping[str, Any]]


def answers_at_each(
    varied: Varied,
    point_at: Callable[[Sequence[int]], Point],
    work: Work[Point],
    columns: Mapping[str, tuple[str, int] | None],
    question: Question,
    *,
    whole: Mapping[str, Any] = {},
    workers: Workers,
    study: Folder | None = None,
    progress: Progress | None = None,
) -> dict[str, xr.Variable]:
    """Return the answers of a function of one rotor at each point, as variables.

    Parameters
    ----------
    varied : Varied
        The points.
    point_at : callable
        Returns the rotor at a place.
    work : callable
        Returns the numbers of a rotor by the names of the columns; see `Answers`.
    columns : mapping of str to (str, int) or None
        For each column the dimension behind those of the points, and its size; None where there
        is one number at each point.
    question : Question
        What determines the bits: the key of a study.
    whole : mapping of str to ndarray
        Of columns of whole numbers, those of a point that fails, of the type of all.
    workers, study, progress
        As in `rotor_ida.steady.grid.run_study`.

    Returns
    -------
    dict of str to Variable
        The columns, and ``status`` and ``message``: a point that fails does not raise, and its
        numbers are NaN, or those of `whole`.
    """
    check_size(varied, study)
    kind = np.dtype([
        ("status", np.int8),
        *((name, np.asarray(whole.get(name, math.nan)).dtype, () if each is None else each[1:])
          for name, each in columns.items()),
    ])  # fmt: skip
    answers: Answers[Point, None] = Answers(partial(_answer, work), kind, whole=whole)
    found = run_study(
        Ramps(varied, (None,), answers, point_at), question, word="answers at points",
        study=study, workers=workers, progress=progress,
    ).points  # fmt: skip
    behind = {name: each[:1] for name, each in columns.items() if each is not None}
    return labelled_points(varied, found, behind)


def _answer(work: Work[Point], point: Point, _start: None, stop: Stop) -> Answer:
    return Answer(work(point, stop))
