"""Signals with odd arrays or attributes are refused by name, in every function that reads them."""

from __future__ import annotations

import re
from collections.abc import Callable
from itertools import product

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import InputError, Rotor, plot

TIMES = np.arange(400) / 100.0
SPEED = 20.0
WITH_ANGLE = xr.Dataset(
    {
        "x": ("t", np.cos(SPEED * TIMES)),
        "y": ("t", np.sin(SPEED * TIMES)),
        "angle": ("t", SPEED * TIMES),
    },
    {"t": TIMES},
)
PULSES = np.arange(0.05, 4.0, 2.0 * np.pi / SPEED)
WITH_PULSES = WITH_ANGLE.drop_vars("angle").assign(keyphasor=("pulse", PULSES))
WITH_SPEED = WITH_ANGLE.drop_vars("angle").assign(omega=SPEED)
OF_VARIABLE = {"x": WITH_ANGLE, "t": WITH_ANGLE, "angle": WITH_ANGLE, "keyphasor": WITH_PULSES}

FUNCTIONS: dict[str, Callable[[xr.Dataset], object]] = {
    "orders": rotor_ida.orders,
    "bode_peaks": rotor_ida.bode_peaks,
    "centre_line": rotor_ida.centre_line,
    "whirl_ratio": rotor_ida.whirl_ratio,
    "full_spectrum": rotor_ida.full_spectrum,
    "spectrogram": lambda signals: rotor_ida.spectrogram(signals, segment=32),
    "spectral_lines": lambda signals: rotor_ida.spectral_lines(signals, count=1),
    "filtered_orbit": lambda signals: rotor_ida.filtered_orbit(signals, order=1),
    "a band": lambda signals: rotor_ida.filtered_orbit(signals, band=(5, 30)),
    "correct_probes": rotor_ida.correct_probes,
    "subtract_runout": lambda signals: rotor_ida.subtract_runout(signals, WITH_ANGLE),
    "a slow roll": lambda signals: rotor_ida.subtract_runout(WITH_ANGLE, signals),
    "signals_of": rotor_ida.signals_of,
    "fit": lambda signals: rotor_ida.fit(signals, Rotor(omega=1.0, zeta=0.1, delta0=1.0), ["zeta"]),
    **{
        name: getattr(plot, name)
        for name in (
            *("plot_orbit", "plot_trace", "plot_bode", "plot_polar", "plot_orders"),
            *("plot_centre_line", "plot_full_spectrum", "plot_spectrogram", "plot_cascade"),
        )
    },
}


def delays_of(values: np.ndarray) -> np.ndarray:
    """Return numbers of seconds as durations."""
    return (1e9 * values).astype("timedelta64[ns]")


ODD: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    **{
        f"{number} at {place}": lambda values, number=number, place=place: np.where(
            np.arange(values.size) == place % values.size, number, values
        )
        for number, place in ((np.nan, 0), (np.nan, 7), (np.inf, 7), (-np.inf, -1), (1e308, 0))
    },
    "nan everywhere": lambda values: np.nan * values,
    "text": lambda values: values.astype(str),
    "bytes": lambda values: values.astype("S"),
    "objects": lambda values: np.array(["a"] * values.size, dtype=object),
    "complex": lambda values: values + 1j,
    "flags": lambda values: values > 0.0,
    "dates": lambda values: np.datetime64("2020-01-01", "ns") + delays_of(values),
    "delays": delays_of,
}


def with_values(name: str, values: object, dims: object = None) -> xr.Dataset:
    """Return signals with other values of a variable, perhaps on other dimensions."""
    signals = OF_VARIABLE[name]
    variable = (signals[name].dims if dims is None else dims, values)
    if name == "t":
        return signals.assign_coords(t=variable)
    return signals.drop_vars(name).assign({name: variable})


def refused_by_all(signals: xr.Dataset, told: str, *, but: tuple[str, ...] = ()) -> None:
    """Check that each function refuses the signals in one short line that contains some words."""
    for name, function in FUNCTIONS.items():
        if name not in but:
            with pytest.raises(InputError) as raised:
                function(signals)
            message = str(raised.value)
            assert told in message, (name, message)
            assert "\n" not in message
            assert len(message) < 300
    plt.close("all")


