"""Who has the key is answered, and nobody else; a file stays only as long as it is read."""

from __future__ import annotations

import asyncio
import json
import shutil
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, suppress
from functools import partial
from http.client import HTTPConnection, HTTPResponse
from pathlib import Path
from typing import Any, cast

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from rotor_ida.errors import InputError
from rotor_ida.explorer import server
from rotor_ida.explorer.messages import Answer, Asked, Upload, packed
from rotor_ida.explorer.queues import Deliver, Queues
from tests.explorer.asking import OF_SYSTEM, ROTOR, Message, asked, parts_of_answer, unpacked
from tests.explorer.conftest import PATIENCE

# Before a test shortens it.
LONGEST_VISIT = server.LONGEST_VISIT
KEY = "0123456789abcdef0123456789abcdef"


class Answered:
    """Queues that answer at once, in this process."""

    def ask(self, _page: int, question: Asked, deliver: Deliver) -> None:
        deliver(parts_of_answer(question)[0])

    def forget(self, page: int) -> None:
        """Forget a page, of which nothing is known."""


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    """Return the port at which the page is served."""
    serving = server.server_of(server.application(cast(Queues, Answered()), KEY))
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen()
        thread = threading.Thread(target=lambda: asyncio.run(serving.serve([listening])))
        thread.start()
        yield listening.getsockname()[1]
        serving.should_exit = True
        thread.join(PATIENCE)
    assert not thread.is_alive()


def reply(port: int, path: str = "/", **headers: str) -> tuple[HTTPResponse, bytes]:
    with closing(HTTPConnection("127.0.0.1", port, timeout=PATIENCE)) as connection:
        connection.request("GET", path, headers=headers)
        got = connection.getresponse()
        return got, got.read()


def talk(
    port: int, *, host: str = "", origin: str = "http://{}", key: str = f"rotor-ida.{KEY}",
    cookie: str = "a=b",
) -> ClientConnection:  # fmt: skip
    """Open a connection as the page does, whose host is the one in its address."""
    host = host or f"127.0.0.1:{port}"
    name, _, number = host.rpartition(":")
    here = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
    return connect(
        f"ws://{name}:{number}/ask", sock=here, origin=cast(Any, origin.format(host)),
        subprotocols=cast(Any, [key]), additional_headers={"Cookie": cookie}, max_size=None,
        compression=None, proxy=None, open_timeout=PATIENCE,
    )  # fmt: skip


def answered(page: ClientConnection, **changes: object) -> Message:
    page.send(json.dumps(asked(**changes)))
    return heard(page)


def heard(page: ClientConnection) -> Message:
    message = page.recv(PATIENCE)
    assert isinstance(message, bytes)
    return unpacked(message)


def test_the_page_is_served_with_all_its_files_and_no_other_page_may_use_them(port: int):
    for name in ("", "index.html", "uplot/uPlot.esm.js", "uplot/uPlot.min.css", "?" + "a" * 5000):
        got, _ = reply(port, f"/{name}", Cookie="a=" + "x" * 40_000)
        assert got.status == 200
    assert (got.getheader("Content-Security-Policy") or "").startswith("default-src 'none';")
    assert got.getheader("Cross-Origin-Resource-Policy") == "same-origin"
    for path in ("server.py", "../server.py", "%2e%2e/server.py", "uplot/../../server.py", "uplot"):
        assert reply(port, f"/{path}")[0].status == 404


@pytest.mark.parametrize("host", ["example.org", "127.0.0.1.example.org", "127.0.0.2"])
def test_a_site_whose_name_points_here_gets_nothing(port: int, host: str):
    got, body = reply(port, Host=f"{host}:{port}")
    assert (got.status, body) == (403, b"only the page of this machine is served here")
    with pytest.raises(InvalidStatus):
        talk(port, host=f"{host}:{port}")


@pytest.mark.parametrize(
    "given",
    [
        *({"origin": each} for each in ("http://example.org", "null", "ws://{}", "http://{}.org")),
        *({"key": each} for each in ("rotor-ida", "rotor-ida.", "rotor-ida." + "0" * 32)),
    ],
    ids=str,
)
def test_who_is_no_page_of_this_host_with_the_key_may_not_ask(port: int, given: dict[str, str]):
    with pytest.raises(InvalidStatus, match="403"):
        talk(port, **given)


