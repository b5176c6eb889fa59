"""Settings for all tests: no timed ones, the same examples on every run, no figure left open."""

import gc
import importlib.util
import signal
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis.strategies import none

from rotor_ida.core.sundials import Unfit

settings.register_profile("rotor_ida", deadline=None, derandomize=True)
settings.load_profile("rotor_ida")

# where a shell starts the tests in the background, SIGINT is ignored, also by what they start
signal.signal(signal.SIGINT, signal.default_int_handler)


# of what collecting the tests makes, nothing is garbage
gc.disable()


# What takes long comes first, so that all workers end together; a worker takes over the last tests
# of another, which here are short, and not those that share a browser or a cluster.
LONG = (
    "explorer/test_page.py", "explorer/test_page_run_ups.py", "explorer/test_page_sheet.py",
    "explorer/test_panels.py", "explorer/test_system_page.py",
    "explorer/test_queues.py", "explorer/test_command.py", "parallel/test_cluster.py",
    "core/test_sanitized.py", "core/test_build.py", "paper/test_scenarios.py", "cli/test_help.py",
)  # fmt: skip


def pytest_sessionstart(session):
    """Import a part of all modules first: what a worker compiles the others then only load."""
    config = session.config
    worker = getattr(config, "workerinput", {"workerid": ""})
    if not worker["workerid"] or config.args != config.getini("testpaths"):
        return
    modules = sorted(Path(__file__).parent.rglob("test_*.py"))
    for path in modules[int(worker["workerid"][2:]) :: worker["workercount"]]:
        name = ".".join(path.relative_to(config.rootpath).with_suffix("").parts)
        with suppress(BaseException):  # the collection reports what cannot be imported
            import_module(name)


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: not item.path.as_posix().endswith(LONG))


def pytest_collection_finish():
    """Leave what is loaded by now, a million objects, out of every later collection of garbage.

    Before that Hypothesis makes its source of randomness: it warns where it cannot see what holds
    that, and nothing that is left out is seen to hold anything.
    """
    given(none())(lambda _: None)()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)
    gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_setup():
    """Skip a test that asks for CVODE or the reference where scikit-sundae has no wheel."""
    try:
        return (yield)
    except (ImportError, Unfit) as error:
        asked = "scikit-sundae" in str(error) or "sksundae" in str(error)
        if asked and importlib.util.find_spec("sksundae") is None:
            pytest.skip("scikit-sundae is not installed")
        raise


pytest_runtest_call = pytest_runtest_setup


@pytest.fixture(autouse=True)
def _no_figure_left_open():
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
