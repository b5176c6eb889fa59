"""Server of the page, for the user of this machine alone.

Who asks must show the key that the program makes at each start and tells its user: other users of
the machine and pages of other sites do not have it. Host and origin must be those of the page, so
that a site whose name points to this machine gets nothing either.
"""

from __future__ import annotations

import asyncio
import re
import secrets
import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any

import h11
import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol

from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import (
    Answer,
    Asked,
    Question,
    Upload,
    packed,
    part_of,
    read_question,
)
from rotor_ida.explorer.page import TYPES, page_files
from rotor_ida.explorer.queues import Deliver, Queues

HOSTS = ["127.0.0.1", "localhost"]
# WebSocket protocol of a page; the text after the dot is its key.
PROTOCOL = "rotor-ida"
# Largest message and largest headers of a page [B]; files are sent in pieces.
LARGEST_MESSAGE = LARGEST_HEADERS = 65_536
# The part of an answer that says that a file is of a rotor system.
SYSTEM = "system"
# Characters kept of the name of a file.
LONGEST_STEM = 60
HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


def application(
    queues: Queues, key: str, file: Path | None = None, reading: Mapping[str, Any] | None = None
) -> ASGIApp:
    """Return the application that serves the pages, and answers to those with the key.

    `file` is that given to the command, of a rotor system or a measurement, and `reading` how the
    latter is read.
    """
    contents, numbers = page_files(), count(1)

    async def page(request: Request) -> Response:
        name = request.path_params.get("name") or "index.html"
        if name not in contents:
            return PlainTextResponse("not found", 404, headers=HEADERS)
        media_type = TYPES[name.rpartition(".")[2]]
        return Response(contents[name], media_type=media_type, headers=HEADERS)

    async def ask(socket: WebSocket) -> None:
        if not _may_ask(socket, key):
            await socket.close()  # refused before the connection is opened
            return
        number = next(numbers)
        await socket.accept(subprotocol=f"{PROTOCOL}.{key}")
        try:
            await _converse(socket, partial(queues.ask, number), file, reading)
        finally:
            queues.forget(number)

    routes = [
        Route("/", page), Route("/{name:path}", page), WebSocketRoute("/ask", ask),
    ]  # fmt: skip
    hosts = Middleware(TrustedHostMiddleware, allowed_hosts=HOSTS)
    return Starlette(routes=routes, middleware=[hosts])


def _may_ask(socket: WebSocket, key: str) -> bool:
    """Return whether a page of this host shows the key."""
    offered = f"{PROTOCOL}.{key}".encode()
    words = [word.encode("utf-8", "replace") for word in socket.scope["subprotocols"]]
    host, origin = (socket.headers.get(name, "") for name in ("host", "origin"))
    is_own = origin in (f"http://{host}", f"https://{host}")
    return is_own and any(secrets.compare_digest(word, offered) for word in words)


async def _converse(
    socket: WebSocket, ask: Callable[[Asked, Deliver], None], file: Path | None,
    reading: Mapping[str, Any] | None,
) -> None:  # fmt: skip
    """Accept the questions of a page and send the answers, until it disconnects."""
    unread = asyncio.Queue[bytes]()

    async def send() -> None:
        with suppress(WebSocketDisconnect):
            while True:
                await socket.send_bytes(await unread.get())

    sending = asyncio.create_task(send())
    with closing(Inbox(ask, unread.put_nowait, file, reading)) as inbox:
        try:
            while (message := await socket.receive())["type"] != "websocket.disconnect":
                try:
                    inbox.take(message.get("text") or "", message.get("bytes"))
                except InputError as error:
                    unread.put_nowait(packed(Answer("mistake", {"message": str(error)})))
        finally:
            sending.cancel()


