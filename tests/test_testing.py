"""assert_events_close: it passes what agrees, and names the first thing that does not."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida.testing import assert_events_close


def events(times, kinds, errors=None):
    variables = {"event_time": ("event", np.array(times)), "event_kind": ("event", np.array(kinds))}
    if errors is not None:
        variables["event_time_error"] = ("event", np.array(errors))
    return xr.Dataset(variables)


THREE = events([1.0, 2.0, 3.0], [1, -1, 1])


def test_equal_events_pass_and_stated_errors_are_added_up():
    assert_events_close(THREE, THREE)
    actual = events([1.0, 2.0, 3.0 + 1.5e-6], [1, -1, 1], [1e-9, 1e-9, 1e-6])
    expected = events([1.0, 2.0, 3.0], [1, -1, 1], [1e-9, 1e-9, 1e-6])
    assert_events_close(actual, expected)
    with pytest.raises(AssertionError, match="First difference: event 2, entry"):
        assert_events_close(actual, THREE)


def test_a_missing_event_and_a_wrong_kind_are_named():
    with pytest.raises(AssertionError, match=r"actual 2, expected 3[^$]*expected entry at 3\.0"):
        assert_events_close(THREE.isel(event=slice(2)), THREE, atol=1.0)
    other = events([1.0, 2.0, 3.0], [1, 1, -1])
    with pytest.raises(AssertionError, match="event 1, entry instead of exit"):
        assert_events_close(other, THREE, atol=1.0)


def test_nothing_is_close_to_nan():
    with pytest.raises(AssertionError):
        assert_events_close(events([np.nan], [1]), events([1.0], [1]), atol=1.0)
    assert_events_close(events([], []), events([], []))


def test_rtol_widens_with_time():
    assert_events_close(events([100.0], [1]), events([100.0 + 1e-5], [1]), rtol=1e-6)
