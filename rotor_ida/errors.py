"""The exceptions of the package, each with a one-line message that shows how to proceed."""

from __future__ import annotations

import math

from rotor_ida.texts import printable


class RotorError(Exception):
    """Base of every error that this package raises on purpose.

    Names of files in a message may have characters that a terminal obeys: they are shown instead.
    """

    def __init__(self, *told: object) -> None:
        super().__init__(*(printable(each) if isinstance(each, str) else each for each in told))


class InputError(RotorError, ValueError):
    """A value that cannot be used: the message gives its name, the value and what is allowed."""


class MissingFileError(InputError, FileNotFoundError):
    """A file or study to read that does not exist."""


class SimulationError(RotorError, RuntimeError):
    """An integration that failed, with time and state of the failure.

    Parameters
    ----------
    message : str
        What happened, in the solver's or the invariant's own words.
    time : float
        Dimensionless time [1] of the last good state; NaN where a worker process died with it.
    state : tuple of float
        The state ``(x, y, vx, vy)`` [1] at that time.
    """

    def __init__(
        self,
        message: str,
        *,
        time: float = math.nan,
        state: tuple[float, float, float, float] = (math.nan,) * 4,
    ):
        shown = ", ".join(f"{value:.17g}" for value in state)
        place = f" (at t = {time:.17g}, state (x, y, vx, vy) = ({shown}))"
        super().__init__(message if math.isnan(time) else message + place)
        self.reason = message
        self.time = time
        self.state = state

    def __reduce__(self) -> tuple[object, ...]:
        """Keep time and state when the error crosses a process boundary."""
        return _rebuild_simulation_error, (type(self), self.reason, self.time, self.state)


class InvariantError(SimulationError):
    """A result that contradicts the mechanics, raised instead of returned."""


class BudgetError(SimulationError):
    """A simulation that takes more steps than its caller allows."""


class ArchiveError(RotorError, OSError):
    """A file that cannot be read or written as an archive of this package."""


class InstallationError(RotorError, ImportError):
    """A broken installation: the message gives the fault and the command that repairs it."""


def _rebuild_simulation_error(
    kind: type[SimulationError],
    message: str,
    time: float,
    state: tuple[float, float, float, float],
) -> SimulationError:
    return kind(message, time=time, state=state)
