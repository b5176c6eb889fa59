"""Arrays as bytes, to the last bit, and on the disk: where there is no room, one line says so."""

import os
import subprocess
import sys

import numpy as np
import pytest

from rotor_ida.results.studies.arrays import LARGE, scratch


def test_a_large_array_leaves_no_file(tmp_path):
    array = scratch((LARGE + 1,), np.int8, tmp_path)
    array[-1] = 7
    assert array[-1] == 7
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(os.name != "posix", reason="limits the size of files")
def test_a_full_disk_is_told_in_words(tmp_path):
    script = f"""
import resource, signal
import numpy as np
from pathlib import Path
from rotor_ida.results.studies.arrays import LARGE, scratch
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (2**16, 2**16))
scratch((LARGE,), np.int8, Path({str(tmp_path)!r}))
"""
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert "ArchiveError: cannot make room for 64 MiB in" in ended.stderr
    assert os.listdir(tmp_path) == []
