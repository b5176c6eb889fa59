"""The store of a study: what was kept is there again, and what is not ours is refused."""

import errno
import json
import os
import subprocess
import sys
from hashlib import sha256

import pytest
from filelock import FileLock

from rotor_ida.errors import ArchiveError, InputError
from rotor_ida.results.studies import Piece, opened, status
from rotor_ida.results.studies.store import FILE, LOCK

DESIGN = {"verb": "sweep", "omega": [1.2, 1.7], "rtol": 1e-10, "direction": None, "vx": 0.0}


def piece(number, content=b"content", failed=0, reason=""):
    return Piece(number, 1, failed, reason, content)


def files_in(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*")
                  if path.is_file())  # fmt: skip


def test_what_was_kept_is_there_again(tmp_path):
    contents = [bytes([number]) * number for number in range(5)]
    with opened(tmp_path / "study", DESIGN, 5) as study:
        for number in (3, 0, 4):
            study.keep(piece(number, contents[number]))
    with opened(tmp_path / "study", DESIGN, 5) as study:
        assert study.done == {0, 3, 4}
        assert study.points_done == 3
        for number in (1, 2):
            study.keep(piece(number, contents[number]))
        assert [content for _, content in study.contents()] == contents
    assert files_in(tmp_path / "study") == [*(f"pieces/{number}" for number in range(5)), FILE]


def test_an_interrupt_in_the_midst_of_writing_leaves_what_was_there(tmp_path, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    with (  # noqa: PT012 - the way out of the study is what is tested
        pytest.raises(KeyboardInterrupt),
        opened(tmp_path, DESIGN, 2) as study,
    ):
        study.keep(piece(0))
        monkeypatch.setattr(os, "fsync", interrupted)
        study.keep(piece(1))
    monkeypatch.undo()
    assert files_in(tmp_path) == ["pieces/0", FILE]
    with opened(tmp_path, DESIGN, 2) as study:
        assert list(study.contents()) == [(0, b"content")]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rtol": 1e-9}, "begun with rtol 1e-10, got 1e-09"),
        ({"omega": [1.2]}, r"begun with omega \[1.2, 1.7\], got \[1.2\]"),
        ({"direction": "up"}, "begun with direction None, got 'up'"),
        ({"vx": -0.0}, "begun with vx 0.0, got -0.0"),
        ({"numpy_version": "9"}, "begun with numpy_version 'nothing', got '9'"),
    ],
)
def test_another_design_is_refused_with_the_difference(tmp_path, change, message):
    with opened(tmp_path, DESIGN, 2) as study:
        study.keep(piece(0))
    with pytest.raises(InputError, match=message), opened(tmp_path, DESIGN | change, 2):
        pass
    with opened(tmp_path, DESIGN, 2) as study:
        assert study.done == {0}


def test_two_processes_cannot_work_on_one_study(tmp_path):
    with opened(tmp_path, DESIGN, 2):
        assert status(tmp_path)["running"]
        script = (
            "from rotor_ida.results.studies import opened\n"
            f"with opened({str(tmp_path)!r}, {DESIGN!r}, 2): pass"
        )
        ended = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, check=False
        )
        assert "ArchiveError: another process is working" in ended.stderr
    assert not status(tmp_path)["running"]


