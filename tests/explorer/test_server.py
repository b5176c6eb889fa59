"""The page is served to this machine alone; whatever else comes, it is still answered."""

from __future__ import annotations

import contextlib
import json
import os
import socket
import struct
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from rotor_ida.errors import InputError
from rotor_ida.explorer import server
from rotor_ida.explorer.messages import LARGEST_FILE, Answer, Upload, packed
from tests.explorer.asking import OF_SYSTEM, ROTOR, Message, asked, unpacked
from tests.explorer.conftest import PATIENCE, SHORT_VISIT, Program, wait_until

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")

# A server that keeps what it is sent, or a task for each connection, grows by far more.
MOST_GROWTH = 50e6


def memory(program: Program) -> float:
    """Return the memory that the server holds [B]."""
    with open(f"/proc/{program.process.pid}/status") as status:
        line = next(line for line in status if line.startswith("VmRSS"))
    return float(line.split()[1]) * 1024.0


def sockets(program: Program) -> int:
    """Return how many files and connections the server holds."""
    return len(os.listdir(f"/proc/{program.process.pid}/fd"))


def opened(program: Program, sent: bytes = b"") -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", program.port), timeout=PATIENCE)
    connection.sendall(sent)
    return connection


def unread(program: Program, sent: bytes) -> socket.socket:
    """Open a connection that takes in but one byte of what it has asked for."""
    connection = socket.socket()
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2048)
    connection.settimeout(PATIENCE)
    connection.connect(("127.0.0.1", program.port))
    with contextlib.suppress(OSError):  # it may have had to make room by now
        connection.sendall(sent)
        connection.recv(1)
    return connection


def request(
    program: Program, line: str = "GET / HTTP/1.1", host: str = "", extra: str = ""
) -> bytes:
    """Return the words that ask for something, here for the page."""
    host = host or f"127.0.0.1:{program.port}"
    return f"{line}\r\nHost: {host}\r\n{extra}Connection: close\r\n\r\n".encode()


def large_file(program: Program) -> bytes:
    """Return the question for the largest file of the page."""
    host = f"127.0.0.1:{program.port}"
    return f"GET /uplot/uPlot.esm.js HTTP/1.1\r\nHost: {host}\r\n\r\n".encode()


def reply(program: Program, sent: bytes) -> tuple[int, bytes]:
    with opened(program, sent) as connection:
        got = b""
        while more := connection.recv(65536):
            got += more
    head, _, body = got.partition(b"\r\n\r\n")
    return int(head.split()[1]) if head else 0, body


def answered(talk: ClientConnection, **changes: object) -> Message:
    talk.send(json.dumps(asked(**changes)))
    return heard(talk)


def heard(talk: ClientConnection) -> Message:
    message = talk.recv(PATIENCE)
    assert isinstance(message, bytes)
    return unpacked(message)


def is_answered(program: Program) -> bool:
    """Return whether a page gets an answer; it may be that others have still to go."""
    with program.talk() as talk:
        try:
            return answered(talk).facts["rotor"] == ROTOR
        except ConnectionClosed as closed:
            if closed.rcvd is None or closed.rcvd.code != server.TOO_MANY_PAGES:
                raise
            return False


def handshake(program: Program) -> bytes:
    """Return the words with which the page's connection begins."""
    host = f"127.0.0.1:{program.port}"
    return (
        f"GET /ask HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
        f"Sec-WebSocket-Protocol: rotor-ida.{program.key}\r\n\r\n"
    ).encode()


def frame(payload: bytes, *, kind: int = 1, last: bool = True, length: int | None = None) -> bytes:
    """Return a frame as a client sends it, masked with zeros."""
    size = len(payload) if length is None else length
    head = bytes([kind | (0x80 if last else 0)])
    if size < 126:
        head += bytes([0x80 | size])
    elif size < 65536:
        head += bytes([0x80 | 126]) + struct.pack("!H", size)
    else:
        head += bytes([0x80 | 127]) + struct.pack("!Q", size)
    return head + bytes(4) + payload


