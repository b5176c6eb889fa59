"""What a page does: it asks, and unpacks what comes back."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from rotor_ida.explorer.messages import Question, read_question
from rotor_ida.explorer.workers import Asked, Desk

# What the page shows first.
ROTOR = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
# The same rotor in SI units.
MACHINE = {
    "mass": 4.0, "contact_stiffness": 1e9, "damping": 280.0, "eccentricity": 1e-6,
    "clearance": 2e-6, "speed": 1000.0,
}  # fmt: skip
# What a machine has beside the paper's rotor, without dimensions and in SI units.
BEYOND = {
    "shaft_stiffness": 0.25, "contact_exponent": 1.0, "contact_damping": 1.5, "load": 0.5,
}  # fmt: skip
BEYOND_IN_SI = {
    "contact_stiffness": 1e6, "shaft_stiffness": 2.5e5, "contact_exponent": 1.0,
    "contact_damping": 3e3, "load": 0.5,
}  # fmt: skip
# Friction; and with it a machine that settles on dry whip.
RUB = {"friction": 0.2, "disc_radius": 10.0}
RUB_IN_SI = {"friction": 0.2, "disc_radius": 1e-5}
WHIP = {"omega": 0.62962981, "zeta": 0.1, "delta0": 1.0, **RUB}
WHIPPED = (5.0, 0.0, 0.0, -6.3)
# Another, which slips in both senses and rolls.
CHATTER = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5, "friction": 0.3, "disc_radius": 0.6}
# Its basin takes minutes.
SLOW = {"omega": 1.38, "zeta": 0.07, "delta0": 1.0}
# What a page asks of a rotor system, whose file the program has.
OF_SYSTEM = {
    "about": "motion", "number": 1, "side": 0, "revolutions": 10,
    "machine": {"node": "", "contact": 0, "speed": None, "changes": {}},
}  # fmt: skip
KINDS = {"f8": "<f8", "f4": "<f4", "i1": "i1"}
HEADER = 4


def asked(about: str = "motion", **changes: object) -> dict[str, Any]:
    """Return a question as the page has it, right but for the changes."""
    return {
        "about": about, "number": 1, "side": 0, "machine": ROTOR, "start": [0, 0, 0, 0],
        "revolutions": 60, "speeds": [0.05, 3.0], "reach": 8.0,
    } | changes  # fmt: skip


def question(about: str = "motion", **changes: object) -> Question:
    found = read_question(json.dumps(asked(about, **changes)))
    assert isinstance(found, Question)
    return found


@dataclass(frozen=True)
class Message:
    """An answer as the page has it."""

    header: Mapping[str, Any]
    arrays: Mapping[str, npt.NDArray[Any]]

    @property
    def part(self) -> str:
        return str(self.header["part"])

    @property
    def facts(self) -> dict[str, Any]:
        return dict(self.header["facts"])


def unpacked(message: bytes) -> Message:
    """Return what is in a message; a browser would refuse arrays at odd places."""
    behind = HEADER + int.from_bytes(message[:HEADER], "little")
    header = json.loads(message[HEADER:behind])
    arrays = {}
    for name, (kind, offset, size) in header.pop("arrays").items():
        place, dtype = behind + offset, np.dtype(KINDS[kind])
        assert place % dtype.itemsize == 0
        arrays[name] = np.frombuffer(message, dtype, count=size, offset=place)
    return Message(header, arrays)


def parts_of_answer(asking: Asked, most: float = math.inf) -> list[bytes]:
    """Return the parts of an answer, computed in this process; what follows them is not."""
    desk, parts = Desk(), list[bytes]()
    desk.take((1, asking))
    while len(parts) < most and (part := desk.next_part()):
        parts.append(part)
        desk.take((1, "next"))
    return parts


def answer_to(asking: Asked, most: float = math.inf) -> list[Message]:
    return [unpacked(part) for part in parts_of_answer(asking, most)]


def first_part(asking: Question) -> Message:
    return answer_to(asking, 1)[0]
