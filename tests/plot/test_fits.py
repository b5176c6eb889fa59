"""The picture of a fit shows the numbers of its dataset, in the units of the signals."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    dimensional,
    fit,
    run_up,
    signals_of,
)
from rotor_ida.plot import fit_figure, plot_fit, plot_fit_residuals
from rotor_ida.units import SPEED_UNITS

ROTOR = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
SOUGHT = ["zeta", "delta0", "shaft_stiffness"]


@pytest.fixture(scope="module")
def run():
    return run_up(ROTOR, start=(0, 0, 0, 0), to=2.0, rate=0.02, samples=2501)


@pytest.fixture(scope="module")
def seen(run):
    rng = np.random.default_rng(3)
    held = signals_of(run).copy(deep=True)
    for probe in (held.x, held.y):
        probe.values += rng.normal(0.0, 0.02, probe.size)
    return held


@pytest.fixture(scope="module")
def found(seen):
    return fit(seen, ROTOR, SOUGHT, orders=(1, 2))


def test_measured_and_fitted_amplitudes_are_drawn(found):
    amplitude, phase = plot_fit(found).axes
    fitted, measured = amplitude.lines[:2]
    one = found.sel(order=1)
    np.testing.assert_array_equal(fitted.get_ydata(), one.fitted_forward_whirl_amplitude)
    np.testing.assert_array_equal(measured.get_ydata(), one.forward_whirl_amplitude)
    np.testing.assert_array_equal(fitted.get_xdata(), one.speed)
    lag = np.radians(phase.lines[0].get_ydata())
    turned = np.exp(1j * lag) / np.exp(1j * one.fitted_forward_phase_lag.values)
    np.testing.assert_allclose(turned, 1.0, atol=1e-12)


def test_residuals_are_those_of_both_components(found):
    one = found.sel(order=2)
    ax = plot_fit_residuals(found, order=2)
    along, across = (line.get_ydata() for line in ax.lines[1:3])
    # no error is shared, so the residuals are those of the amplitudes
    both = [
        one[f"{words}forward_whirl_amplitude"] * np.exp(-1j * one[f"{words}forward_phase_lag"])
        for words in ("", "fitted_")
    ]
    left = (both[0] - both[1]) / one.forward_amplitude_error
    np.testing.assert_allclose(along + 1j * across, left.values, atol=1e-12)


def test_contact_times_have_a_panel_and_those_left_out_are_hollow(run, seen):
    entry = run.event_time.values[run.event_kind.values == 1][0]
    compared = fit(seen, ROTOR, SOUGHT, entries=[entry], time_error=0.01)
    panel = fit_figure(compared).axes[3]
    assert panel.get_ylabel().startswith("fitted less measured")
    (drawn,) = panel.get_legend().get_texts()
    assert drawn.get_text() == "entries"
    hollow = compared.assign(compared=compared.compared * 0)
    (drawn,) = fit_figure(hollow).axes[3].get_legend().get_texts()
    assert drawn.get_text() == "entries, not compared"


def test_the_title_has_values_with_errors_in_units_of_the_field():
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5, clearance=2.5e-5,
        speed=31.416, shaft_stiffness=5e4,
    )  # fmt: skip
    rpm = SPEED_UNITS["rpm"]
    up = run_up(machine, to=1500.0 * rpm, rate=300.0 * rpm, samples=4001)
    seen = signals_of(dimensional(up, units={"length": "µm"}))
    figure = fit_figure(fit(seen, machine, ["clearance", "damping"], noise=1.0))
    title = figure.get_suptitle()
    assert re.match(r"clearance \$2[45]\.\d+\(\d+\)\$ µm;", title)
    assert re.search(r"damping \$8\d\.\d+\(\d+\)\$ N s/m", title)
    assert "µm" in figure.axes[0].get_ylabel()
    assert "rpm" in figure.axes[2].get_xlabel()


def test_an_order_that_was_not_compared_is_refused(found):
    with pytest.raises(InputError, match=r"order must be one of those compared, 1, 2,"):
        plot_fit(found, order=3.0)


def test_each_node_of_a_system_has_its_column(run, seen):
    """Two probes of one disc stand for those of two nodes."""
    both = {"inner": seen, "outer": seen}
    body = ROTOR.system()
    system = RotorSystem(
        mass=np.eye(4), damping=0.2 * np.eye(4), stiffness=np.eye(4), units="1",
        nodes={"inner": (0, 1), "outer": (2, 3)},
        contacts=[replace(body.contacts[0], node=node) for node in ("inner", "outer")],
        unbalance=[Unbalance(node=node, moment=1.0) for node in ("inner", "outer")],
    )  # fmt: skip
    found = fit(both, system, ["damping"], start="rest")
    figure = fit_figure(found)
    assert len(figure.axes) == 6
    assert [ax.get_title() for ax in figure.axes[::3]] == ["inner", "outer"]
    assert figure.get_suptitle().startswith("damping factor")
    outer = found.isel(window=found.node.values == "outer").sel(order=1)
    drawn = plot_fit(found, node="outer").axes[0].lines[0]
    np.testing.assert_array_equal(drawn.get_ydata(), outer.fitted_forward_whirl_amplitude)
    with pytest.raises(InputError, match=r"node must be 'inner' or 'outer', got 'disc'"):
        plot_fit_residuals(found, node="disc")