def begun(program: Program) -> socket.socket:
    """Return a connection as a page's, on which frames can be sent that no browser would send."""
    connection = opened(program, handshake(program))
    got = b""
    while b"\r\n\r\n" not in got:
        got += connection.recv(65536)
    assert got.startswith(b"HTTP/1.1 101")
    return connection


def sent_until_refused(connection: socket.socket, piece: bytes, total: int) -> int:
    """Send up to so many bytes, and return how many were taken."""
    taken = 0
    with contextlib.suppress(OSError):
        while taken < total:
            connection.sendall(piece)
            taken += len(piece)
    return taken


@pytest.fixture(scope="module")
def flooded(served: Program) -> None:
    """Have the server take from the system, once, the buffers that every later flood uses again."""
    with contextlib.ExitStack() as open_ones:
        for _ in range(4 * server.MOST_VISITS):
            open_ones.enter_context(unread(served, 40 * large_file(served)))
        wait_until(lambda: is_answered(served), "a good client that is answered")


@pytest.fixture
def unharmed(served: Program, flooded: None) -> Iterator[Callable[[], None]]:
    """Check after an attack: the page is served, a good client answered, and memory is flat."""
    reply(served, request(served))
    before, said = memory(served), len(served.said)

    def check() -> None:
        status, body = reply(served, request(served))
        assert (status, b"<html" in body) == (200, True)
        wait_until(lambda: is_answered(served), "a good client that is answered")
        assert memory(served) - before < MOST_GROWTH
        assert served.said[said:] == []

    yield check
    check()


def test_the_page_is_served_at_any_port_with_all_its_files(served: Program):
    """By every name of this machine, and no other page may use them."""
    for name in ("127.0.0.1", "localhost", "[::1]"):
        for port in ("", ":80", ":9000", ":65535"):
            assert reply(served, request(served, host=f"{name}{port}"))[0] == 200
    for name in ("index.html", "uplot/uPlot.esm.js", "uplot/uPlot.min.css", "?" + "a" * 5000):
        assert reply(served, request(served, f"GET /{name} HTTP/1.1"))[0] == 200
    with opened(served, f"GET / HTTP/1.0\r\nHost: 127.0.0.1:{served.port}\r\n\r\n".encode()) as one:
        one.shutdown(socket.SHUT_WR)  # a client that hangs up its half still gets its page
        head = one.recv(65536).partition(b"\r\n\r\n")[0].decode().lower()
    assert head.startswith("http/1.1 200")
    assert "content-security-policy: default-src 'none';" in head
    assert "cross-origin-resource-policy: same-origin" in head
    assert "frame-ancestors 'none'" in head


def test_a_page_may_talk_whatever_cookies_of_others_it_has_and_at_a_forwarded_port(served: Program):
    here = f"127.0.0.1:{served.port}".encode()
    begins = [handshake(served).replace(here, b"localhost:9000")]
    for cookie in ("a=" + "x" * 9000, "a=" + "x" * 40_000, "a=é"):
        line = f"Cookie: {cookie}\r\n"
        assert reply(served, request(served, extra=line))[0] == 200
        begins.append(handshake(served).replace(b"Upgrade: ", line.encode() + b"Upgrade: ", 1))
    for sent in begins:
        with opened(served, sent) as connection:
            assert connection.recv(65536).startswith(b"HTTP/1.1 101")


