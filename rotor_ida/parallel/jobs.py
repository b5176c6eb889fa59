"""Jobs, the functions that run them, and the result of a failed job."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from rotor_ida.arrays import Stop

Job = TypeVar("Job")
Result = TypeVar("Result")
Work = Callable[[Job, Stop], Result]
Progress = Callable[[int, int], None]

# Jobs submitted per worker: one that runs and one that waits.
IN_FLIGHT = 2


@dataclass(frozen=True, slots=True)
class FailedJob:
    """The result of a job whose workers died, with the reason."""

    reason: str