def test_a_killed_process_leaves_no_lock(tmp_path):
    script = (
        "import os\n"
        "from rotor_ida.results.studies import Piece, opened\n"
        f"with opened({str(tmp_path)!r}, {DESIGN!r}, 2) as study:\n"
        "    study.keep(Piece(0, 1, 0, '', b'content'))\n"
        "    os._exit(9)"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 9
    assert (tmp_path / LOCK).exists()
    found = status(tmp_path)
    assert (found["done"], found["running"]) == (1, False)
    with opened(tmp_path, DESIGN, 2) as study:
        assert study.done == {0}
    assert files_in(tmp_path) == ["pieces/0", FILE]


def test_a_study_that_may_only_be_read_can_be_read(tmp_path, monkeypatch):
    with opened(tmp_path, DESIGN, 1) as study:
        study.keep(piece(0))

    def refused(_lock):
        raise PermissionError(errno.EACCES, "Permission denied")

    monkeypatch.setattr(FileLock, "acquire", refused)
    with opened(tmp_path, DESIGN, 1) as study:
        assert list(study.contents()) == [(0, b"content")]
    assert not status(tmp_path)["running"]


def test_status_counts_done_failed_and_left(tmp_path):
    with opened(tmp_path, DESIGN, 10) as study:
        study.keep(piece(0))
        study.keep(Piece(1, 3, 2, "too stiff", b""))
    found = status(tmp_path)
    assert (found["kind"], found["points"], found["done"], found["failed"], found["left"]) == (
        "sweep", 10, 4, 2, 6,
    )  # fmt: skip
    assert found["reasons"] == ["too stiff"]
    assert found["points_per_second"] > 0.0
    assert found["seconds_left"] == pytest.approx(6 / found["points_per_second"])


def test_a_place_that_is_no_study_is_refused_and_left_alone(tmp_path):
    (tmp_path / "link").symlink_to(tmp_path / "absent")
    (tmp_path / "file").write_text("")
    for place, message in (
        (tmp_path / "link", "study must be a folder that can be .*File exists"),
        ("", "study must be the path of a folder"),
        (tmp_path / "file", "study must be a folder, got the file"),
        (tmp_path, "study must be a new, an empty or a study's folder"),
    ):
        with pytest.raises(InputError, match=message):
            opened(place, DESIGN, 2).__enter__()
    for place in ("link", "absent"):
        with pytest.raises(InputError, match="folder must be that of a study"):
            status(tmp_path / place)
    assert sorted(os.listdir(tmp_path)) == ["file", "link"]


def test_a_study_that_was_killed_at_once_begins_anew(tmp_path):
    (tmp_path / LOCK).touch()
    (tmp_path / "pieces").mkdir()
    (tmp_path / "pieces" / "unfinished").write_bytes(b"half")
    with pytest.raises(InputError, match="folder must be that of a study"):
        status(tmp_path)
    with opened(tmp_path, DESIGN, 2) as study:
        assert study.done == set()
    assert files_in(tmp_path) == [FILE]


def forge(path, change):
    """Change the line of JSON of a file, and write the checksum that fits."""
    _, line, content = path.read_bytes().split(b"\n", 2)
    body = change(line) + b"\n" + content
    path.write_bytes(sha256(body).hexdigest().encode() + b"\n" + body)


def with_(**changes):
    return lambda line: json.dumps(json.loads(line) | changes).encode()


@pytest.mark.parametrize("at", [0, 64, 65, 100, -1])
@pytest.mark.parametrize("name", [FILE, "pieces/0"])
def test_any_damage_to_a_file_is_reported(tmp_path, name, at):
    with opened(tmp_path, DESIGN, 2) as study:
        study.keep(piece(0))
    content = bytearray((tmp_path / name).read_bytes())
    content[at] ^= 1
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ArchiveError, match=f"damaged: {name} is not what was written; restore"):
        opened(tmp_path, DESIGN, 2).__enter__()


@pytest.mark.parametrize(
    "change",
    [with_(number=1), *(lambda _, text=text: text for text in (
        b"not JSON", b"[]", b"{}", b"[" * 100_000, b"1" * 5000))],
)  # fmt: skip
def test_a_piece_that_cannot_be_is_damage(tmp_path, change):
    with opened(tmp_path, DESIGN, 2) as study:
        study.keep(piece(0))
    forge(tmp_path / "pieces" / "0", change)
    for look in (status, lambda folder: opened(folder, DESIGN, 2).__enter__()):
        with pytest.raises(ArchiveError, match=r"damaged: pieces/0 .* remove it and resume"):
            look(tmp_path)


def test_the_files_of_something_else_are_left_alone(tmp_path):
    (tmp_path / FILE).write_text("{}")
    with pytest.raises(ArchiveError, match=f"damaged: {FILE} is not"):
        opened(tmp_path, DESIGN, 2).__enter__()
    assert (tmp_path / FILE).read_text() == "{}"
    (tmp_path / FILE).unlink()
    with opened(tmp_path, DESIGN, 2):
        (tmp_path / "pieces" / "notes.txt").write_text("mine")
    with pytest.raises(ArchiveError, match="pieces': invalid literal"):
        opened(tmp_path, DESIGN, 2).__enter__()


def test_another_format_is_refused(tmp_path):
    with opened(tmp_path, DESIGN, 2):
        pass
    forge(tmp_path / FILE, with_(format=3))
    with pytest.raises(InputError, match="has format 3, but this version"):
        opened(tmp_path, DESIGN, 2).__enter__()


@pytest.mark.skipif(os.name != "posix", reason="limits the size of files")
def test_a_full_disk_leaves_what_was_kept(tmp_path):
    with opened(tmp_path, DESIGN, 2) as study:
        study.keep(piece(0))
    script = f"""
import resource, signal
from rotor_ida.results.studies import Piece, opened
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2**16, 2**16))
with opened({str(tmp_path)!r}, {DESIGN!r}, 2) as study:
    study.keep(Piece(1, 1, 0, "", bytes(2**18)))
"""
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert "ArchiveError: cannot write" in ended.stderr
    assert "what was kept before is intact" in ended.stderr
    with opened(tmp_path, DESIGN, 2) as study:
        assert study.done == {0}
        study.keep(piece(1))
    assert files_in(tmp_path) == ["pieces/0", "pieces/1", FILE]
