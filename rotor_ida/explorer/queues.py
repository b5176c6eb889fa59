"""Queues of questions for the worker processes: only the newest question of each page waits."""

from __future__ import annotations

import asyncio
import pickle
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from itertools import count
from typing import NamedTuple

from rotor_ida.errors import RotorError
from rotor_ida.explorer.messages import FILES, Answer, Asked, packed
from rotor_ida.explorer.workers import (
    FIRST_BEYOND,
    LENGTH,
    SHOWN_BY,
    Order,
    example,
)
from rotor_ida.parallel import Progress

Deliver = Callable[[bytes], None]
# Origin of a question: a page, and the panels of one of its rotors.
Place = tuple[int, str, int]

# Seconds after which a process that does not cancel an answer is ended.
DEAF = 5.0
# Seconds after which a process that ended unexpectedly is restarted.
AGAIN = 0.5
# Bytes of an answer read at a time.
AT_A_TIME = 2**20
# Keeps Ctrl-C of the console from a process on Windows, as a new session does elsewhere.
NEW_GROUP: int = getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0)
DIED = "The process that computes this ended unexpectedly; it is being restarted."


class Plan(NamedTuple):
    """What a queue answers, and when.

    Parameters
    ----------
    abouts : tuple of str
        Kinds of question that it answers.
    pause : float
        Time without a newer question from the same origin before a question is begun [s].
    patience : float
        An answer is cancelled for a newer question only after one part, or this long after its
        start [s]; so a slider in motion still shows results.
    rest : float
        Delay from the start of an answer to the parts after the first [s]: while a slider moves,
        newer questions matter more.
    niceness : int
        Niceness of the process, as for `os.nice`.
    """

    abouts: tuple[str, ...] = ()
    pause: float = 0.0
    patience: float = 0.25
    rest: float = 0.0
    niceness: int = 0


PLANS = (
    Plan(("motion", "run_up", "lines", "track", "machine")),
    Plan(("responses", "campbell", "upload", *FILES), rest=0.15),
    Plan(("starts",), pause=0.08, patience=0.0, niceness=10),
)


class Queues:
    """All queues: one for each kind of question, so that none waits for another."""

    def __init__(self) -> None:
        self._queues = [Queue(plan) for plan in PLANS]
        self._running: list[asyncio.Task[None]] = []

    async def open(self, progress: Progress) -> None:
        """Start the processes and wait until they are ready; `RotorError` if one cannot start."""
        self._running = [asyncio.create_task(queue.run()) for queue in self._queues]
        starting = asyncio.as_completed([queue.ready for queue in self._queues])
        for done, ready in enumerate(starting, start=1):
            if not await ready:
                raise RotorError("the processes that compute the panels do not start")
            progress(done, len(self._queues))

    async def close(self) -> None:
        """End the processes."""
        for task in self._running:
            task.cancel()
        await asyncio.gather(*self._running, return_exceptions=True)

    def ask(self, page: int, question: Asked, deliver: Deliver) -> None:
        """Add a question to the queue that answers it."""
        queue = next(queue for queue in self._queues if question.about in queue.plan.abouts)
        queue.ask(page, question, deliver)

    def forget(self, page: int) -> None:
        """Cancel all questions of a page."""
        for queue in self._queues:
            queue.forget(page)


@dataclass(slots=True, eq=False)
class _Pending:
    """A question with its origin and time; once begun, the number of its answer."""

    place: Place
    question: Asked
    deliver: Deliver
    since: float
    number: int | None = None
    begun: float = 0.0
    shown: bool = False  # whether a part of its answer has been sent


