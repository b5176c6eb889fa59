"""A dataset in SI units is drawn in its units, which stand in the labels; others as ever."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from rotor_ida import (
    DimensionalRotor,
    InputError,
    basin,
    bifurcation_diagram,
    contact_forces,
    dimensional,
    folds,
    lyapunov_exponent,
    poincare_section,
    simulate,
    spectrum,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms import free_periods, jumps, restoring_field
from rotor_ida.plot import (
    plot_amplitude,
    plot_backbone,
    plot_basin,
    plot_by_clearance,
    plot_cuts,
    plot_deviation,
    plot_drawn_out,
    plot_exponents,
    plot_extrema,
    plot_force_peaks,
    plot_forces,
    plot_history,
    plot_jumps,
    plot_orbit,
    plot_over_clearance,
    plot_periods,
    plot_phase,
    plot_rotating_orbit,
    plot_run,
    plot_section,
    plot_solutions,
    plot_spectrum,
    plot_surface,
)
from rotor_ida.plot.labels import IN_UNITS, LABELS, label_of, number_text, unit_of

REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=418.0, eccentricity=5e-6,
                           clearance=1e-5, speed=1495.0)  # fmt: skip
ROTOR = MACHINE.rotor()
UNITS = {"length": "µm", "time": "ms", "velocity": "mm/s"}
MICROMETRES = 1e6 * MACHINE.length_scale
MILLISECONDS = 1e3 * MACHINE.time_scale


def in_units(dataset, **units):
    return dimensional(dataset, MACHINE, units=UNITS | units)


@pytest.fixture(scope="module")
def plain():
    return simulate(ROTOR, start=REST, duration=40.0, samples=2001)


@pytest.fixture(scope="module")
def machine(plain):
    return in_units(plain)


@pytest.fixture(scope="module")
def curves():
    omega = np.linspace(0.1, 2.0, 39)
    return {
        "exact": synchronous_response(omega=omega, zeta=ROTOR.zeta, delta0=0.5),
        "fold_points": folds(zeta=ROTOR.zeta, delta0=0.5),
        "simulated": sweep(omega=[0.4, 0.8], zeta=ROTOR.zeta, delta0=0.5),
    }


@pytest.fixture(scope="module")
def curves_in_units(curves):
    return {name: in_units(dataset) for name, dataset in curves.items()}


def data(ax):
    """Return the points of each line, NaN where there are none."""
    return [np.ma.filled(np.ma.asarray(line.get_xydata(), float), np.nan) for line in ax.lines]


def assert_scaled(ax, plain, across, up):
    """Every line of `ax` is the one of `plain`, times `across` and `up`."""
    assert len(ax.lines) == len(plain.lines) > 0
    for line, other in zip(data(ax), data(plain), strict=True):
        np.testing.assert_allclose(line, other * [across, up], rtol=1e-9, atol=1e-9)


def units_on(ax):
    """Return what stands in brackets at the end of the labels of the axes."""
    labels = (ax.get_xlabel(), ax.get_ylabel())
    return tuple(label.rpartition("[")[2].rstrip("]") if "[" in label else "" for label in labels)


def test_orbits_have_their_ring(plain, machine):
    for plot in (plot_orbit, plot_rotating_orbit):
        ax = plot(machine)
        assert units_on(ax) == ("µm", "µm")
        assert_scaled(ax, plot(plain), MICROMETRES, MICROMETRES)


def test_histories(plain, machine):
    ax = plot_history(machine, "radius")
    assert units_on(ax) == ("ms", "µm")
    assert_scaled(ax, plot_history(plain, "radius"), MILLISECONDS, MICROMETRES)
    solid = plot_drawn_out(machine)
    assert units_on(solid) == ("ms", "µm")
    assert solid.get_zlabel().endswith("[µm]")


def test_run(plain, machine):
    si, bare = plot_run(machine).axes, plot_run(plain).axes
    assert [units_on(ax)[1] for ax in si] == ["µm", "µm", "µm", "N", "µm"]
    assert_scaled(si[3], bare[3], MILLISECONDS, MACHINE.force_scale)
    assert_scaled(si[4], bare[4], MICROMETRES, MICROMETRES)
    shade, other = (axes[2].collections[0].get_paths()[0].vertices[:, 0] for axes in (si, bare))
    np.testing.assert_allclose(shade, other * MILLISECONDS)


def test_plain_si_units_where_no_others_were_chosen(plain):
    ax = plot_orbit(dimensional(plain, MACHINE))
    assert units_on(ax) == ("m", "m")
    assert_scaled(ax, plot_orbit(plain), MACHINE.length_scale, MACHINE.length_scale)


def test_sections_spectra_forces_and_exponents(plain):
    entries = poincare_section(ROTOR, start=REST, revolutions=10, at="entry")
    ax = plot_section(in_units(entries))
    assert units_on(ax)[1] == "mm/s"
    bare, velocity = plot_section(entries), 1e3 * MACHINE.velocity_scale
    assert_scaled(ax, bare, 1.0, velocity)
    np.testing.assert_allclose(ax.get_ylim(), velocity * np.array(bare.get_ylim()))
    turns = poincare_section(ROTOR, start=REST, revolutions=10)
    assert_scaled(plot_section(in_units(turns)), plot_section(turns), MICROMETRES, MICROMETRES)
    steady = turns.isel(crossing=[-1])
    in_metres, bare = plot_section(dimensional(steady, MACHINE)), plot_section(steady)
    np.testing.assert_allclose(
        in_metres.get_ylim(), MACHINE.length_scale * np.array(bare.get_ylim())
    )
    assert units_on(plot_spectrum(in_units(spectrum(plain)))) == ("", "µm")
    forces = contact_forces(plain)
    ax = plot_forces(in_units(forces))
    assert units_on(ax) == ("ms", "N")
    assert_scaled(ax, plot_forces(forces), MILLISECONDS, MACHINE.force_scale)
    assert units_on(plot_force_peaks(in_units(forces, force="kN")))[0] == "kN"
    found = lyapunov_exponent(ROTOR, start=REST, duration=200.0)
    assert units_on(plot_exponents(in_units(found))) == ("ms", "1/s")


def test_responses_with_folds_and_simulations(curves, curves_in_units):
    si = plot_amplitude(**curves_in_units)
    assert units_on(si) == ("", "µm")
    assert_scaled(si, plot_amplitude(**curves), 1.0, MICROMETRES)
    assert_scaled(plot_phase(**curves_in_units), plot_phase(**curves), 1.0, 1.0)


def test_backbone_and_jumps_on_a_response(curves, curves_in_units):
    backbone = free_periods(amplitude=np.linspace(0.6, 2000.0, 50), delta0=0.5)
    jumped = jumps(zeta=ROTOR.zeta, delta0=0.5)
    plain, si = plot_amplitude(curves["exact"]), plot_amplitude(curves_in_units["exact"])
    plot_jumps(jumped, ax=plot_backbone(backbone, ax=plain))
    plot_jumps(in_units(jumped), ax=plot_backbone(in_units(backbone), ax=si))
    assert_scaled(si, plain, 1.0, MICROMETRES)
    assert units_on(plot_backbone(in_units(backbone, length="mm")))[1] == "mm"


def test_clearances_and_extrema(curves_in_units):
    exact = synchronous_response(omega=0.8, zeta=ROTOR.zeta, delta0=[0.0, 0.5, 1.0])
    simulated = sweep(omega=[0.8], zeta=ROTOR.zeta, delta0=[0.5])
    ax = plot_over_clearance(in_units(exact), simulated=in_units(simulated))
    assert units_on(ax) == ("", "µm")
    assert_scaled(ax, plot_over_clearance(exact, simulated=simulated), 1.0, MICROMETRES)
    table = in_units(folds(zeta=0.07, delta0=[0.5, 1.0]))
    ax = plot_by_clearance(table, {"fold_amplitude": "folds"}, label="amplitude")
    assert ax.get_ylabel() == "amplitude [µm]"
    found = bifurcation_diagram(omega=[0.4, 0.8], zeta=ROTOR.zeta, delta0=0.5, starts=[REST])
    ax = plot_extrema(in_units(found), exact=curves_in_units["exact"])
    assert units_on(ax) == ("", "µm")


def test_formulas():
    periods = free_periods(amplitude=[1.0, 2.0], delta0=0.0)
    ax = plot_periods(in_units(periods), simulated=in_units(periods))
    assert units_on(ax) == ("ms", "µm")
    assert units_on(plot_periods(in_units(periods), over="natural"))[0] == "rad/ms"
    field = in_units(restoring_field(x=[-1, 0, 1], y=[0, 2], delta0=0.5))
    ax = plot_cuts(field, "restoring_x", at=[0.0, 10.0])
    assert [line.get_label() for line in ax.lines] == ["$y = 0$ µm", "$y = 10$ µm"]
    assert units_on(ax) == ("µm", "N")
    assert "[N]" in plot_surface(field, "restoring_x").get_title()


def test_basins():
    axis = np.linspace(-3.0, 3.0, 4)
    ax = plot_basin(in_units(basin(ROTOR, x=axis, y=axis)))
    assert units_on(ax) == ("µm", "µm")
    assert all(text.get_text().endswith(" µm") for text in ax.get_legend().get_texts()[:1])


def test_solutions_and_their_deviations(plain):
    table = ("solution", "t"), [[0.0, 1.0, 2.0]]
    line = ("t", [0.5, 0.5, 0.5])
    claimed = xr.Dataset(
        {"x": line, "y": line, "solution_x": table, "solution_y": table},
        {"t": plain.t.values[::1000], "solution": ["as printed"]},
    )
    si = in_units(claimed)
    assert_scaled(plot_solutions(si), plot_solutions(claimed), MILLISECONDS, MICROMETRES)
    assert_scaled(plot_deviation(si), plot_deviation(claimed), MILLISECONDS, MICROMETRES)
    assert units_on(plot_deviation(si)) == ("ms", "µm")


def test_datasets_of_one_picture_have_the_same_units_and_scale(curves, curves_in_units):
    exact = curves_in_units["exact"]
    other = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=418.0, eccentricity=6e-6,
                             clearance=1e-5, speed=1495.0)  # fmt: skip
    for wrong, words in (
        (curves["fold_points"], "dimensionless"),
        (in_units(curves["fold_points"], length="mm"), "0.005 mm"),
        (dimensional(curves["fold_points"], other, units=UNITS), "6.0 um"),
    ):
        with pytest.raises(InputError, match=r"^fold_points must have the length scale and units"
                           rf" of what it is drawn with, 5\.0 um, got {words}$"):  # fmt: skip
            plot_amplitude(exact, fold_points=wrong)
    with pytest.raises(InputError, match=r"simulated must have the length .* dimensionless, got 5"):
        plot_amplitude(curves["exact"], simulated=curves_in_units["simulated"])


def test_what_is_drawn_on_the_same_axes_has_the_same_units(plain, machine):
    ax = plot_orbit(machine)
    assert plot_orbit(machine, ax=ax) is ax
    for other, units in ((in_units(plain, length="nm"), "nm"), (plain, "1")):
        with pytest.raises(InputError, match=rf"must have its units, 'um' .*, got '{units}'$"):
            plot_orbit(other, ax=ax)
    left, right = Figure().subplots(1, 2, sharey=True)
    plot_history(machine, "x", ax=left)
    with pytest.raises(InputError, match="must have its units"):
        plot_history(plain, "y", ax=right)


def test_labels_tell_whether_a_quantity_has_a_unit(plain, machine):
    assert label_of("x", plain.x) == LABELS["x"]
    assert label_of("x", machine.x) == f"{IN_UNITS['x']} [µm]"
    assert label_of("omega", machine.omega) == LABELS["omega"]


@pytest.mark.parametrize(
    ("units", "written"),
    [("um", "µm"), ("s-1", "1/s"), ("um s-1", "µm/s"), ("m s-1", "m/s"), ("uN s", "µN s"),
     ("mm", "mm"), ("1", ""), ("radian", ""), ("", "")],
)  # fmt: skip
def test_units_are_written_as_a_reader_does(units, written):
    assert unit_of(xr.DataArray(1.0, attrs={"units": units})) == written


def test_numbers_far_from_one_are_written_with_a_power_of_ten():
    assert number_text(1.2e-5, "g") == r"1.2 \times 10^{-5}"
    assert number_text(-15.0, "g") == "-15"
