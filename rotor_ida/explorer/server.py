"""Server of the page: only for this machine, for a page with the key, and for small messages.

It refuses a host name other than this machine's (a foreign page may point its name here), an origin
other than the page's (a foreign page may send requests), a page without the key of this start, and
messages larger or more frequent than a page sends.
"""

from __future__ import annotations

import asyncio
import re
import secrets
import socket
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import h11
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame
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

HOSTS = ("127.0.0.1", "localhost", "[::1]")
# WebSocket protocol of a page; the text after the dot is its key.
PROTOCOL = "rotor-ida"
MOST_PAGES = 16
# Largest message in bytes; larger ones are not read.
LARGEST_MESSAGE = 65_536
MOST_FRAGMENTS = 1024
# The part of an answer that says that a file is of a rotor system.
SYSTEM = "system"
# Characters kept of the name of a file.
LONGEST_STEM = 60
# Bytes of answers waiting to be read by a page.
MOST_UNREAD = 2**25
# Connections that have not shown the key, and how long each may take, in seconds.
MOST_VISITS = 64
LONGEST_VISIT = 20.0
# Connections accepted at a time, few, so that each is read before newer ones displace it; and the
# number that may wait.
MOST_AT_ONCE = MOST_VISITS // 4
MOST_WAITING = 1024
# Bytes kept of an incomplete request.
LARGEST_HEADERS = 65_536
# Seconds for a page to close when it is dismissed.
GRACE = 1.0
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
# Close codes; the page explains them.
TOO_MANY_PAGES, TOO_SLOW = 4429, 4408


def application(
    queues: Queues, key: str, file: Path | None = None, reading: Mapping[str, Any] | None = None
) -> ASGIApp:
    """Return the application that serves the pages, and answers to those with the key.

    `file` is that given to the command, of a rotor system or a measurement, and `reading` how the
    latter is read.
    """
    contents, numbers, pages = page_files(), count(1), set[int]()

    async def page(request: Request) -> Response:
        name = request.path_params.get("name") or "index.html"
        if name not in contents:
            return PlainTextResponse("not found", 404, headers=HEADERS)
        media_type = TYPES[name.rpartition(".")[2]]
        return Response(contents[name], media_type=media_type, headers=HEADERS)

    async def ask(socket: WebSocket) -> None:
        offered = f"{PROTOCOL}.{key}"
        words = [word.encode("utf-8", "replace") for word in socket.scope["subprotocols"]]
        if not any(secrets.compare_digest(word, offered.encode()) for word in words):
            await socket.close()  # refused before the connection is opened
            return
        number = next(numbers)
        with suppress(WebSocketDisconnect):
            await socket.accept(subprotocol=offered)
            if len(pages) >= MOST_PAGES:
                await socket.close(TOO_MANY_PAGES)
                return
            pages.add(number)
            try:
                await _converse(
                    socket,
                    lambda deliver: Inbox(partial(queues.ask, number), deliver, file, reading),
                )
            finally:
                pages.discard(number)
                queues.forget(number)

    routes = [
        Route("/", page), Route("/{name:path}", page), WebSocketRoute("/ask", ask),
    ]  # fmt: skip
    return _only_from_here(Starlette(routes=routes))


