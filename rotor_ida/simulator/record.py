"""The motion so far: where it stands, and all that has been seen on the way."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from rotor_ida.checks import State
from rotor_ida.model import turned
from rotor_ida.parameters import Rotor
from rotor_ida.simulator.options import Options
from rotor_ida.simulator.orbit import Orbit

Values = npt.NDArray[np.float64]


@dataclass(slots=True)
class Record:
    """A run in the making.

    `position` and `velocity` are complex and read on the rotating axes, as are all samples and
    event states until `orbit` turns them back.
    """

    rotor: Rotor
    options: Options
    duration: float
    slack: float
    sample_times: Values
    position: complex
    velocity: complex
    time: float = 0.0
    samples: list[Values] = field(default_factory=list)
    sampled: int = 0
    event_times: list[float] = field(default_factory=list)
    event_kinds: list[int] = field(default_factory=list)
    event_states: list[list[float]] = field(default_factory=list)
    contacts: list[list[float]] = field(default_factory=list)
    evaluations: int = 0

    def __post_init__(self) -> None:
        if self.sample_times.size and self.sample_times[0] == 0.0:
            self.take(np.array([self.state]))

    @property
    def state(self) -> list[float]:
        """``(x, y, vx, vy)`` now, on the rotating axes."""
        return [self.position.real, self.position.imag, self.velocity.real, self.velocity.imag]

    @property
    def left(self) -> float:
        """Time still to go."""
        return self.duration - self.time

    def waiting(self, span: float) -> Values:
        """Return the sample times of the next `span`, counted from now."""
        # time + left may fall short of the duration by rounding; its sample must not be lost.
        until = self.duration if span >= self.left else self.time + span
        last = int(np.searchsorted(self.sample_times, until, side="right"))
        return np.clip(self.sample_times[self.sampled : last] - self.time, 0.0, span)

    def take(self, rows: Values) -> None:
        """Add the next samples."""
        self.samples.append(rows)
        self.sampled += len(rows)

    def move(self, span: float, position: complex, velocity: complex) -> None:
        """Go on by `span` to a new position and velocity."""
        self.time = self.duration if span == self.left else self.time + span
        self.position, self.velocity = position, velocity

    def mark(self, kind: int) -> None:
        """Write down an event here and now."""
        self.event_times.append(self.time)
        self.event_kinds.append(kind)
        self.event_states.append(self.state)

    def add_contact(
        self,
        entry: float,
        leaving: float,
        peak_time: float,
        indentation: float,
        impulse: float,
        moment: float,
    ) -> None:
        """Write down a contact that is over, or that the run begins or ends in."""
        self.contacts.append([entry, leaving, peak_time, indentation, impulse, moment])

    def fixed_state(self) -> State:
        """Return ``(x, y, vx, vy)`` now, in the fixed frame."""
        x, y, vx, vy = turned(self.state, self.rotor.omega * self.time).tolist()
        return (x, y, vx, vy)

    def orbit(self, *, starts_in_contact: bool) -> Orbit:
        """Return the finished run, in the fixed frame."""
        omega = self.rotor.omega
        samples = np.concatenate([*self.samples, np.empty((0, 4))])
        event_times = np.array(self.event_times)
        event_states = np.array(self.event_states).reshape(-1, 4)
        return Orbit(
            rotor=self.rotor,
            options=self.options,
            duration=self.duration,
            times=self.sample_times,
            states=turned(samples, omega * self.sample_times),
            starts_in_contact=starts_in_contact,
            event_times=event_times,
            event_kinds=np.array(self.event_kinds, dtype=np.int8),
            event_states=turned(event_states, omega * event_times),
            contacts=np.array(self.contacts).reshape(-1, 6),
            end=np.array(self.fixed_state()),
            evaluations=self.evaluations,
        )
