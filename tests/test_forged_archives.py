"""Files made to harm a reader are refused soon and cheaply; benchmarks/damage.py has more."""

from __future__ import annotations

import resource
import shutil
import time
from pathlib import Path

import pytest

from rotor_ida import ArchiveError, load

FORMAT_1 = Path(__file__).parent / "data" / "archive_format_1.nc"
SECONDS, MEBIBYTES = 5, 1024


@pytest.mark.parametrize(
    ("forgery", "message"),
    [
        ("compression_bomb", "is damaged"),
        ("cyclic_links", "is not a sound archive: it holds"),
        ("deep_groups", "is not a sound archive: it holds 'g'"),
        ("huge_string", "is damaged|may be damaged|does not have the checksum"),
        ("missing_filter", "cannot read .*, which may be damaged"),
        ("user_types", "is not a sound archive"),
    ],
)
def test_forged_archive_is_refused(forgery: str, message: str, tmp_path: Path) -> None:
    path = Path(shutil.copy(FORMAT_1, tmp_path / "forged.nc"))
    pytest.importorskip("benchmarks.forgeries").FORGERIES[forgery](path)
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    with pytest.raises(ArchiveError, match=message):
        load(path)
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    # of the processor, which others may be using too
    assert now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime < SECONDS
    assert now.ru_maxrss / 1024 < MEBIBYTES


def test_reader_that_never_ends_is_ended(tmp_path: Path) -> None:
    endless = bytearray(FORMAT_1.read_bytes())
    # one of the bits that, turned over, send the HDF5 library round and round
    endless[3101] ^= 1
    path = tmp_path / "endless.nc"
    path.write_bytes(endless)
    began = time.process_time()
    with pytest.raises(ArchiveError, match="cannot read it to its end in the time and memory"):
        load(path)
    assert time.process_time() - began < 1
