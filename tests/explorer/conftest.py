"""Processes that answer, and the program that serves them, each started once."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest
from selenium.webdriver.remote.webdriver import WebDriver
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from rotor_ida.explorer.messages import Question
from rotor_ida.explorer.queues import Queues
from tests.explorer.asking import SLOW, Message, question, unpacked
from tests.explorer.browser import Page, chromium_in, ended, errors_of
from tests.explorer.browser import served as served_alone


@pytest.fixture(scope="session")
def chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WebDriver]:
    """Return the browser in which all pages are shown, but those whose traffic is watched."""
    with chromium_in(tmp_path_factory.mktemp("downloads")) as driver:
        yield driver


# How long to wait for what must come: minutes, on a machine that does much else.
PATIENCE = 200.0
MAIN = "import sys; from rotor_ida.cli import main; sys.exit(main())"
RUNNING = ["--omega=2", "--zeta=0.07", "--delta0=2"]
PROGRAM = [sys.executable, "-W", "error", "-c", MAIN, "explore", "--no-browser", "--port", "0"]


def wait_until(true: Callable[[], bool], what: str) -> None:
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, f"waited in vain for {what}"
        time.sleep(0.01)


class Answering:
    """Queues in a loop of their own, asked from the tests, and what has come of each question."""

    def __init__(self) -> None:
        self.loop = asyncio.new_event_loop()
        self.got: dict[int, list[Message]] = {}
        self._thread = threading.Thread(target=self.loop.run_forever)
        self._thread.start()
        self.queues = self.call(Queues)

    def call(self, function: Callable[[], object]) -> object:
        async def called() -> object:
            return function()

        return asyncio.run_coroutine_threadsafe(called(), self.loop).result(PATIENCE)

    def open(self) -> None:
        opening = self.queues.open(lambda *_: None)
        asyncio.run_coroutine_threadsafe(opening, self.loop).result(PATIENCE)

    def close(self) -> None:
        try:
            asyncio.run_coroutine_threadsafe(self.queues.close(), self.loop).result(PATIENCE)
        finally:
            self.loop.call_soon_threadsafe(self.loop.stop)
            self._thread.join()
            self.loop.close()

    def ask(self, page: int, *questions: Question) -> None:
        took = self.got.setdefault(page, [])

        def ask_all() -> None:
            for each in questions:
                self.queues.ask(page, each, lambda answer: took.append(unpacked(answer)))

        self.call(ask_all)

    def parts(self, page: int, number: int) -> list[str]:
        """Return which parts have come of one question."""
        return [each.part for each in self.got.get(page, []) if each.header["number"] == number]

    def wait_for(self, page: int, number: int, part: str) -> Message:
        """Return the first such part of the answer to a question, once it is there."""
        wait_until(lambda: part in self.parts(page, number), f"{part} of {number} for page {page}")
        return next(
            each for each in self.got[page] if (each.part, each.header["number"]) == (part, number)
        )


@pytest.fixture(scope="module")
def once_ready() -> Iterator[Answering]:
    """Return queues; closed while they answer, they must leave no process and no thread."""
    threads = set(threading.enumerate())
    found = Answering()
    try:
        found.open()
        yield found
        found.ask(1, question("starts", number=1_000_000, machine=SLOW), question())
        found.wait_for(1, 1_000_000, "basin")
        pids = [each._worker._process.pid for each in found.queues._queues if each._worker]
        assert len(pids) == 3
    finally:
        found.close()
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    # up to Python 3.11 a thread waits for each process, and ends by itself a moment after it
    left = set(threading.enumerate()) - threads
    for thread in left:
        thread.join(10)
    assert not [thread for thread in left if thread.is_alive()]


@pytest.fixture
def answering(once_ready: Answering) -> Answering:
    """Return queues that nobody has asked anything."""
    for page in list(once_ready.got):
        once_ready.call(lambda page=page: once_ready.queues.forget(page))
    once_ready.got.clear()
    return once_ready


@dataclass
class Program:
    """The program, and what it has said."""

    process: subprocess.Popen[bytes]
    said: list[str] = field(default_factory=list)

    def listen(self) -> None:
        def read() -> None:
            assert self.process.stderr is not None
            with self.process.stderr:
                self.said.extend(line.decode() for line in self.process.stderr)

        self._reader = threading.Thread(target=read)
        self._reader.start()

    @property
    def address(self) -> str:
        return next((line.split()[-1] for line in self.said if "http://" in line), "")

    @property
    def port(self) -> int:
        return urlsplit(self.address).port or 0

    @property
    def key(self) -> str:
        return parse_qs(urlsplit(self.address).fragment)["key"][0]

    @property
    def text(self) -> str:
        return "".join(self.said)

    def wait_until_ready(self) -> None:
        wait_until(
            lambda: bool(self.address) or self.process.poll() is not None, "a page that is served"
        )
        assert self.address, self.text

    def ended(self) -> int:
        """Wait for the end, and return its status."""
        status = self.process.wait(PATIENCE)
        self._reader.join(PATIENCE)
        return status

    def children(self) -> list[int]:
        """Return the processes that it has started."""
        found = []
        for place in Path("/proc").glob("[0-9]*/stat"):
            try:
                parent = int(place.read_text().rpartition(")")[2].split()[1])
            except OSError:
                continue
            if parent == self.process.pid:
                found.append(int(place.parent.name))
        return found

    def talk(self) -> ClientConnection:
        """Open a connection as the page does."""
        host, words = f"127.0.0.1:{self.port}", [Subprotocol(f"rotor-ida.{self.key}")]
        return connect(
            f"ws://{host}/ask", origin=Origin(f"http://{host}"), subprotocols=words, proxy=None,
            max_size=None, compression=None, open_timeout=PATIENCE,
        )  # fmt: skip


@pytest.fixture
def start() -> Iterator[Callable[..., Program]]:
    """Return what starts programs, as users do; those that have not ended by then are killed."""
    programs: list[Program] = []

    def begin(*words: str) -> Program:
        process = subprocess.Popen(
            [*PROGRAM, *words], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            start_new_session=True,
        )  # fmt: skip
        programs.append(Program(process))
        programs[-1].listen()
        return programs[-1]

    yield begin
    for each in programs:
        each.process.kill()
        each.ended()


@pytest.fixture(scope="session")
def address(chromium: WebDriver) -> Iterator[str]:
    """Return the address of a program that serves all pages of one disc."""
    process, found = served_alone(*RUNNING)
    yield found
    chromium.get("about:blank")  # its page would note that the program is gone
    ended(process)
    assert process.returncode == 0


@pytest.fixture
def page(chromium: WebDriver, address: str) -> Iterator[Page]:
    """The page in its first state; whatever is done to it, its console stays without an error."""
    yield Page(chromium, address, anew=False)
    assert errors_of(chromium) == []


@pytest.fixture
def whole(chromium: WebDriver, address: str) -> Iterator[Page]:
    """The same, with the basin."""
    yield Page(chromium, address, anew=False, basin=True)
    assert errors_of(chromium) == []


@pytest.fixture
def fresh(chromium: WebDriver, address: str) -> Iterator[Page]:
    """The page just loaded, of which nothing is left for the next test."""
    yield Page(chromium, address)
    assert errors_of(chromium) == []
    chromium.get("about:blank")
