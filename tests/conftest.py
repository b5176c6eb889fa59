"""Settings for all tests: no timed ones, the same examples on every run, no figure left open."""

import gc
import sys

import pytest
from hypothesis import settings

settings.register_profile("rotor_ida", deadline=None, derandomize=True)
settings.load_profile("rotor_ida")


def pytest_collection_finish():
    """Leave what is loaded by now, a million objects, out of every later collection of garbage."""
    gc.collect()
    gc.freeze()


@pytest.fixture(autouse=True)
def _no_figure_left_open():
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")
