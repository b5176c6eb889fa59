"""Jobs, the functions that run them, and the result of a failed job."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import ParamSpec, TypeVar

from rotor_ida.arrays import Stop

Job = TypeVar("Job")
Result = TypeVar("Result")
Work = Callable[[Job, Stop], Result]
Progress = Callable[[int, int], None]
Given = ParamSpec("Given")

# Jobs submitted per worker: one that runs and one that waits.
IN_FLIGHT = 2


@dataclass(frozen=True, slots=True)
class FailedJob:
    """The result of a job whose workers died, with the reason."""

    reason: str


def shows_progress(verb: Callable[Given, Result]) -> Callable[Given, Result]:
    """Return a function that shows a bar on standard error where its ``progress`` is True."""

    @wraps(verb)
    def shown(*given: Given.args, **options: Given.kwargs) -> Result:
        if options.get("progress") is not True:
            return verb(*given, **options)
        from rotor_ida.parallel.progress import progress_bar  # noqa: PLC0415 - loads rich

        with progress_bar(verb.__name__) as bar:
            options["progress"] = bar
            return verb(*given, **options)

    return shown
