"""Settings for all tests: no timed ones, the same examples on every run, no figure left open."""

import gc
import signal
import sys

import pytest
from hypothesis import settings

settings.register_profile("rotor_ida", deadline=None, derandomize=True)
settings.load_profile("rotor_ida")

# where a shell starts the tests in the background, SIGINT is ignored, also by what they start
signal.signal(signal.SIGINT, signal.default_int_handler)


# What takes long comes first, so that all workers end together; a worker takes over the last tests
# of another, which here are short, and not those that share a browser or a cluster.
LONG = (
    "explorer/test_page.py", "explorer/test_panels.py", "explorer/test_server.py",
    "explorer/test_queues.py", "explorer/test_command.py", "parallel/test_cluster.py",
    "core/test_sanitized.py", "core/test_build.py", "paper/test_scenarios.py", "cli/test_help.py",
)  # fmt: skip


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: not item.path.as_posix().endswith(LONG))


def pytest_collection_finish():
    """Leave what is loaded by now, a million objects, out of every later collection of garbage."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _no_figure_left_open():
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
