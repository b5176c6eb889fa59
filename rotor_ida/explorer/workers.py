"""Worker process that answers questions part by part and can cancel an answer.

It reads orders in a separate thread, so that it notices a cancelled answer while it computes. It
then interrupts the current part as Ctrl-C does, which stops everything in this package.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from _thread import interrupt_main
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from queue import SimpleQueue
from types import FrameType
from typing import BinaryIO, Literal, cast

from rotor_ida.errors import RotorError
from rotor_ida.explorer.messages import Answer, Asked, Question, packed
from rotor_ida.model.rotor import Rotor

# Orders about a numbered answer: compute its first part, continue, or cancel it.
Order = tuple[int, Asked | Literal["next", "drop"]]

# Rotor of the warm-up question, before a page may connect, and parameters beyond the paper's.
FIRST_ROTOR = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
FIRST_BEYOND = {"shaft_stiffness": 0.25, "contact_exponent": 1.0, "contact_damping": 0.5}
# Modules with the function ``show_...`` for each question about a rotor.
SHOWN_BY = {
    "motion": "motion", "lines": "motion", "run_up": "run_ups", "track": "run_ups",
    "responses": "responses", "starts": "starts",
}  # fmt: skip
# And for the other questions; all else are files.
ELSE_SHOWN_BY = {"upload": "opening", "machine": "messages", "campbell": "whirls"}
# Bytes of the length of an answer, little-endian.
LENGTH = 4


def work(niceness: int) -> None:
    """Follow the orders on standard input; to each but `drop` write one packed answer.

    The answer is empty when there are no more parts. The process has the given niceness (`os.nice`)
    and ends with its standard input.
    """
    if hasattr(os, "nice"):
        os.nice(niceness)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # everything else that is printed goes elsewhere
    desk = Desk()
    signal.signal(signal.SIGINT, desk.break_off)
    sys.unraisablehook = _tell_unless_cancelled
    threading.Thread(target=_listen, args=(desk, sys.stdin.buffer), daemon=True).start()
    while True:
        part = desk.next_part()
        answers.write(len(part).to_bytes(LENGTH, "little") + part)
        answers.flush()


class Desk:
    """The answers in progress, and the one being computed."""

    def __init__(self) -> None:
        self._due: SimpleQueue[int] = SimpleQueue()
        self._begun: dict[int, Iterator[bytes]] = {}
        self._at: int | None = None  # the number of the part that may be interrupted

    def take(self, order: Order) -> None:
        """Accept an order; another thread computes."""
        number, what = order
        if what == "drop":
            if self._begun.pop(number, None) is not None:
                interrupt()
            return
        if isinstance(what, Asked):
            self._begun[number] = _parts(what)
        self._due.put(number)

    def next_part(self) -> bytes:
        """Wait for an order, and return the next part of the answer; nothing at its end."""
        number = self._due.get()
        part = b""
        try:
            self._at = number
            parts = self._begun.get(number)
            if parts is not None:
                part = next(parts, b"")
            self._at = None
        except KeyboardInterrupt:
            pass
        if not part:
            self._begun.pop(number, None)
        return part

    def break_off(self, _signal: int, _frame: FrameType | None) -> None:
        """Interrupt the current part if its answer is cancelled."""
        if self._at is not None and self._at not in self._begun:
            self._at = None
            raise KeyboardInterrupt


def interrupt() -> None:
    """Interrupt the main thread as Ctrl-C does."""
    if sys.platform == "win32":  # where it notices when it stops waiting for a moment
        interrupt_main()
    else:
        signal.pthread_kill(threading.main_thread().ident or 0, signal.SIGINT)


def _tell_unless_cancelled(lost: sys.UnraisableHookArgs) -> None:
    """Report what was raised where nothing can be, as when an object is deleted.

    An interrupt that is lost there is not: the queue ends a process that does not heed it.
    """
    if lost.exc_type is not KeyboardInterrupt:
        sys.__unraisablehook__(lost)


def _listen(desk: Desk, orders: BinaryIO) -> None:
    """Accept orders until standard input ends."""
    with suppress(EOFError, OSError, pickle.UnpicklingError):
        while True:
            desk.take(pickle.load(orders))
    os._exit(0)


def _parts(question: Asked) -> Iterator[bytes]:
    """Yield the parts of an answer; the last may be an error."""
    try:
        for answer in _show(question):
            yield packed(answer, question.ticket)
    except Exception as error:  # the process survives any error
        yield packed(Answer("trouble", {"message": _why(error)}), question.ticket)


def _why(error: Exception) -> str:
    """Return the reason for a missing answer in one line."""
    if isinstance(error, MemoryError):
        return "not enough memory"
    said = " ".join(str(error).split())
    return said if isinstance(error, RotorError) else f"{type(error).__name__}: {said}"


def _show(question: Asked) -> Iterator[Answer]:
    """Answer a question; each process imports only what it needs."""
    about = question.about
    module = (SHOWN_BY | ELSE_SHOWN_BY).get(about, "files")
    name = f"show_{'file' if module == 'files' else about}"
    show = getattr(import_module(f"rotor_ida.explorer.{module}"), name)
    return cast(Iterator[Answer], show(question))


def example(about: str, **beyond: float) -> Question:
    """Return a question about a rotor that starts from rest."""
    to, rate = (2.01, 0.01) if about == "run_up" else (None, None)
    return Question(
        about=about, number=0, machine=Rotor(**FIRST_ROTOR | beyond), speeds=(1.6, 2.1), reach=8.0,
        to=to, rate=rate,
    )  # fmt: skip