@pytest.mark.parametrize("name", OF_VARIABLE)
def test_values_that_are_no_finite_numbers_are_refused(name):
    """All kinds of them by one function, and two kinds by all functions."""
    for kind, odd in ODD.items():
        signals = with_values(name, odd(OF_VARIABLE[name][name].values))
        with pytest.raises(InputError, match=f"{name} of "):
            rotor_ida.orders(signals)
        if kind in ("nan at 7", "objects"):
            # a trace has no pulses
            refused_by_all(signals, f"{name} of ", but=("plot_trace",) * (name == "keyphasor"))


@pytest.mark.parametrize(
    ("name", "values", "dims", "told"),
    [
        ("keyphasor", np.stack([PULSES, PULSES]), ("a", "b"), "on pulse alone, got it on a and b"),
        ("keyphasor", 1.0, (), "must be on pulse alone, got it on no dimension"),
        ("keyphasor", TIMES, ("t",), "keyphasor of "),
        ("keyphasor", np.empty(0), ("pulse",), "at least 3 pulses, got 0"),
        ("angle", 1.0, (), "must be on t alone, got it on no dimension"),
        ("angle", SPEED * TIMES, ("other",), "must be on t alone, got it on other"),
        ("angle", np.zeros((400, 2)), ("t", "probe"), "must be on t alone, got it on t and probe"),
        ("x", np.zeros((400, 2)), ("t", "probe"), "must be on t alone, got it on t and probe"),
    ],
)
def test_arrays_of_a_wrong_shape_are_refused(name, values, dims, told):
    but = ("plot_trace",) if name == "keyphasor" else ()
    refused_by_all(with_values(name, values, dims), told, but=but)


ATTRIBUTES = {
    "pulses_per_revolution must be": (
        lambda odd: WITH_PULSES.assign_attrs(pulses_per_revolution=odd),
        [1.5, 2.0, 0, -1, "1", np.nan, np.inf, None, [1, 2], True, 10**9],
    ),
    "time_scale must ": (
        lambda odd: WITH_SPEED.assign_attrs(time_scale=odd),
        [0, -1.0, "1", "a", np.nan, np.inf, [1, 2], 1j, 1e-300, 1e300],
    ),
    "omega ": (
        lambda odd: WITH_SPEED.assign(omega=odd),
        [-1.0, "a", np.nan, np.inf, 1j, True, np.datetime64("2020-01-01")],
    ),
    **{
        f" of {name} of ": (
            lambda odd, name=name: WITH_ANGLE.assign_coords(
                {name: WITH_ANGLE[name].assign_attrs(units=odd)}
            ),
            [5, None, ["s"], np.arange(3), "s\nm"],
        )
        for name in ("t", "x")
    },
}


@pytest.mark.parametrize("told", ATTRIBUTES)
def test_odd_attributes_and_speeds_are_refused(told):
    """All of them by one function, and the first by all functions."""
    with_odd, values = ATTRIBUTES[told]
    refused_by_all(with_odd(values[0]), told, but=("plot_trace",) * (told != "omega "))
    for odd in values[1:]:
        with pytest.raises(InputError, match=re.escape(told)):
            rotor_ida.orders(with_odd(odd))


@pytest.mark.parametrize("kind", [np.float32, np.longdouble, object])
def test_numbers_of_other_types_are_used(kind):
    for name in OF_VARIABLE:
        signals = with_values(name, OF_VARIABLE[name][name].values.astype(kind))
        found = rotor_ida.orders(signals).sel(order=1)
        np.testing.assert_allclose(found.forward_whirl_amplitude, 1.0, rtol=1e-4)


RUN = rotor_ida.simulate(
    Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(2.6, 0.75, 0.66, -1.65), duration=20.0,
    samples=401,
)  # fmt: skip
OF_RUN = {
    "rotating": (rotor_ida.rotating, ("t", "x", "vy", "event_time", "event_x")),
    "contact_forces": (rotor_ida.contact_forces, ("t", "x", "vy")),
    "signals_of": (rotor_ida.signals_of, ("t", "x", "vx")),
    "plot_run": (plot.plot_run, ("t", "x", "vx", "event_time", "event_x", "event_kind")),
}


@pytest.mark.parametrize("name", OF_RUN)
def test_runs_whose_values_are_no_finite_numbers_are_refused(name):
    function, needed = OF_RUN[name]
    for variable, make in product(needed, ODD.values()):
        odd = RUN.assign_coords if variable in RUN.coords else RUN.assign
        values = make(RUN[variable].values.astype(float))
        with pytest.raises(InputError, match=f"{variable} of run must |got words in {variable}:"):
            function(odd({variable: (RUN[variable].dims, values)}))
    plt.close("all")
