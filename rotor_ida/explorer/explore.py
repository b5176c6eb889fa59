"""Serve the explorer: start the processes, serve the page on this machine, and end on request."""

from __future__ import annotations

import asyncio
import os
import secrets
import signal
import socket
import sys
import threading
import webbrowser
from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import closing, contextmanager, nullcontext
from html import escape
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any
from urllib.parse import urlencode

from rotor_ida.checks import check_count
from rotor_ida.errors import InputError
from rotor_ida.explorer.queues import Queues
from rotor_ida.explorer.server import application, server_of
from rotor_ida.parallel.progress import progress_bar

LOOPBACK = "127.0.0.1"
LARGEST_PORT = 65_535
# Signals that end the program, where a platform has them.
ENDS = [each for each in signal.Signals if each.name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")]
# A page that redirects to an address without a referrer.
LEADING_ON = """\
<!DOCTYPE html>
<html lang="en">
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={address}">
<title>rotor-ida explore</title>
<p><a href="{address}">The explorer</a></p>
</html>
"""


def explore(
    state: Mapping[str, object],
    *,
    port: int,
    browser: bool,
    report: Callable[[str], None],
    file: Path | None,
    reading: Mapping[str, Any],
) -> None:
    """Serve the explorer on this machine until it is interrupted.

    Parameters
    ----------
    state : mapping
        Initial state of the page, as in its address.
    port : int
        Port on the loopback address; 0 takes any free one.
    browser : bool
        Whether to open the page in a browser.
    report : callable
        Called with messages for the user: the address, once the page can be opened.
    file : Path, optional
        File of a rotor system or of a measurement, which the page may ask for.
    reading : mapping
        Arguments of `rotor_ida.read_signals` for the latter.

    Raises
    ------
    InputError
        If the port cannot be used.
    RotorError
        If the worker processes do not start.
    """
    key = secrets.token_hex(16)
    with closing(_listen(port)) as listening:
        told = urlencode({**state, "key": key})
        address = f"http://{LOOPBACK}:{listening.getsockname()[1]}/#{told}"

        async def serve(queues: Queues, stop: asyncio.Event) -> None:
            server = server_of(application(queues, key, file, reading))
            serving = asyncio.create_task(server.serve([listening]))
            report(f"The explorer is at {address}")
            with _open_in_a_browser(address) if browser and can_show_a_page() else nullcontext():
                report("Ctrl-C ends it.")
                await _first(stop.wait(), serving)
            server.should_exit = True
            await serving

        asyncio.run(_with_queues(serve))


def _listen(port: int) -> socket.socket:
    """Return a socket on the port, or raise an error if it is taken."""
    number = check_count("port", port, 0, LARGEST_PORT)
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if os.name == "posix":  # elsewhere it would let two programs share a port
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((LOOPBACK, number))
        listening.listen()
    except OSError as error:
        listening.close()
        raise InputError(
            f"port {number} cannot be used: {error.strerror}; give another with --port"
        ) from error
    return listening


async def _with_queues(serve: Callable[[Queues, asyncio.Event], Awaitable[None]]) -> None:
    """Start the processes, serve the page until the program is to end, and end them."""
    stop = asyncio.Event()
    _heed_signals(stop)
    queues = Queues()
    try:
        with progress_bar("starting") as bar:
            opening = asyncio.create_task(queues.open(bar))
            await _first(opening, stop.wait())
        if not stop.is_set():
            await opening
            await serve(queues, stop)
    finally:
        await queues.close()


def _heed_signals(stop: asyncio.Event) -> None:
    """Set an event when the user or the system ends the program."""
    loop = asyncio.get_running_loop()
    for each in ENDS:
        if each.name == "SIGHUP" and signal.getsignal(each) == signal.SIG_IGN:  # nohup ignores it
            continue
        if sys.platform == "win32":
            signal.signal(each, lambda *_: loop.call_soon_threadsafe(stop.set))
        else:
            loop.add_signal_handler(each, stop.set)


@contextmanager
def _open_in_a_browser(address: str) -> Iterator[None]:
    """Open an address through a temporary file.

    Any user can list command-line arguments, but only the owner can read the file, which is removed
    on exit.
    """
    with NamedTemporaryFile("w", prefix="rotor-ida-", suffix=".html", encoding="utf-8") as file:
        file.write(LEADING_ON.format(address=escape(address)))
        file.flush()
        place = Path(file.name).as_uri()
        # some browsers block until they end
        threading.Thread(target=webbrowser.open, args=(place,), daemon=True).start()
        yield


async def _first(*awaited: Awaitable[object]) -> None:
    """Wait for the first of several things; a task among them goes on."""
    waiting = {asyncio.ensure_future(each) for each in awaited}
    await asyncio.wait(waiting, return_when=asyncio.FIRST_COMPLETED)
    for each in waiting.difference(awaited):
        each.cancel()


def can_show_a_page() -> bool:
    """Return whether a browser can open a window; a text browser would take over the terminal."""
    windows = any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
    return windows or not sys.platform.startswith("linux")
