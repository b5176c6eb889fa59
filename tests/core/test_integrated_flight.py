"""Flight that is integrated, as a force without a closed form needs it, is that in closed form."""

import ctypes
import json
import shutil
import subprocess
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core import interface, runs
from rotor_ida.core.runs import COLUMNS, DIFFERENCES, RunRequest, follow_run
from tests.core.test_sanitized import CORE, ROOT, SAID

STATED = "HAS_CLOSED_FLIGHT = !SPEED_CHANGES"
ROTORS = [
    {"shaft_stiffness": 0.2, "contact_damping": 0.1},
    {"load": 0.3},
    {"friction": 0.2, "disc_radius": 2.0},
]


@pytest.fixture(scope="module")
def integrating(tmp_path_factory):
    """Return the core of the whole model, compiled as if its flight had no closed form."""
    if not (ROOT / "hatch_build.py").is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(ROOT / "hatch_build.py"))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    folder: Path = tmp_path_factory.mktemp("integrating")
    for path in CORE.glob("*.[ch]"):
        shutil.copy(path, folder)
    model = (folder / "model.h").read_text("utf-8")
    assert STATED in model
    (folder / "model.h").write_text(model.replace(STATED, "HAS_CLOSED_FLIGHT = 0"), "utf-8")
    words = hatch_build["flags"](compiler, "baseline", model="whole")
    words += ["-O0", "-Wno-psabi", "-shared"]
    words += [f"-DCORE_{name.upper()}={json.dumps(name)}" for name in SAID]
    sources = [str(path) for path in sorted(folder.glob("*.c"))]
    made = str(folder / "integrating.so")
    subprocess.run([*compiler, *words, *sources, "-lm", "-o", made], check=True)
    core = ctypes.CDLL(made)
    own = interface.library("whole").core_run
    core.core_run.restype, core.core_run.argtypes = own.restype, own.argtypes
    return core


@pytest.mark.parametrize("more", ROTORS, ids=lambda more: next(iter(more)))
@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_it_gives_the_same_events_and_differences(monkeypatch, integrating, method, more):
    rows = DIFFERENCES + len(COLUMNS) if method == "taylor" else DIFFERENCES

    def followed():
        bundle = np.zeros((rows, 4))
        bundle[:DIFFERENCES] = np.eye(4)
        result = follow_run(
            RunRequest(
                rotor=Rotor(omega=1.7, zeta=0.07, delta0=0.8, **more),
                start=(0.5, 0.1, 0.4, -0.2), duration=20.0, rtol=1e-11, atol=1e-12,
                method=method, events=True, bundle=bundle,
            )
        )  # fmt: skip
        assert result.status == interface.DONE
        return result, bundle

    expected, grown = followed()
    monkeypatch.setattr(runs, "library_of", lambda *_, **__: integrating)
    found, bundle = followed()
    assert len(expected.event_times) > 3
    np.testing.assert_array_equal(found.event_kinds, expected.event_kinds)
    tolerance = 1e-10 if method == "taylor" else 1e-6
    np.testing.assert_allclose(found.event_times, expected.event_times, atol=tolerance)
    np.testing.assert_allclose(found.state, expected.state, atol=tolerance)
    np.testing.assert_allclose(bundle, grown, atol=100.0 * tolerance)