async def _converse(
    socket: WebSocket, inbox_for: Callable[[Callable[[bytes], None]], Inbox]
) -> None:
    """Accept the questions of a page and send the answers, until it disconnects."""
    unread, held = asyncio.Queue[bytes](), 0

    def deliver(answer: bytes) -> None:
        nonlocal held
        held += len(answer)
        unread.put_nowait(answer)
        if held > MOST_UNREAD:
            sending.cancel()

    async def send() -> None:
        nonlocal held
        while True:
            answer = await unread.get()
            await socket.send_bytes(answer)
            held -= len(answer)

    async def take() -> None:
        with closing(inbox_for(deliver)) as inbox:
            while (message := await socket.receive())["type"] != "websocket.disconnect":
                try:
                    inbox.take(message.get("text") or "", message.get("bytes"))
                except InputError as error:
                    deliver(packed(Answer("mistake", {"message": str(error)})))

    sending, taking = asyncio.create_task(send()), asyncio.create_task(take())
    try:
        await asyncio.wait({sending, taking}, return_when=asyncio.FIRST_COMPLETED)
        slow = sending.cancelled()
    finally:
        sending.cancel()
        taking.cancel()
        await asyncio.gather(sending, taking, return_exceptions=True)
    if slow:
        with suppress(TimeoutError):
            await asyncio.wait_for(socket.close(TOO_SLOW), GRACE)


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
        self._folder_of_system: TemporaryDirectory[str] | None = None
        self._folder: TemporaryDirectory[str] | None = None
        self._coming: Upload | None = None
        self._left = 0

    def take(self, text: str, piece: bytes | None) -> None:
        """Accept a message: a text, or a piece of a file in transfer."""
        if piece is not None and self._coming is not None:
            self._add(piece)
            return
        question = read_question(text)
        if isinstance(question, Question) and question.machine is None:
            question = replace(question, path=self._system)
        if not isinstance(question, Upload):
            self._ask(question, self._deliver)
            return
        self._forget()
        if not question.size and self._given is not None and question.name == self._given.name:
            given = replace(question, path=self._given, reading=self._reading)
            self._ask(given, self._deliver)
            return
        self._folder = TemporaryDirectory(prefix="rotor-ida-")
        # its own name is in messages, and in the lines that compute a system again
        path = Path(self._folder.name, f"{safe_stem(question.name)}{question.ending}")
        self._coming, self._left = replace(question, path=path), question.size
        self._add(b"")

    def _add(self, piece: bytes) -> None:
        """Add a piece to the file; have it read when it is complete."""
        coming = self._coming
        assert coming is not None
        assert coming.path is not None
        if len(piece) > self._left:
            self._forget()
            raise InputError(f"a file must have the {coming.size} bytes announced, got more")
        with coming.path.open("ab") as file:
            file.write(piece)
        self._left -= len(piece)
        if not self._left:
            self._coming = None
            self._ask(coming, partial(self._read, coming.path, self._folder))

    def _read(self, path: Path, folder: TemporaryDirectory[str] | None, answer: bytes) -> None:
        """Keep a file if it is of a rotor system, and remove it otherwise."""
        is_system = part_of(answer) == SYSTEM
        if is_system and folder is not self._folder:
            return  # another file came meanwhile
        if is_system:
            if self._folder_of_system is not None:
                self._folder_of_system.cleanup()
            self._folder_of_system, self._folder, self._system = folder, None, path
        elif folder is not None:
            folder.cleanup()
        self._deliver(answer)

    def close(self) -> None:
        """Remove the stored files."""
        self._forget()
        if self._folder_of_system is not None:
            self._folder_of_system.cleanup()
            self._folder_of_system = None

    def _forget(self) -> None:
        """Remove a file that is in transfer, or is analysed."""
        self._coming = None
        if self._folder is not None:
            self._folder.cleanup()
            self._folder = None


def safe_stem(name: str) -> str:
    """Return the stem of a file name with nothing in it that leads elsewhere.

    Examples
    --------
    >>> safe_stem("../../my pump.toml")
    'my pump'
    """
    stem = Path(name.replace("\\", "/")).stem
    return re.sub(r"[^\w .-]", "_", stem)[:LONGEST_STEM].lstrip(".") or "file"


