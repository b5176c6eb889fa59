"""Run an archived simulation again, from its own attributes, and hold the events against it."""

from __future__ import annotations

from typing import cast

import numpy as np
import xarray as xr

from rotor_ida.checks import State
from rotor_ida.errors import InputError
from rotor_ida.parameters import Rotor
from rotor_ida.simulation import simulate
from rotor_ida.simulator.options import Flight, Method
from rotor_ida.testing import assert_events_close

NEEDED = ("omega", "zeta", "delta0", "start", "duration", "rtol", "atol", "method", "flight")


def rerun(dataset: xr.Dataset) -> xr.Dataset:
    """Simulate a run again, as its own attributes say.

    Parameters
    ----------
    dataset : Dataset
        A run of `rotor_ida.simulate`, for instance one that was loaded from an archive.

    Returns
    -------
    Dataset
        The same run, made anew.

    Raises
    ------
    InputError
        If the dataset is not a run, or its attributes cannot be used.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> from rotor_ida.testing import assert_events_close
    >>> rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    >>> run = simulate(rotor, start=(0, 0, 0, 0), duration=20.0)
    >>> assert_events_close(rerun(run), run)
    """
    missing = [name for name in NEEDED if name not in dataset.attrs]
    missing += [
        name for name in ("event_time", "event_time_error", "time") if name not in dataset.variables
    ]
    if missing:
        raise InputError(f"only a simulated run can be verified; it lacks {', '.join(missing)}")
    settings = dataset.attrs
    if "time_scale" in settings:
        raise InputError("a run in SI units cannot be verified: verify the dimensionless one")
    return simulate(
        Rotor(**{name: settings[name] for name in ("omega", "zeta", "delta0")}),
        start=cast(State, tuple(np.atleast_1d(settings["start"]).tolist())),
        duration=settings["duration"],
        samples=dataset["time"].values,
        rtol=settings["rtol"],
        atol=settings["atol"],
        method=cast(Method, settings["method"]),
        flight=cast(Flight, settings["flight"]),
    )


def differences(again: xr.Dataset, archived: xr.Dataset) -> dict[str, object]:
    """Hold the events of a run made again against those of the archive.

    Parameters
    ----------
    again, archived : Dataset
        The two runs.

    Returns
    -------
    dict
        ``agrees``, the numbers of events, the largest difference of two event times and the
        largest error stated for one [1], and ``trouble``: the first difference in words.

    Examples
    --------
    >>> from rotor_ida import Rotor, simulate
    >>> run = simulate(Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=20.0)
    >>> differences(rerun(run), run)["agrees"]
    True
    """
    trouble = ""
    try:
        assert_events_close(again, archived)
    except AssertionError as difference:
        trouble = "; ".join(str(difference).splitlines()[1:])
    common = min(again.sizes["event"], archived.sizes["event"])
    apart = again["event_time"].values[:common] - archived["event_time"].values[:common]
    stated = archived["event_time_error"].values[:common]
    return {
        "agrees": not trouble,
        "events": int(again.sizes["event"]),
        "archived_events": int(archived.sizes["event"]),
        "largest_difference": float(np.abs(apart).max(initial=0.0)),
        "largest_stated_error": float(stated.max(initial=0.0)),
        "trouble": trouble,
    }