def handshake(port: int) -> bytes:
    """Return the words with which the page's connection begins."""
    host = f"127.0.0.1:{port}"
    return (
        f"GET /ask HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\n"
        "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n"
        f"Sec-WebSocket-Protocol: rotor-ida.{KEY}\r\n\r\n"
    ).encode()


def opened(port: int, sent: bytes = b"") -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", port), timeout=LONGEST_VISIT / 2)
    connection.sendall(sent)
    return connection


@pytest.mark.parametrize(
    ("usual", "other", "status"),
    [
        (b"rotor-ida.", b"x" * 9000 + b".", b"431"),
        (b"Upgrade: ", b"X: " + b"x" * 9000 + b"\r\nUpgrade: ", b"431"),
        (b"Upgrade: ", b"X: y\r\n" * 200 + b"Upgrade: ", b"431"),
        (b"/ask", b"/ask" + b"x" * 9000, b"414"),
        (b"Upgrade: ", b"Content-Length: 1\r\nUpgrade: ", b""),
    ],
    ids=["protocol", "value", "headers", "path", "length"],
)
def test_who_asks_with_too_much_is_refused_at_once(
    port: int, usual: bytes, other: bytes, status: bytes
):
    with opened(port, handshake(port).replace(usual, other, 1)) as connection:
        got = b""
        with suppress(ConnectionError):
            while more := connection.recv(65536):
                got += more
    assert got[9:12] == status


def is_ended(connection: socket.socket) -> bool:
    try:
        return not connection.recv(1)
    except ConnectionError:
        return True


def test_connections_that_say_nothing_make_room_and_end(port: int, monkeypatch: pytest.MonkeyPatch):
    with talk(port) as page, ExitStack() as open_ones:
        idle = [open_ones.enter_context(opened(port)) for _ in range(300)]
        assert reply(port)[0].status == 200
        assert all(is_ended(each) for each in idle[: -server.MOST_VISITS])
        monkeypatch.setattr(server, "LONGEST_VISIT", 0.1)
        with talk(port) as other:
            assert is_ended(open_ones.enter_context(opened(port)))
            assert answered(other).part == "motion"
        assert answered(page).part == "motion"


