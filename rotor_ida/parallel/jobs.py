"""Jobs, the functions that do them, and the result of a job that could not be done."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from rotor_ida.arrays import Stop

Job = TypeVar("Job")
Result = TypeVar("Result")
Work = Callable[[Job, Stop], Result]
Progress = Callable[[int, int], None]

# Jobs handed out for each worker: one in hand and one that waits.
IN_FLIGHT = 2


@dataclass(frozen=True, slots=True)
class FailedJob:
    """The result of a job whose workers died, and how they did."""

    reason: str