def _only_from_here(app: ASGIApp) -> ASGIApp:
    """Refuse requests to another host, or from a page of another origin."""

    async def guarded(scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in {"http", "websocket"}:
            await app(scope, receive, send)
            return
        headers = [(name, value.decode("latin-1")) for name, value in scope["headers"]]
        hosts = [value for name, value in headers if name == b"host"]
        origins = [value for name, value in headers if name == b"origin"]
        if is_own(hosts, origins, needs_origin=scope["type"] == "websocket"):
            await app(scope, receive, send)
        elif scope["type"] == "websocket":
            await WebSocket(scope, receive, send).close()
        else:
            refusal = PlainTextResponse("only the page of this machine is served here", 403)
            await refusal(scope, receive, send)

    return guarded


def is_own(hosts: list[str], origins: list[str], *, needs_origin: bool) -> bool:
    """Return whether host and origin are those of a page of this machine.

    Examples
    --------
    >>> is_own(["localhost:9000"], ["http://localhost:9000"], needs_origin=True)
    True
    >>> is_own(["localhost:9000"], ["http://example.org"], needs_origin=True)
    False
    >>> is_own(["example.org:9000"], [], needs_origin=False)
    False
    """
    if len(hosts) != 1:
        return False
    name, colon, port = hosts[0].rpartition(":")
    if not colon or hosts[0].endswith("]"):
        name, port = hosts[0], ""
    if name not in HOSTS or not (port == "" or (port.isascii() and port.isdigit())):
        return False
    if not origins:
        return not needs_origin
    return origins in ([f"http://{hosts[0]}"], [f"https://{hosts[0]}"])


class _Config(uvicorn.Config):
    """Limits on connections and their duration."""

    longest_visit = LONGEST_VISIT


class _Visit(H11Protocol):
    """A connection that fetches files; their number and duration are limited."""

    config: _Config

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self.since = self.loop.time()
        self._end = self.loop.call_later(self.config.longest_visit, transport.abort)
        # The oldest are closed to make room, whatever they have asked or read.
        visits = [
            each for each in self.connections
            if isinstance(each, _Visit) or (isinstance(each, _Talk) and not each.is_open())
        ]  # fmt: skip
        for each in sorted(visits, key=lambda each: each.since)[:-MOST_VISITS]:
            each.transport.abort()

    def data_received(self, data: bytes) -> None:
        try:
            super().data_received(data)
        except h11.LocalProtocolError:  # data after a request is not another request
            self.transport.abort()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        # The page sets no cookies: these belong to other programs, with any size and encoding.
        self.headers = [(name, value) for name, value in self.headers if name != b"cookie"]
        if not all(value.isascii() for _, value in self.headers):
            self.send_400_response("no page sends such headers")
            return
        self._end.cancel()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        self._end.cancel()
        super().connection_lost(exc)


class _Talk(WebSocketsSansIOProtocol):
    """A connection for questions; it ends even if the page stops reading."""

    config: _Config
    _fragments = 0

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self.since = self.loop.time()
        self._end = self.loop.call_later(self.config.longest_visit, self._end_unless_open)

    def is_open(self) -> bool:
        """Return whether it has shown the key."""
        return self.conn.state is not State.CONNECTING

    def _end_unless_open(self) -> None:
        if not self.is_open():
            self.transport.abort()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.conn.handshake_exc is not None:  # uvicorn sends no answer to excessive headers
            self.transport.write(b"".join(self.conn.data_to_send()))
            self.transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        self._end.cancel()
        super().connection_lost(exc)

    async def run_asgi(self) -> None:
        await super().run_asgi()
        self.loop.call_later(GRACE, self.transport.abort)

    def keepalive_timeout(self) -> None:
        super().keepalive_timeout()
        self.transport.abort()

    def handle_cont(self, event: Frame) -> None:
        super().handle_cont(event)
        self._fragments = 0 if event.fin else self._fragments + 1
        if self._fragments > MOST_FRAGMENTS:
            self.transport.abort()

    def handle_ping(self) -> None:
        super().handle_ping()
        if self.transport.get_write_buffer_size() > MOST_UNREAD:
            self.transport.abort()


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


def server_of(app: ASGIApp, longest_visit: float = LONGEST_VISIT) -> Server:
    """Return a server with limits on its input and on the duration of a visit [s]."""
    config = _Config(
        app, http=_Visit, ws=_Talk, lifespan="off", log_config=None, log_level="critical",
        access_log=False, server_header=False, date_header=False, ws_max_size=LARGEST_MESSAGE,
        ws_per_message_deflate=False, h11_max_incomplete_event_size=LARGEST_HEADERS,
        backlog=MOST_AT_ONCE, timeout_keep_alive=5, timeout_graceful_shutdown=1,
    )  # fmt: skip
    config.longest_visit = longest_visit
    return Server(config)
