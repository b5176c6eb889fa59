"""What goes beneath each kind of plot, of rotors of each kind: exact, or one line that refuses."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

import rotor_ida
from rotor_ida import Rotor, plot
from rotor_ida.cli.commands.plot import OF_SIGNALS
from rotor_ida.cli.exact import exact_beneath
from rotor_ida.errors import InputError

# A rotor, its start, and how its speed changes: by name what it does.
RUNS = {
    "bounces": (Rotor(omega=2.0, zeta=0.07, delta0=2.0), (2.6, 0.75, 0.66, -1.65), {}),
    "whirls on the ring": (Rotor(omega=1.4, zeta=0.3, delta0=0.5), (0.3, 0, 0, 0), {}),
    # about (0.5, 0.4), which it keeps: a = -omega/(omega - 2 i zeta) = -0.8 - 0.4 i
    "whirls in the clearance": (
        Rotor(omega=2.0, zeta=0.5, delta0=3.0), (-0.3, 0.0, 0.8, -1.6), {},
    ),
    "hangs on its shaft": (
        Rotor(omega=2.5, zeta=0.2, delta0=5.0, shaft_stiffness=0.5, load=0.2), (0, -0.4, 0, 0), {},
    ),
    "lies on the ring": (Rotor(omega=0.5, zeta=0.1, delta0=2.0, load=1.0), (0, -2.9, 0, 0), {}),
    "has dry whip": (
        Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0), (5, 0, 0, -6.3),
        {},
    ),
    "is not damped": (Rotor(omega=2.0, zeta=0.0, delta0=3.0), (0.5, 0, 0, 0), {}),
    "runs up": (Rotor(omega=0.4, zeta=0.07, delta0=0.5), (0.1, 0, 0, 0), {"to": 2.5, "rate": 0.02}),
    "runs up in whip": (
        Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0), (5, 0, 0, -6.3),
        {"to": 0.9, "rate": 0.005},
    ),
    "runs up hanging": (
        Rotor(omega=1.2, zeta=0.2, delta0=6.0, shaft_stiffness=0.5, load=0.2), (0, -0.4, 0, 0),
        {"to": 2.4, "rate": 0.01},
    ),
    "runs up on the ring": (
        Rotor(omega=0.3, zeta=0.1, delta0=2.0, load=1.0), (0, -2.9, 0, 0),
        {"to": 0.8, "rate": 0.01},
    ),
}  # fmt: skip
OVER_SPEED = {"bode", "polar", "orders"}
NOT_KNOWN = {
    # without shaft and load a disc may rest anywhere in the clearance
    "runs up": {"full-spectrum", "centreline"},
    # and a flight ends at the first touch
    "runs up in whip": {"centreline", "trace"},
    "runs up hanging": {"full-spectrum", "cascade", "spectrogram", "trace"},
    "runs up on the ring": OVER_SPEED | {"full-spectrum", "cascade", "spectrogram", "trace"},
}


@cache
def run_of(name: str) -> xr.Dataset:
    rotor, start, change = RUNS[name]
    if change:
        return rotor_ida.run_up(rotor, start=start, samples=6001, **change)
    run = rotor_ida.simulate(rotor, start=start, duration=240.0, samples=6001)
    return run.sel(t=slice(120.0, None))


@cache
def signals_of(name: str) -> xr.Dataset:
    return rotor_ida.signals_of(run_of(name))


@pytest.mark.parametrize(("kind", "name"), list(itertools.product(OF_SIGNALS, RUNS)))
def test_every_kind_of_plot_has_what_is_exact_of_every_rotor(kind: str, name: str):
    run = run_of(name)
    if kind in NOT_KNOWN.get(name, set()):
        with pytest.raises(InputError, match=r"^exact [^\n]*$"):
            exact_beneath(run, kind)
        return
    beneath = exact_beneath(run, kind)
    assert beneath
    draw = getattr(plot, OF_SIGNALS[kind])
    measured = [signals_of(name)] if name in {"bounces", "runs up"} else []
    for signals in (run, *measured):
        with_it, without = draw(signals, beneath=beneath), draw(signals)
        assert len(artists_of(with_it)) > len(artists_of(without))


def artists_of(drawn) -> list[object]:
    axes = drawn.axes if isinstance(drawn, Figure) else [drawn]
    return [each for ax in axes for each in ax.lines]


def test_the_trace_of_a_cycle_lies_on_the_exact_one_in_step():
    drawn = plot.plot_trace(run_of("bounces"), beneath=exact_beneath(run_of("bounces"), "trace"))
    exact = next(line for line in drawn.lines if line.get_label() == "exact cycle")
    run = run_of("bounces")
    x = np.interp(run.t.values, exact.get_xdata(), exact.get_ydata())
    # 1024 points of the cycle, between which it is taken to be straight, and 800 shifts
    assert np.abs(x - run.x.values).max() < 2e-3 * np.abs(run.x.values).max()


@pytest.mark.parametrize("name", ["whirls on the ring", "whirls in the clearance"])
def test_the_trace_of_a_whirl_lies_on_the_exact_one(name: str):
    run = run_of(name)
    drawn = plot.plot_trace(run, names=("x",), beneath=exact_beneath(run, "trace"))
    exact = next(line for line in drawn.lines if line.get_label() == "exact whirl")
    np.testing.assert_allclose(exact.get_ydata(), run.x.values, atol=1e-6)


def test_a_run_up_flies_exactly_until_its_first_touch_and_no_further():
    run = run_of("runs up")
    (flight,) = exact_beneath(run, "trace")
    end = flight.t.values[-1]
    assert 0.0 < run.event_time.values[0] - end <= float(np.diff(run.t.values[:2])[0])
    np.testing.assert_allclose(flight.x, run.x.sel(t=flight.t), atol=1e-9)
    with pytest.raises(InputError, match="ends at the first touch, and these times begin after"):
        exact_beneath(run.sel(t=slice(2.0 * end, None)), "trace")


def test_a_rotor_that_hangs_on_its_shaft_whirls_about_its_place_of_rest():
    """Clear of the ring the equation is linear: -i gamma/kappa and the whirl without load add."""
    run = run_of("hangs on its shaft")
    rotor, _, _ = RUNS["hangs on its shaft"]
    motion, *_ = exact_beneath(run, "full-spectrum")
    kappa, omega, zeta = rotor.shaft_stiffness, rotor.omega, rotor.zeta
    height = omega**2 / np.hypot(kappa - omega**2, 2.0 * zeta * omega)
    np.testing.assert_allclose(motion.whirl_amplitude, [rotor.load / kappa, height], rtol=1e-12)
    radius = np.abs(run.x.values + 1j * (run.y.values + rotor.load / kappa))
    np.testing.assert_allclose(radius, height, rtol=1e-6)
    upper, lower = plot.plot_bode(run, beneath=exact_beneath(run, "bode")).axes
    one = next(line for line in upper.lines if line.get_label() == "1X of exact cycle")
    assert one.get_ydata() == pytest.approx([height])
    lag = np.degrees(np.arctan2(2.0 * zeta * omega, kappa - omega**2))
    assert any(line.get_ydata() == pytest.approx([lag]) for line in lower.lines)


def test_under_a_load_the_curve_ends_where_the_rotor_would_reach_the_ring():
    rotor = Rotor(omega=0.45, zeta=0.1, delta0=2.0, shaft_stiffness=0.5, load=0.3)
    up = rotor_ida.run_up(rotor, start=(0, -0.6, 0, 0), to=2.0, rate=0.01, samples=6001)
    curve, *rest = exact_beneath(up, "bode")
    assert not rest
    room = rotor.delta0 - rotor.load / 0.5
    assert curve.amplitude.values.max() == pytest.approx(room, rel=1e-12)
    omega = curve.omega.values  # none between the two touches
    height = omega**2 / np.hypot(0.5 - omega**2, 2.0 * rotor.zeta * omega)
    assert (height <= room * (1.0 + 1e-9)).all()
    assert (curve.in_contact.values == 0).all()
    assert "limit_cycle" in curve.attrs["not_exact"]


def test_the_lines_of_a_cascade_are_at_its_folds_and_along_its_whip():
    (points,) = exact_beneath(run_of("runs up"), "cascade")
    ax = plot.plot_cascade(run_of("runs up"), beneath=points)
    fold = next(line for line in ax.lines if line.get_label() == "fold")
    assert fold.get_xdata() == pytest.approx(fold.get_ydata())
    assert np.isclose(points.fold_omega.values, fold.get_ydata()[0]).any()
    whips = [each for each in exact_beneath(run_of("runs up in whip"), "cascade")
             if "whirl_speed" in each.variables]  # fmt: skip
    assert len(whips) > 10
    ax = plot.plot_spectrogram(run_of("runs up in whip"), over="t", beneath=whips)
    seen = [line for line in ax.lines if line.get_marker() == "v"]
    times = np.array([line.get_ydata()[0] for line in seen])
    assert np.ptp(times) > 30.0  # each at the time at which the speed is its own


def test_the_centre_line_goes_through_the_exact_centres():
    for name in ("hangs on its shaft", "lies on the ring"):
        run = run_of(name)
        period = 2.0 * np.pi / RUNS[name][0].omega
        times = np.linspace(240.0 - 8.0 * period, 240.0, 4001)
        x, y = (np.interp(times[:-1], run.t.values, run[each].values) for each in ("x", "y"))
        mean = x.mean() + 1j * y.mean()
        ax = plot.plot_centre_line(run, beneath=exact_beneath(run, "centreline"))
        exact = next(line for line in ax.lines if line.get_label() == "mean of exact cycle")
        place = exact.get_xdata()[0] + 1j * exact.get_ydata()[0]
        assert abs(place - mean) < 1e-3  # samples of the run lie 0.02 apart
