"""Machine code is cached, and not longer than its sources stay the same."""

import ast
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import numba
import numpy as np
import pytest

from rotor_ida.equations import compiling

PACKAGE = Path(compiling.__file__).parents[1]


@pytest.fixture
def fresh():
    """`cache_folder` looks for a folder anew."""
    compiling.cache_folder.cache_clear()
    yield
    compiling.cache_folder.cache_clear()


def test_where_no_folder_can_be_written_kernels_still_run(monkeypatch, tmp_path, fresh):
    nowhere = tmp_path / "file"
    nowhere.touch()
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(nowhere))
    assert compiling.cache_folder() is None
    assert compiling.compiled(lambda number: number + 1)(2) == 3
    assert str(nowhere) == numba.config.CACHE_DIR


def test_the_folder_that_the_user_names_is_used_and_old_caches_go(monkeypatch, tmp_path, fresh):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    old, recent = tmp_path / "kernels-old", tmp_path / "kernels-recent"
    for folder in (old, recent):
        (folder / "equations").mkdir(parents=True)
    long_ago = time.time() - 2.0 * compiling.LONG_UNUSED
    os.utime(old, (long_ago, long_ago))
    folder = compiling.cache_folder()
    assert folder.parent == tmp_path
    assert sorted(tmp_path.iterdir()) == sorted([folder, recent])


def test_every_folder_with_kernels_is_watched():
    """A kernel elsewhere would be kept although what it calls had changed."""
    for path in PACKAGE.rglob("*.py"):
        imported = {
            alias.name
            for node in ast.walk(ast.parse(path.read_text("utf-8")))
            if isinstance(node, ast.ImportFrom) and node.module == "rotor_ida.equations.compiling"
            for alias in node.names
        }
        if imported - {"cache_folder"}:
            assert path.relative_to(PACKAGE).parts[0] in compiling.KERNEL_FOLDERS, path


def test_a_loop_that_changes_nothing_else_sees_that_it_should_stop():
    """Read as plain memory, `stop` would be read once, before the loop."""

    @compiling.compiled
    def spin(most, stop):
        count = 0
        while count < most and not compiling.asked_to_stop(stop):
            count += 1
        return count

    stop = np.zeros(1, np.uint8)
    assert spin(10, stop) == 10
    most = 10**14
    threading.Timer(0.2, lambda: stop.__setitem__(0, 1)).start()
    assert 0 < spin(most, stop) < most


def test_a_change_in_what_a_kernel_calls_makes_it_anew(tmp_path):
    """numba alone would see no change in the kernel's own file, and keep the old force."""
    copy = tmp_path / "rotor_ida"
    for part in ("equations", "parallel"):
        shutil.copytree(PACKAGE / part, copy / part, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("__init__.py", "__init__.pyi", "parameters.py", "checks.py", "errors.py"):
        shutil.copy(PACKAGE / name, copy)
    program = (
        "import numpy as np\n"
        "from rotor_ida import Rotor\n"
        "from rotor_ida.equations.model import rotating_field\n"
        "print(rotating_field((2.0, 0, 0, 0), Rotor(omega=0.0, zeta=0.0, delta0=1.0))[2])\n"
    )

    def force():
        environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
        done = subprocess.run(
            [sys.executable, "-c", program],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        )
        return float(done.stdout)

    assert force() == -1.0
    law = copy / "equations" / "contact.py"
    law.write_text(law.read_text("utf-8").replace("depth**HERTZ", "2.0 * depth**HERTZ"), "utf-8")
    assert force() == -2.0
