"""Files made to harm a reader are refused soon and cheaply; benchmarks/damage.py has more."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from rotor_ida import ArchiveError, load

FORMAT_1 = Path(__file__).parents[1] / "data" / "archive_format_1.nc"
SECONDS, MEBIBYTES = 5, 1024

SCRIPT = """
import json, resource, sys
from rotor_ida import ArchiveError, load
from pathlib import Path
def used():  # of the processor, which others may be using too
    found = [resource.getrusage(kind) for kind in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in found)
def memory():  # getrusage would count in the process that started this one
    lines = Path("/proc/self/status").read_text().splitlines()
    mine = next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))
    return max(mine, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss) / 1024
before = used()
told = "nothing"
try:
    load(sys.argv[1])
except ArchiveError as error:
    told = str(error)
print(json.dumps([told, used() - before, memory()]))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
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
    # in a process of its own: a test before may have had children that were larger
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(path)], capture_output=True, text=True, check=True
    )
    told, seconds, mebibytes = json.loads(ended.stdout)
    assert re.search(message, told)
    assert seconds < SECONDS
    assert mebibytes < MEBIBYTES


def test_reader_that_never_ends_is_ended(tmp_path: Path) -> None:
    endless = bytearray(FORMAT_1.read_bytes())
    # one of the bits that, rotated over, send the HDF5 library round and round
    endless[3101] ^= 1
    path = tmp_path / "endless.nc"
    path.write_bytes(endless)
    began = time.process_time()
    with pytest.raises(ArchiveError, match="cannot read it to its end in the time and memory"):
        load(path)
    assert time.process_time() - began < 1