def test_a_page_that_never_reads_is_sent_away(port: int, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(server, "MOST_UNREAD", 2**20)
    text, end = json.dumps(asked(revolutions=100)), time.monotonic() + PATIENCE
    with talk(port) as page, pytest.raises(ConnectionClosed):  # noqa: PT012 - whichever is the last
        while time.monotonic() < end:
            page.send(text)


def test_a_page_may_ask_whatever_cookies_of_others_it_has_and_at_a_forwarded_port(port: int):
    for given in ({"cookie": "a=" + "x" * 40_000}, {"host": "localhost:9000"}):
        with talk(port, **given) as page:
            assert answered(page).facts["rotor"] == ROTOR


def test_pages_do_not_see_each_other_s_answers(port: int):
    with talk(port) as one, talk(port) as other:
        one.send(json.dumps(asked(number=1, machine=ROTOR | {"omega": 1.1})))
        other.send(json.dumps(asked(number=2, machine=ROTOR | {"omega": 1.2})))
        assert heard(one).facts["rotor"]["omega"] == 1.1
        assert heard(other).facts["rotor"]["omega"] == 1.2


def announced(size: int = 3, **changes: object) -> str:
    """Return the question about a file, behind which its pieces come."""
    return json.dumps({
        "about": "upload", "number": 1, "name": "probes.csv", "size": size,
        "probe_angles": [0, 90], "gains": [1, 1], "columns": {}, "units": {},
    } | changes)  # fmt: skip


def test_a_file_in_pieces_is_analysed_and_questions_are_answered_meanwhile(port: int):
    contents = b"".join(f"{0.01 * n:.2f},{n % 7},{n % 5}\n".encode() for n in range(20_000))
    with talk(port) as page:
        page.send(announced(len(contents)))
        half = server.LARGEST_MESSAGE
        page.send(contents[:half])
        assert answered(page).part == "motion"
        for place in range(half, len(contents), half):
            page.send(contents[place : place + half])
        found = heard(page)
    assert found.part == "measured"
    assert found.facts["samples"] == 20_000


def test_a_file_that_cannot_be_stored_is_a_mistake_and_can_be_sent_again(
    port: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """As when a cleaner of temporary files removes its folder."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with talk(port) as page:
        page.send(announced())
        assert answered(page).part == "motion"
        shutil.rmtree(next(tmp_path.iterdir()))
        page.send(b"1,2")
        mistake = heard(page)
        assert mistake.facts["message"].startswith("the file cannot be stored: ")
        contents = b"".join(b"%d,%d,%d\n" % (n, n % 7, n % 5) for n in range(1000))
        page.send(announced(len(contents)))
        page.send(contents)
        assert heard(page).part == "measured"


def test_a_mistake_gets_one_line_and_the_page_lives_on(port: int):
    """Also bytes of a file that was never announced."""
    with talk(port) as page:
        for sent in ("{", json.dumps(asked(revolutions=0)), announced(-1), b"1,2"):
            page.send(sent)
            mistake = heard(page)
            assert mistake.part == "mistake"
            assert len(mistake.facts["message"].splitlines()) == 1
        assert answered(page).part == "motion"


Asking = list[tuple[Any, Callable[[bytes], None]]]


@pytest.fixture
def asking() -> Asking:
    return []


@pytest.fixture
def inbox_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asking: Asking
) -> Callable[..., server.Inbox]:
    """Return what makes an inbox, with its temporary folder here."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return partial(server.Inbox, lambda *each: asking.append(each))


def files_in(folder: Path) -> list[Path]:
    return [each for each in folder.rglob("*") if each.is_file()]


def test_what_is_kept_of_a_file_is_removed(
    tmp_path: Path, inbox_of: Callable[..., server.Inbox], asking: Asking
):
    """When it is analysed, another one comes, it is longer than announced, or the page goes."""
    answers: list[bytes] = []
    inbox = inbox_of(answers.append)
    inbox.take(announced(6, name="../probes.WAV"), None)
    inbox.take("", b"abc")
    assert not asking
    inbox.take("", b"def")
    ((measurement, deliver),) = asking
    asking.clear()
    assert isinstance(measurement, Upload)
    assert files_in(tmp_path) == [measurement.path]
    assert measurement.path is not None
    assert measurement.path.name == "probes.wav"
    assert measurement.path.read_bytes() == b"abcdef"
    deliver(packed(Answer("measured")))
    assert answers == [packed(Answer("measured"))]
    assert not files_in(tmp_path)
    for _ in range(2):
        inbox.take(announced(6), None)
        assert len(files_in(tmp_path)) == 1
    with pytest.raises(InputError, match="must have the 6 bytes announced, got more"):
        inbox.take("", b"abcdefg")
    assert not files_in(tmp_path)
    inbox.take(announced(6), None)
    inbox.close()
    assert not list(tmp_path.iterdir())
    assert not asking


def test_the_file_of_a_system_stays_until_another_can_be_read_and_no_name_leads_elsewhere(
    tmp_path: Path, inbox_of: Callable[..., server.Inbox], asking: Asking
):
    given = tmp_path / "given.toml"
    inbox = inbox_of(lambda _: None, given)

    def path_of_system() -> Path | None:
        inbox.take(json.dumps(OF_SYSTEM), None)
        found: Path | None = asking.pop()[0].path
        return found

    def sent(name: str, part: str) -> Path:
        inbox.take(announced(3, name=name), None)
        inbox.take("", b"abc")
        upload, deliver = asking.pop()
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
    inbox.take(announced(3, name="late.toml"), None)
    inbox.take("", b"abc")
    _, deliver = asking.pop()
    inbox.take(announced(3, name="later.toml"), None)
    deliver(packed(Answer("system")))  # of the one before
    assert path_of_system() == other
    # only the file of the command is read without being sent, by its name
    inbox.take(announced(0, name="given.toml"), None)
    assert asking.pop()[0].path == given
    inbox.take(announced(0, name="passwd.toml"), None)
    assert asking.pop()[0].path.parent.parent == tmp_path
    inbox.close()
    assert not list(tmp_path.iterdir())