class Queue:
    """One process, and the questions that wait for it.

    Answers in progress get one part each in turn, so that two rotors side by side become finer
    together.

    Parameters
    ----------
    plan : Plan
        What it answers, and when.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.ready: asyncio.Future[bool] = asyncio.get_running_loop().create_future()
        self._numbers = count(1)
        self._waiting: dict[Place, _Pending] = {}
        self._begun: dict[Place, _Pending] = {}
        self._at: _Pending | None = None
        self._changed = asyncio.Event()
        self._worker: _Worker | None = None

    def ask(self, page: int, question: Asked, deliver: Deliver) -> None:
        """Add a question, in place of an older one from the same origin."""
        loop = asyncio.get_running_loop()
        place = (page, question.about, question.side)
        older, begun = self._waiting.get(place), self._begun.get(place)
        self._waiting[place] = _Pending(place, question, deliver, loop.time())
        self._changed.set()
        if begun is not None and begun.shown:
            self._give_up(begun)
        elif begun is not None and older is None:
            loop.call_at(begun.begun + self.plan.patience, self._give_up, begun)

    def forget(self, page: int) -> None:
        """Cancel all questions of a page."""
        for place in [place for place in self._waiting if place[0] == page]:
            del self._waiting[place]
        for pending in [pending for place, pending in self._begun.items() if place[0] == page]:
            self._give_up(pending)

    async def run(self) -> None:
        """Keep a process running, and send it one order after another."""
        while True:
            with suppress(EOFError, OSError):
                await self._work()
            if not self.ready.done():
                self.ready.set_result(False)
                return
            self._begin_again()
            await asyncio.sleep(AGAIN)

    async def _work(self) -> None:
        """Start a process and keep it busy, until it ends."""
        worker = self._worker = await _Worker.begin(self.plan.niceness)
        try:
            await self._make_ready(worker)
            await self._answer_all(worker)
        finally:
            self._worker = None
            await worker.end()

    async def _make_ready(self, worker: _Worker) -> None:
        """Have the process answer once, so that its imports are done."""
        for about in set(self.plan.abouts).intersection(SHOWN_BY):
            for beyond in ({}, FIRST_BEYOND):
                number = next(self._numbers)
                await worker.follow((number, example(about, **beyond)))
                worker.tell((number, "drop"))
        if not self.ready.done():
            self.ready.set_result(True)

    async def _answer_all(self, worker: _Worker) -> None:
        while True:
            pending = self._at = await self._next(worker)
            if pending.number is None:
                pending.number = next(self._numbers)
                pending.begun = asyncio.get_running_loop().time()
                part = await worker.follow((pending.number, pending.question))
            else:
                part = await worker.follow((pending.number, "next"))
            self._at = None
            if self._begun.get(pending.place) is not pending:
                continue  # it was cancelled
            if not part:
                del self._begun[pending.place]
                continue
            pending.deliver(part)
            pending.shown = True
            if pending.place in self._waiting:
                self._give_up(pending)

    async def _next(self, worker: _Worker) -> _Pending:
        """Wait for work: begin a waiting question, or continue an answer in turn."""
        while True:
            self._changed.clear()
            if worker.has_ended:
                raise EOFError
            now = asyncio.get_running_loop().time()
            free = [pending for place, pending in self._waiting.items() if place not in self._begun]
            due = [pending for pending in free if now >= pending.since + self.plan.pause]
            open_ = {
                pending: pending.begun + self.plan.rest * pending.shown
                for pending in self._begun.values()
            }
            ready = due or [pending for pending, when in open_.items() if now >= when]
            if ready:
                pending = ready[0]
                if due:
                    del self._waiting[pending.place]
                self._begun.pop(pending.place, None)
                self._begun[pending.place] = pending  # it is now the last in turn
                return pending
            times = [*open_.values(), *(pending.since + self.plan.pause for pending in free)]
            with suppress(TimeoutError):
                wait = min(times) - now if times else None
                await asyncio.wait_for(self._changed.wait(), wait)

    def _give_up(self, pending: _Pending) -> None:
        """Cancel an answer that is not complete."""
        if self._begun.get(pending.place) is not pending:
            return
        if pending.question.about in FILES:
            pending.deliver = _nowhere  # drawing is not interrupted: it imports modules as it goes
            return
        del self._begun[pending.place]
        self._changed.set()
        if self._worker is not None and pending.number is not None:
            self._worker.tell((pending.number, "drop"))
            asyncio.get_running_loop().call_later(DEAF, self._end_if_deaf, pending, self._worker)

    def _end_if_deaf(self, pending: _Pending, worker: _Worker) -> None:
        if self._at is pending:
            worker.kill()

    def _begin_again(self) -> None:
        """Report the loss of the current answer when the process ended; restart the others."""
        begun, self._begun = self._begun, {}
        at, self._at = self._at, None
        for place, pending in begun.items():
            if pending is at:
                question, trouble = pending.question, Answer("trouble", {"message": DIED})
                pending.deliver(packed(trouble, question.ticket))
            elif place not in self._waiting:
                pending.number, pending.shown = None, False
                self._waiting[place] = pending


def _nowhere(_answer: bytes) -> None:
    """Read and discard an answer that nobody waits for."""


class _Worker:
    """A worker process and the pipes to it."""

    def __init__(self, process: asyncio.subprocess.Process) -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        self._process = process
        self._orders = process.stdin
        self._answers = process.stdout

    @classmethod
    async def begin(cls, niceness: int) -> _Worker:
        """Start a process with the same module path, protected from Ctrl-C in the terminal."""
        lines = (
            f"import sys; sys.path[:] = {sys.path!r}; "
            f"from rotor_ida.explorer.workers import work; work({niceness})"
        )
        process = await asyncio.create_subprocess_exec(
            sys.executable, "-c", lines, limit=AT_A_TIME, start_new_session=True,
            creationflags=NEW_GROUP, stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
        )  # fmt: skip
        return cls(process)

    @property
    def has_ended(self) -> bool:
        """Whether the process has ended."""
        return self._answers.at_eof()

    def tell(self, order: Order) -> None:
        """Send an order; if the process has ended it is lost, which its answer reports."""
        self._orders.write(pickle.dumps(order))

    async def follow(self, order: Order) -> bytes:
        """Send an order and return the resulting part; it is empty at the end of the answer."""
        self.tell(order)
        length = int.from_bytes(await self._answers.readexactly(LENGTH), "little")
        return await self._answers.readexactly(length)

    def kill(self) -> None:
        """End the process."""
        with suppress(ProcessLookupError):
            self._process.kill()

    async def end(self) -> None:
        """End the process, and wait until it is gone."""
        self.kill()
        self._orders.close()
        await self._answers.read()
        await self._process.wait()