class Inbox:
    """Input from a page: questions, and a file in pieces after its question.

    A file is kept in a temporary folder until it is read, that of a rotor system until the page
    sends another one that can be read, or disconnects.
    """

    def __init__(
        self, ask: Callable[[Asked, Deliver], None], deliver: Deliver, file: Path | None = None,
        reading: Mapping[str, Any] | None = None,
    ) -> None:  # fmt: skip
        self._ask = ask
        self._deliver = deliver
        self._given = self._system = file
        self._reading = reading or {}
        self._folder = TemporaryDirectory(prefix="rotor-ida-")
        self._coming: Upload | None = None
        self._sent: Path | None = None  # the newest file, until it has been read
        self._left = 0

    def take(self, text: str, piece: bytes | None) -> None:
        """Accept a message: a text, or a piece of a file in transfer."""
        if piece is not None and self._coming is not None:
            self._add(self._coming, piece)
            return
        question = read_question(text)
        if isinstance(question, Upload):
            self._begin(question)
            return
        if isinstance(question, Question) and question.machine is None:
            question = replace(question, path=self._system)
        self._ask(question, self._deliver)

    def _begin(self, upload: Upload) -> None:
        """Begin a file, in place of one that is in transfer or is read."""
        self._remove(self._sent)
        self._coming = self._sent = None
        if not upload.size and self._given is not None and upload.name == self._given.name:
            given = replace(upload, path=self._given, reading=self._reading)
            self._ask(given, self._deliver)
            return
        # its own name is in messages, and in the lines that compute a system again
        name = f"{safe_stem(upload.name)}{upload.ending}"
        self._sent = Path(mkdtemp(dir=self._folder.name), name)
        self._coming, self._left = replace(upload, path=self._sent), upload.size
        self._add(self._coming, b"")

    def _add(self, coming: Upload, piece: bytes) -> None:
        """Add a piece to the file; have it read when it is complete."""
        assert coming.path is not None
        if len(piece) > self._left:
            self._coming = None
            self._remove(coming.path)
            raise InputError(f"a file must have the {coming.size} bytes announced, got more")
        with coming.path.open("ab") as file:
            file.write(piece)
        self._left -= len(piece)
        if not self._left:
            self._coming = None
            self._ask(coming, partial(self._read, coming.path))

    def _read(self, path: Path, answer: bytes) -> None:
        """Keep a file if it is of a rotor system, and remove it otherwise."""
        if path != self._sent:
            return  # another file came meanwhile
        self._sent = None
        if part_of(answer) == SYSTEM:
            path, self._system = self._system or path, path
        if path != self._system:
            self._remove(path)
        self._deliver(answer)

    def close(self) -> None:
        """Remove the stored files."""
        self._folder.cleanup()

    def _remove(self, path: Path | None) -> None:
        """Remove a file that the page has sent."""
        if path is not None and path.is_relative_to(self._folder.name):
            shutil.rmtree(path.parent, ignore_errors=True)


def safe_stem(name: str) -> str:
    """Return the stem of a file name with nothing in it that leads elsewhere.

    Examples
    --------
    >>> safe_stem("../../my pump.toml")
    'my pump'
    """
    stem = Path(name.replace("\\", "/")).stem
    return re.sub(r"[^\w .-]", "_", stem)[:LONGEST_STEM].lstrip(".") or "file"


class _Visit(H11Protocol):
    """A connection whose websocket gets no cookies.

    They belong to other programs on this machine, and may be longer than it takes.
    """

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        self.headers = [(name, value) for name, value in self.headers if name != b"cookie"]
        super().handle_websocket_upgrade(event)


class Server(uvicorn.Server):
    """A server that leaves signal handling to its owner."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signal handlers unchanged."""
        yield


def server_of(app: ASGIApp) -> Server:
    """Return a server of an application."""
    return Server(uvicorn.Config(
        app, http=_Visit, ws="websockets-sansio", lifespan="off", log_config=None,
        log_level="critical", access_log=False, server_header=False, date_header=False,
        ws_max_size=LARGEST_MESSAGE, ws_per_message_deflate=False,
        h11_max_incomplete_event_size=LARGEST_HEADERS, timeout_graceful_shutdown=1,
    ))  # fmt: skip
