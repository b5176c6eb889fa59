"""Units in labels, titles and legends; a dataset in other units than what is drawn is refused."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    continue_attractors,
    dimensional,
    run_ups,
    sweep,
)
from rotor_ida.plot import (
    plot_amplitude,
    plot_attractor_map,
    plot_largest_force,
    plot_orbit,
    plot_run,
    plot_trace,
)
from rotor_ida.plot.figures import figure_of
from rotor_ida.plot.labels import LABELS
from tests.plot.pictures import MACHINE, made

UNITS = {"length": "µm", "time": "ms", "velocity": "mm/s"}


def in_units(dataset, **units):
    return dimensional(dataset, MACHINE, units=UNITS | units)


@pytest.fixture(scope="module")
def plain():
    return made("run")


@pytest.fixture(scope="module")
def machine(plain):
    return in_units(plain)


def test_every_panel_of_a_run_has_its_unit(plain, machine):
    si, bare = plot_run(machine).axes, plot_run(plain).axes
    assert [ax.get_ylabel().rpartition("[")[2] for ax in si] == ["µm]", "µm]", "N]", "µm]"]
    shade, other = (axes[1].collections[0].get_paths()[0].vertices[:, 0] for axes in (si, bare))
    np.testing.assert_allclose(shade, other * 1e3 * MACHINE.time_scale)
    peaks, bare_peaks = (axes[2].lines[0].get_ydata() for axes in (si, bare))
    np.testing.assert_allclose(peaks, bare_peaks * MACHINE.force_scale, atol=1e-12)


def test_si_units_have_the_prefix_of_a_machine(plain):
    ax = plot_orbit(dimensional(plain, MACHINE))
    assert ax.get_xlabel().endswith("[µm]")
    lengths = 1e6 * MACHINE.length_scale * np.array(plot_orbit(plain).dataLim.bounds)
    np.testing.assert_allclose(ax.dataLim.bounds, lengths)
    figure = plot_run(dimensional(plain, replace(MACHINE, contact_stiffness=1e12)))
    found = [ax.get_ylabel().rpartition("[")[2] for ax in figure.axes]
    assert found == ["µm]", "µm]", "kN]", "µm]"]


def test_other_prefixes_of_one_machine_share_axes(plain):
    """Metres and micrometres of one machine are both shown in micrometres."""
    micro = dimensional(plain, MACHINE, units={"length": "um"})
    ax = plot_orbit(micro)
    plot_orbit(dimensional(plain, MACHINE), ax=ax)
    first, second = (line.get_xdata() for line in ax.lines if line.get_label() == "start")
    np.testing.assert_allclose(first, second)


def test_datasets_of_one_picture_have_the_same_units_and_scale():
    curve, folds = made("curve"), made("folds")
    exact = in_units(curve)
    other = DimensionalRotor(**{**MACHINE.given, "eccentricity": 6e-6})
    for wrong, words in (
        (folds, "dimensionless"),
        (in_units(folds, length="mm"), "0.005 mm"),
        (dimensional(folds, other, units=UNITS), "6.0 um"),
    ):
        with pytest.raises(InputError, match=r"^fold_points must have the length scale and units"
                           rf" of what it is drawn with, 5\.0 um, got {words}$"):  # fmt: skip
            plot_amplitude(exact, fold_points=wrong)
    with pytest.raises(InputError, match=r"simulated must have the length .* dimensionless, got 5"):
        plot_amplitude(curve, simulated=in_units(made("sweep")))


def test_what_is_drawn_on_the_same_axes_has_the_same_units(plain, machine):
    ax = plot_orbit(machine)
    assert plot_orbit(machine, ax=ax) is ax
    for other, units in ((in_units(plain, length="nm"), "nm"), (plain, "1")):
        with pytest.raises(InputError, match=rf"must have its units, 'um' .*, got '{units}'$"):
            plot_orbit(other, ax=ax)
    left, right = Figure().subplots(1, 2, sharey=True)
    plot_trace(machine, ax=left)
    with pytest.raises(InputError, match="must have its units"):
        plot_trace(plain, ax=right)


def test_the_speeds_of_a_machine_are_in_rpm():
    curve = made("curve")
    ax, bare = (plot_amplitude(each) for each in (dimensional(curve, MACHINE), curve))
    assert (ax.get_xlabel(), bare.get_xlabel()) == ("spin speed [rpm]", LABELS["omega"])
    np.testing.assert_array_equal(ax.lines[0].get_xdata(), bare.lines[0].get_xdata())
    rpm = ax.get_xticks() * MACHINE.reference_frequency * 30.0 / np.pi
    texts = [text.get_text() for text in ax.get_xticklabels()]
    assert len(set(texts)) == len(texts) > 3
    np.testing.assert_allclose([float(text) for text in texts], rpm, rtol=1e-5)
    assert all(float(text) % 100.0 == 0.0 for text in texts)


def test_the_rates_of_run_ups_of_a_machine_are_in_rpm_per_second():
    found = run_ups(omega=0.3, to=1.6, rate=[0.03, 0.3], zeta=0.1, delta0=1.0)
    ax = plot_largest_force(dimensional(found, MACHINE))
    assert ax.get_xlabel().endswith("[rpm/s]")
    rates = found.rate.values * MACHINE.reference_frequency**2 * 30.0 / np.pi
    np.testing.assert_allclose(ax.lines[0].get_xdata(), rates)


@pytest.mark.parametrize("units", [{}, {"length": "mm"}])
def test_a_sweep_of_a_machine_has_the_exact_curve_behind_it(units):
    rotor = MACHINE.rotor()
    found = sweep(omega=[0.5, 1.0, 1.5], zeta=rotor.zeta, delta0=rotor.delta0, method="taylor")
    (ax,) = figure_of(dimensional(found, MACHINE, units=units)).axes
    words = [text.get_text() for text in ax.get_legend().get_texts()]
    assert "stable whirl" in words
    assert ax.get_ylabel().endswith("[mm]" if units else "[µm]")


def test_a_map_and_a_curve_of_a_machine_are_over_its_units():
    found = continue_attractors(
        Rotor(omega=1.6, zeta=0.07, delta0=0.0), omega=[1.6, 1.8], delta0=[0.0, 0.5],
        x=(-15, 15), y=(-15, 15), starts=10,
    )  # fmt: skip
    for by in ("kind", "force"):
        ax = plot_attractor_map(dimensional(found, MACHINE), by=by)
        assert ax.get_xlabel() == "spin speed [rpm]"
        assert ax.get_ylabel() == "clearance [µm]"
        ax.figure.draw_without_rendering()
        ticks = [float(text.get_text()) for text in ax.get_yticklabels()]
        np.testing.assert_allclose(ticks, 1e6 * MACHINE.length_scale * ax.get_yticks(), rtol=1e-5)
    bar = ax.figure.axes[-1]
    plain = plot_attractor_map(found, by="force").figure.axes[-1]
    np.testing.assert_allclose(bar.get_ylim()[1], plain.get_ylim()[1] * MACHINE.force_scale)
    assert bar.get_ylabel() == "largest contact force [N]"
