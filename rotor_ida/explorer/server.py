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
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import h11
import uvicorn
from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.protocol import State

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
# Bytes of answers waiting to be read by a page.
MOST_UNREAD = 2**25
# Connections that have not shown the key, how long each may take [s], and how many are accepted at
# a time: few, so that each is read before newer ones displace it; and the number that may wait.
MOST_VISITS = 64
LONGEST_VISIT = 20.0
MOST_AT_ONCE = MOST_VISITS // 4
MOST_WAITING = 1024
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
        if not _is_here(request):
            return PlainTextResponse("only the page of this machine is served here", 403)
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
    return Starlette(routes=routes)


def _is_here(asking: HTTPConnection) -> bool:
    """Return whether this machine is asked by its own name, at any port."""
    return asking.headers.get("host", "").partition(":")[0] in HOSTS


def _may_ask(socket: WebSocket, key: str) -> bool:
    """Return whether a page of this host shows the key."""
    offered = f"{PROTOCOL}.{key}".encode()
    words = [word.encode("utf-8", "replace") for word in socket.scope["subprotocols"]]
    host, origin = (socket.headers.get(name, "") for name in ("host", "origin"))
    is_own = _is_here(socket) and origin in (f"http://{host}", f"https://{host}")
    return is_own and any(secrets.compare_digest(word, offered) for word in words)


async def _converse(
    socket: WebSocket, ask: Callable[[Asked, Deliver], None], file: Path | None,
    reading: Mapping[str, Any] | None,
) -> None:  # fmt: skip
    """Accept the questions of a page and send the answers, until it disconnects."""
    unread, held = asyncio.Queue[bytes](), 0

    def deliver(answer: bytes) -> None:
        nonlocal held
        if held > MOST_UNREAD:  # the page does not read
            sending.cancel()
            socket.state.abort()
        held += len(answer)
        unread.put_nowait(answer)

    async def send() -> None:
        nonlocal held
        with suppress(WebSocketDisconnect):
            while True:
                answer = await unread.get()
                await socket.send_bytes(answer)
                held -= len(answer)

    sending = asyncio.create_task(send())
    with closing(Inbox(ask, deliver, file, reading)) as inbox:
        try:
            while (message := await socket.receive())["type"] != "websocket.disconnect":
                try:
                    inbox.take(message.get("text") or "", message.get("bytes"))
                except InputError as error:
                    deliver(packed(Answer("mistake", {"message": str(error)})))
                except OSError as error:
                    told = f"the file cannot be stored: {error.strerror}"
                    deliver(packed(Answer("mistake", {"message": told})))
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
        self._sent = Path(mkdtemp(prefix="rotor-ida-"), name)
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
        for path in (self._sent, self._system):
            self._remove(path)

    def _remove(self, path: Path | None) -> None:
        """Remove a file that the page has sent."""
        if path is not None and path != self._given:
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


class _Talk(WebSocketsSansIOProtocol):
    """A connection for questions; it ends even if the page stops reading."""

    since = 0.0

    async def run_asgi(self) -> None:
        self.scope["state"]["abort"] = self.transport.abort
        await super().run_asgi()

    def keepalive_timeout(self) -> None:
        super().keepalive_timeout()
        self.transport.abort()


class _Visit(H11Protocol):
    """A connection that fetches files; number and duration are limited until the key is shown."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self.since = self.loop.time()
        self.loop.call_later(LONGEST_VISIT, _end_unless_open, transport)
        visits = [
            each for each in self.connections
            if isinstance(each, _Visit | _Talk) and not _is_open(each)
        ]  # fmt: skip
        for each in sorted(visits, key=lambda each: each.since)[:-MOST_VISITS]:
            each.transport.abort()  # the oldest, whatever they have asked or read

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        # Cookies belong to other programs on this machine, and may be longer than it takes.
        self.headers = [(name, value) for name, value in self.headers if name != b"cookie"]
        super().handle_websocket_upgrade(event)
        talk = self.transport.get_protocol()
        assert isinstance(talk, _Talk)
        talk.since = self.since
        if talk.conn.handshake_exc is not None:  # uvicorn sends no answer to excessive headers
            self.transport.write(b"".join(talk.conn.data_to_send()))
            self.transport.close()


def _is_open(connection: object) -> bool:
    """Return whether a connection is of a page that has shown the key."""
    return isinstance(connection, _Talk) and connection.conn.state is State.OPEN


def _end_unless_open(transport: asyncio.Transport) -> None:
    if not _is_open(transport.get_protocol()):
        transport.abort()


class Server(uvicorn.Server):
    """A server that leaves signal handling to its owner."""

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Start serving; more connections may wait than are accepted at a time."""
        await super().startup(sockets)
        for each in sockets or []:
            each.listen(MOST_WAITING)

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave signal handlers unchanged."""
        yield


def server_of(app: ASGIApp) -> Server:
    """Return a server of an application."""
    return Server(uvicorn.Config(
        app, http=_Visit, ws=_Talk, lifespan="off", log_config=None,
        log_level="critical", access_log=False, server_header=False, date_header=False,
        ws_max_size=LARGEST_MESSAGE, ws_per_message_deflate=False,
        h11_max_incomplete_event_size=LARGEST_HEADERS, backlog=MOST_AT_ONCE,
        timeout_graceful_shutdown=1,
    ))  # fmt: skip