OTHER_HOSTS = [
    "example.org", "127.0.0.1.example.org", "localhost.example.org:8765", "127.0.0.2", "0.0.0.0",
    "127.0.0.1@example.org", "localhost:80:90", "localhost:x", "[::2]", "::1", "[::1", " ",
    "a" * 999,
]  # fmt: skip
PATHS = [
    "server.py", "../server.py", "%2e%2e/server.py", "uplot/../../server.py", "/etc/passwd",
    "..%2f..%2fserver.py", "%00", "uplot", "uplot/", "index.html/", ".", "a\\..\\server.py",
    "a" * 5000,
]  # fmt: skip
ORIGINS = [
    "http://example.org", "null", "http://127.0.0.1", "http://localhost:{port}",
    "http://127.0.0.1:{port}.example.org", "ws://127.0.0.1:{port}", "http://127.0.0.1:{port}/",
]  # fmt: skip
KEYS = [
    b"rotor-ida", b"rotor-ida.", b"rotor-ida.0123456789abcdef0123456789abcdef", b"\xff\xfe",
    "rotor-ida.é".encode(), b"rotor-ida.\x80" * 50, b"",
]  # fmt: skip
# What a talk asks with too much of: what it replaces, by what, and the status.
EXCESSIVE = [
    (b"rotor-ida.", b"x" * 9000 + b".", 431),
    (b"Upgrade: ", b"X: " + b"x" * 9000 + b"\r\nUpgrade: ", 431),
    (b"Upgrade: ", b"X: y\r\n" * 200 + b"Upgrade: ", 431),
    (b"/ask", b"/ask" + b"x" * 9000, 414),
    (b"Upgrade: ", b"Content-Length: 1\r\nUpgrade: ", 0),
]  # fmt: skip


