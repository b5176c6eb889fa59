"""How far a study is: points done, failed and left, and how long these will take."""

from __future__ import annotations

import math
import os

from rotor_ida.storage.studies.database import begun_with, check_folder, damaged, reading
from rotor_ida.storage.studies.lock import is_locked

# So many different reasons of failure are told.
MOST_REASONS = 10


def status(folder: str | os.PathLike[str]) -> dict[str, object]:
    """Return how far the study in a folder is, even while it is worked on.

    Parameters
    ----------
    folder : path-like
        The folder of a study that was begun.

    Returns
    -------
    dict
        ``kind``; the numbers of ``points``, and of those ``done``, ``failed`` and ``left``;
        ``running``, whether a process is at work on it; ``points_per_second`` in the last session
        and ``seconds_left`` at that rate (NaN where nothing is known); ``reasons``, why points
        failed, the first few different ones.

    Raises
    ------
    InputError
        If there is no study.
    ArchiveError
        If its file is damaged.
    """
    place = check_folder(folder)
    with reading(place) as connection:
        design, points = begun_with(connection, place)
        done, failed = connection.execute(
            "SELECT coalesce(sum(points), 0), coalesce(sum(failed), 0) FROM pieces"
        ).fetchone()
        reasons = connection.execute(
            "SELECT DISTINCT reason FROM pieces WHERE failed > 0 ORDER BY number LIMIT ?",
            (MOST_REASONS,),
        ).fetchall()
        session = connection.execute(
            "SELECT began, seen, points FROM sessions ORDER BY rowid DESC LIMIT 1"
        ).fetchone()
    if not (isinstance(done, int) and isinstance(failed, int)):
        raise damaged(place, "the number of points of a piece")
    rate = _rate(session)
    return {
        "kind": design.get("kind", ""),
        "points": points,
        "done": done,
        "failed": failed,
        "left": points - done,
        "running": is_locked(place),
        "points_per_second": rate,
        "seconds_left": (points - done) / rate if rate > 0.0 else math.nan,
        "reasons": [str(reason) for (reason,) in reasons],
    }


def _rate(session: tuple[object, ...] | None) -> float:
    if session is None:
        return math.nan
    began, seen, points = (each if isinstance(each, (int, float)) else 0 for each in session)
    return points / (seen - began) if seen > began else math.nan
