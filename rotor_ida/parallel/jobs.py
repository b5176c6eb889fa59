"""Jobs, the functions that do them, and the result of a job that could not be done."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import numpy.typing as npt

Job = TypeVar("Job")
Result = TypeVar("Result")
Stop = npt.NDArray[np.uint8]
Work = Callable[[Job, Stop], Result]
Progress = Callable[[int, int], None]

# Jobs handed out for each worker: one in hand and one that waits.
IN_FLIGHT = 2


@dataclass(frozen=True, slots=True)
class FailedJob:
    """The result of a job whose workers died.

    Parameters
    ----------
    reason : str
        How they died.
    """

    reason: str