def refused(program: Program) -> Iterator[tuple[bytes, set[int]]]:
    """Yield what is sent by those who may not ask, and the statuses of which it gets one."""
    origin = f"Origin: http://127.0.0.1:{program.port}".encode()
    key, host = f"rotor-ida.{program.key}".encode(), f"Host: 127.0.0.1:{program.port}\r\n"
    talk = handshake(program)
    for each in OTHER_HOSTS:
        yield request(program, host=each), {400, 403}
    for each in ("Host: example.org", "Host: 127.0.0.1", "X-Forwarded-Host: 127.0.0.1"):
        yield request(program, host="example.org", extra=f"{each}\r\n"), {400, 403}
    for line in ("GET / HTTP/1.1\r\nConnection: close", "GET / HTTP/1.0"):
        yield f"{line}\r\n\r\n".encode(), {400, 403}
    for each in ("http://example.org", "null", "file://", "http://127.0.0.1:1"):
        yield request(program, extra=f"Origin: {each}\r\n"), {403}
    for each in ORIGINS:
        yield talk.replace(origin, f"Origin: {each.format(port=program.port)}".encode()), {403}
    yield talk.replace(origin + b"\r\n", b""), {403}
    for word in KEYS:
        yield talk.replace(key, word), {403} if word.isascii() and word else {400, 403}
    yield talk.replace(b"Sec-WebSocket-Protocol: " + key + b"\r\n", b""), {403}
    for usual, excessive, status in EXCESSIVE:
        for sent in (talk, talk.replace(b"http://127.0.0.1", b"http://example.org")):
            yield sent.replace(usual, excessive, 1), {0, status}
    for path in PATHS:
        yield request(program, f"GET /{path} HTTP/1.1"), {404}
    for method in ("POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "X"):
        yield request(program, f"{method} / HTTP/1.1"), {400, 405}
    for sent in (
        b"\x00" * 1000, b"\x16\x03\x01\x02\x00", b"GET\r\n\r\n",
        f"GET / HTTP/one\r\n{host}\r\n".encode(),
        f"GET / HTTP/1.1\r\n{host}X: {'a' * 1_000_000}\r\n\r\n".encode(),
        f"GET /{'a' * 1_000_000} HTTP/1.1\r\n{host}\r\n".encode(),
        f"POST / HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\nzz\r\n{'x' * 999}".encode(),
        f"POST / HTTP/1.1\r\n{host}Content-Length: 1\r\nContent-Length: 2\r\n\r\n".encode(),
        talk.replace(b"Version: 13", b"Version: 7"),
        talk.replace(b"AAAAAAAAAAAAAAAAAAAAAA==", b"AA"),
    ):  # fmt: skip
        yield sent, {0, 400, 405, 426, 431}


@pytest.mark.usefixtures("unharmed")
def test_who_may_not_ask_is_refused_at_once(served: Program):
    """Other hosts, origins, keys, paths and methods, too much of anything, and what is no HTTP."""
    asked_ = list(refused(served))
    assert len(asked_) > 60
    for sent, statuses in asked_:
        since = time.monotonic()
        with contextlib.suppress(*[ConnectionError] * (0 in statuses)):
            status, body = reply(served, sent)
            assert status in statuses, sent[:200]
            assert b"<html" not in body, sent[:200]
            assert b"import " not in body, sent[:200]
        assert time.monotonic() - since < server.LONGEST_VISIT, sent[:200]


def announced(size: int = 3, **changes: object) -> str:
    """Return the question about a file, behind which its pieces come."""
    return json.dumps({
        "about": "upload", "number": 1, "name": "probes.csv", "size": size,
        "probe_angles": [0, 90], "gains": [1, 1],
    } | changes)  # fmt: skip


def table(samples: int) -> bytes:
    return b"".join(f"{0.01 * n:.2f},{n % 7},{n % 5}\n".encode() for n in range(samples))


def test_a_file_in_pieces_is_analysed_and_questions_are_answered_meanwhile(served: Program):
    contents = table(20_000)
    with served.talk() as talk:
        talk.send(announced(len(contents)))
        half = server.LARGEST_MESSAGE
        talk.send(contents[:half])
        assert answered(talk).part == "motion"
        for place in range(half, len(contents), half):
            talk.send(contents[place : place + half])
        found = heard(talk)
    assert found.part == "measured"
    assert found.facts["samples"] == 20_000


ANNOUNCED = (
    ({"size": LARGEST_FILE + 1}, f"size must be at most {LARGEST_FILE}"),
    ({"size": -1}, "size must be at least 0"),
    ({"name": 7}, "name must be the name of a file"),
    ({"gains": [1]}, "gains must be two numbers"),
    ({"columns": ["x"]}, "columns must be words by names of signals"),
    ({"units": {"x": 1}}, "units must be words by names of signals"),
    ({"path": "/etc/passwd"}, "got also ['path']"),
)


def test_a_mistake_gets_one_line_and_the_page_lives_on(served: Program):
    """Also an announcement of no file, behind which nobody waits for its bytes."""
    mistakes: list[tuple[str | bytes, str]] = [
        *((text, "") for text in ("{", "null", json.dumps(asked(revolutions=0)))),
        *((text, "") for text in (" " * 4097, " " * 60_000, json.dumps(asked()).encode())),
    ]
    for changes, told in ANNOUNCED:
        mistakes += [(announced(**{"size": 3, **changes}), told), (b"1,2", "a question must")]
    with served.talk() as talk:
        for sent, told in mistakes:
            talk.send(sent)
            mistake = heard(talk)
            assert mistake.part == "mistake"
            (line,) = mistake.facts["message"].splitlines()
            assert told in line
        assert answered(talk).part == "motion"


def test_what_is_kept_of_a_file_is_removed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """When it is analysed, another one comes, it is longer than announced, or the page goes."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    asked_: list[tuple[Upload, Callable[[bytes], None]]] = []
    answers: list[bytes] = []
    inbox = server.Inbox(lambda *asking: asked_.append(asking), answers.append)
    inbox.take(announced(6, name="../probes.WAV"), None)
    inbox.take("", b"abc")
    assert not asked_
    inbox.take("", b"def")
    (measurement, deliver), (folder,) = asked_.pop(), tmp_path.iterdir()
    assert measurement.path == folder / "probes.wav"
    assert measurement.path.read_bytes() == b"abcdef"
    answer = packed(Answer("measured"))
    deliver(answer)
    assert answers == [answer]
    assert not list(tmp_path.iterdir())
    for _ in range(2):
        inbox.take(announced(6), None)
        assert len(list(tmp_path.iterdir())) == 1
    with pytest.raises(InputError, match="must have the 6 bytes announced, got more"):
        inbox.take("", b"abcdefg")
    assert not list(tmp_path.iterdir())
    inbox.take(announced(6), None)
    inbox.close()
    assert not list(tmp_path.iterdir())
    assert not asked_


def test_the_file_of_a_system_stays_until_another_can_be_read_and_no_name_leads_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    asked_: list[tuple[Any, Callable[[bytes], None]]] = []
    given = tmp_path / "given.toml"
    inbox = server.Inbox(lambda *asking: asked_.append(asking), lambda _: None, given)

    def path_of_system() -> Path | None:
        inbox.take(json.dumps(OF_SYSTEM), None)
        found: Path | None = asked_.pop()[0].path
        return found

    def sent(name: str, part: str) -> Path:
        inbox.take(announced(3, name=name), None)
        inbox.take("", b"abc")
        upload, deliver = asked_.pop()
        deliver(packed(Answer(part)))
        found: Path = upload.path
        return found

    assert path_of_system() == given
    one = sent("../../one.toml", "system")
    assert path_of_system() == one
    assert one.parent.parent == tmp_path
    assert not sent("two.toml", "trouble").exists()
    assert not sent("probes.csv", "measured").exists()
    assert path_of_system() == one
    other = sent("other.nc", "system")
    assert path_of_system() == other
    assert not one.exists()
    # only the file of the command is read without being sent, by its name
    inbox.take(announced(0, name="given.toml"), None)
    assert asked_.pop()[0].path == given
    inbox.take(announced(0, name="passwd.toml"), None)
    assert asked_.pop()[0].path.parent.parent == tmp_path
    inbox.close()
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("unharmed")
def test_text_that_is_no_text_ends_the_talk(served: Program):
    with begun(served) as connection:
        connection.sendall(frame(b"\xff\xfe\xfd"))
        assert connection.recv(1000)[:1] in {b"\x88", b""}


HEAD = "POST / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nContent-Length: 100000000\r\n\r\n"
QUESTION = frame(json.dumps(asked(revolutions=1)).encode())
FLOODS = {
    "claimed": (frame(b"", length=10**8), bytes(10**6), 10**8),
    "claimed to be endless": (frame(b"", length=2**63 - 1), bytes(10**6), 10**8),
    "fragments": (frame(b"x", last=False), frame(b"x" * 1000, kind=0, last=False) * 1000, 10**8),
    "empty fragments": (
        frame(b"x", last=False), frame(b"", kind=0, last=False) * 100_000, 10**8,
    ),
    "pings": (b"", frame(b"x" * 125, kind=9) * 10_000, 10**8),
    "noise": (b"", b"\xff" * 1_000_000, 10**8),
    "questions": (b"", QUESTION * 1000, 2 * 10**7),
    "a body": (b"", bytes(10**6), 10**8),
}  # fmt: skip


@pytest.mark.parametrize("name", FLOODS)
@pytest.mark.usefixtures("unharmed")
def test_100_mb_in_any_frames_are_not_kept(served: Program, name: str):
    first, piece, total = FLOODS[name]
    of_body = HEAD.format(port=served.port).encode()
    with opened(served, of_body) if name == "a body" else begun(served) as connection:
        connection.settimeout(10.0)  # a server that takes no more is right as well
        connection.sendall(first)
        taken = sent_until_refused(connection, piece, total)
        assert name != "claimed" or taken < total  # the talk is ended


@pytest.mark.parametrize("begins", [False, True], ids=["say nothing", "begin no talk"])
def test_1000_connections_make_room(served: Program, unharmed: Callable[[], None], begins: bool):
    wrong = handshake(served).replace(served.key.encode(), b"0" * 32) if begins else b""
    with contextlib.ExitStack() as open_ones:
        for number in range(1000):
            open_ones.enter_context(opened(served, wrong if number % 2 else wrong[:-2]))
        unharmed()
        assert sockets(served) < 2 * server.MOST_VISITS


def test_connections_that_never_read_keep_nobody_out(served: Program, unharmed: Callable[[], None]):
    with contextlib.ExitStack() as open_ones:
        for _ in range(4 * server.MOST_VISITS):
            open_ones.enter_context(unread(served, 40 * large_file(served)))
        unharmed()
        assert sockets(served) < 2 * server.MOST_VISITS


def test_a_talk_refused_behind_a_file_that_nobody_reads_is_closed(impatient: Program):
    program = impatient
    wrong = handshake(program).replace(b"Version: 13", b"Version: 7")
    before = sockets(program)
    with contextlib.ExitStack() as open_ones:
        for files in range(40):  # one of them ends where the system itself keeps no more
            open_ones.enter_context(unread(program, files * large_file(program) + wrong))
        since = time.monotonic()
        wait_until(lambda: sockets(program) <= before, "connections that are closed")
        assert time.monotonic() - since > SHORT_VISIT / 2  # some had to be


@pytest.mark.usefixtures("unharmed")
def test_connections_that_break_off_anywhere_do_no_harm(served: Program):
    now = struct.pack("ii", 1, 0)
    whole = handshake(served) + frame(json.dumps(asked()).encode())
    for length in range(0, len(whole) + 1, 5):
        with opened(served, whole[:length]) as connection:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, now)


def test_a_header_that_drips_is_not_waited_for_for_ever(impatient: Program):
    with opened(impatient, b"GET / HTTP/1.1\r\n") as connection:
        end = time.monotonic() + SHORT_VISIT + PATIENCE
        with pytest.raises(OSError):  # noqa: PT011, PT012 - whichever breaks
            while time.monotonic() < end:
                connection.sendall(b"X: y\r\n")
                time.sleep(0.5)


@pytest.mark.usefixtures("unharmed")
def test_talks_of_which_one_half_is_closed_do_no_harm(served: Program):
    with contextlib.ExitStack() as open_ones:
        for _ in range(2 * server.MOST_PAGES):
            connection = open_ones.enter_context(opened(served, handshake(served)))
            connection.shutdown(socket.SHUT_WR)


def test_more_pages_than_there_may_be_are_sent_away_with_a_reason(served: Program):
    with contextlib.ExitStack() as pages:
        talks = [pages.enter_context(served.talk()) for _ in range(server.MOST_PAGES)]
        with served.talk() as one_more:
            with pytest.raises(ConnectionClosed) as caught:
                one_more.recv(PATIENCE)
            assert caught.value.rcvd is not None
            assert caught.value.rcvd.code == server.TOO_MANY_PAGES
        assert answered(talks[0]).part == "motion"
        assert answered(talks[-1]).part == "motion"
    with served.talk() as talk:
        assert answered(talk).part == "motion"


@pytest.mark.usefixtures("unharmed")
def test_a_page_that_never_reads_is_sent_away(served: Program):
    text = json.dumps(asked(revolutions=2000)).encode()
    with begun(served) as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        before = memory(served)
        end = time.monotonic() + PATIENCE
        with pytest.raises(OSError):  # noqa: PT011, PT012 - whichever breaks
            while time.monotonic() < end:
                connection.sendall(frame(text))
                time.sleep(0.05)
                assert memory(served) - before < 5 * server.MOST_UNREAD


def test_pages_do_not_see_each_other_s_answers(served: Program):
    with served.talk() as one, served.talk() as other:
        one.send(json.dumps(asked(number=1, machine=ROTOR | {"omega": 1.1})))
        other.send(json.dumps(asked(number=2, machine=ROTOR | {"omega": 1.2})))
        assert heard(one).facts["rotor"]["omega"] == 1.1
        assert heard(other).facts["rotor"]["omega"] == 1.2
