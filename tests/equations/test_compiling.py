"""Machine code is kept, and not kept too long."""

import os
import subprocess
import sys
from pathlib import Path

import numba

from rotor_ida.equations import compiling


def test_where_no_folder_can_be_written_kernels_still_run(monkeypatch):
    def nowhere(_kernel):
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(numba.core.dispatcher.Dispatcher, "enable_caching", nowhere)
    assert compiling.compiled(lambda number: number + 1)(2) == 3


def test_a_change_in_what_a_kernel_calls_makes_it_anew(tmp_path):
    """numba alone would see no change in the kernel's own file, and keep the old force."""
    package = Path(compiling.__file__).parents[1]
    copy = tmp_path / "rotor_ida"
    names = ("__init__.py", "__init__.pyi", "parameters.py", "checks.py", "errors.py")
    modules = ("__init__", "compiling", "contact", "model")
    for name in (*names, *(f"equations/{module}.py" for module in modules)):
        target = copy / name
        target.parent.mkdir(exist_ok=True, parents=True)
        target.write_text((package / name).read_text("utf-8"), "utf-8")
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
