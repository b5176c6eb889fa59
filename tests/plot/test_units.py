"""A dataset in SI units is drawn in them, and says so; one without is drawn as ever."""

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
)
from rotor_ida.closed_forms import (
    clearance_curve,
    free_periods,
    jumps,
    response_curve,
    restoring_field,
)
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
    plot_machine,
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
from rotor_ida.plot.units import alike, label_of, suited, unit_of

REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=418.0, eccentricity=5e-6,
                           clearance=1e-5, speed=1495.0)  # fmt: skip
ROTOR = MACHINE.rotor()
MICROMETRES = 1e6 * MACHINE.length_scale
MILLISECONDS = 1e3 * MACHINE.time_scale


@pytest.fixture(scope="module")
def plain():
    return simulate(ROTOR, start=REST, duration=40.0, samples=2001)


@pytest.fixture(scope="module")
def machine(plain):
    return dimensional(plain, MACHINE)


@pytest.fixture(scope="module")
def curves():
    return {
        "exact": response_curve(zeta=ROTOR.zeta, delta0=0.5, limits=(0.1, 2.0)),
        "fold_points": folds(zeta=ROTOR.zeta, delta0=0.5),
        "simulated": sweep(omega=[0.4, 0.8], zeta=ROTOR.zeta, delta0=0.5),
    }


def in_si(datasets):
    return {name: dimensional(dataset, MACHINE) for name, dataset in datasets.items()}


def data(ax):
    """Return the points of each line, NaN where there are none."""
    return [np.ma.filled(np.ma.asarray(line.get_xydata(), float), np.nan) for line in ax.lines]


def assert_scaled(ax, plain, across, up):
    """Every line of `ax` is the one of `plain`, times `across` and `up`."""
    assert len(ax.lines) == len(plain.lines) > 0
    for line, other in zip(data(ax), data(plain), strict=True):
        np.testing.assert_allclose(line, other * [across, up], rtol=1e-9, atol=1e-9)


def test_orbits_are_in_micrometres_with_their_ring(plain, machine):
    ax = plot_orbit(machine)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("displacement $X$ [µm]", "displacement $Y$ [µm]")
    assert_scaled(ax, plot_orbit(plain), MICROMETRES, MICROMETRES)
    assert_scaled(
        plot_rotating_orbit(machine), plot_rotating_orbit(plain), MICROMETRES, MICROMETRES
    )
    assert plot_rotating_orbit(machine).get_xlabel().endswith("[µm]")


def test_histories_are_in_micrometres_over_milliseconds(plain, machine):
    ax = plot_history(machine, "radius")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time $T$ [ms]", "radius $|Z|$ [µm]")
    assert_scaled(ax, plot_history(plain, "radius"), MILLISECONDS, MICROMETRES)
    assert plot_drawn_out(machine).get_zlabel() == "$Y$ [µm]"


def test_run_has_one_unit_of_length_and_its_forces_in_newtons(plain, machine):
    si, bare = plot_run(machine).axes, plot_run(plain).axes
    labels = [ax.get_ylabel() for ax in si]
    assert labels == ["$X$ [µm]", "$Y$ [µm]", "$|Z|$ [µm]", "force $F$ [N]",
                      "displacement $Y$ [µm]"]  # fmt: skip
    assert_scaled(si[3], bare[3], MILLISECONDS, MACHINE.force_scale)
    assert_scaled(si[4], bare[4], MICROMETRES, MICROMETRES)
    shade, other = (axes[2].collections[0].get_paths()[0].vertices[:, 0] for axes in (si, bare))
    np.testing.assert_allclose(shade, other * MILLISECONDS)


def test_units_can_be_chosen(plain, machine):
    ax = plot_orbit(machine, units={"length": "mm"})
    assert ax.get_xlabel() == "displacement $X$ [mm]"
    assert_scaled(ax, plot_orbit(plain), 1e-3 * MICROMETRES, 1e-3 * MICROMETRES)
    force = plot_machine(machine, units={"force": "mN", "time": "s"}).axes[2]
    assert force.get_xlabel() == "time $T$ [s]"
    assert force.get_ylabel() == "contact force $F$ [mN]"


def test_unit_that_stands_on_the_axes_is_kept(machine):
    ax = plot_orbit(machine, units={"length": "nm"})
    plot_orbit(machine, ax=ax)
    assert ax.get_xlabel() == "displacement $X$ [nm]"
    left, right = Figure().subplots(1, 2, sharey=True)
    plot_history(machine, "x", units={"length": "mm"}, ax=left)
    assert plot_history(machine, "y", ax=right).get_ylabel() == "displacement $Y$ [mm]"


def test_wrong_units_are_refused(plain, machine):
    with pytest.raises(InputError, match=r"the unit of length must be one of .*, got 'inch'"):
        plot_orbit(machine, units={"length": "inch"})
    with pytest.raises(InputError, match="units must be of length, time"):
        plot_orbit(machine, units={"mass": "kg"})
    with pytest.raises(InputError, match="units must be left out for a dimensionless dataset"):
        plot_orbit(plain, units={"length": "mm"})


def test_sections_spectra_forces_and_exponents(plain):
    entries = poincare_section(ROTOR, start=REST, revolutions=10, at="entry")
    ax = plot_section(dimensional(entries, MACHINE))
    assert ax.get_ylabel().endswith("[mm/s]")
    assert_scaled(ax, plot_section(entries), 1.0, 1e3 * MACHINE.velocity_scale)
    turns = poincare_section(ROTOR, start=REST, revolutions=10)
    ax = plot_section(dimensional(turns, MACHINE))
    assert_scaled(ax, plot_section(turns), MICROMETRES, MICROMETRES)
    lines = spectrum(plain)
    ax = plot_spectrum(dimensional(lines, MACHINE))
    assert ax.get_ylabel() == "whirl amplitude $|c|$ [µm]"
    forces = contact_forces(plain)
    ax = plot_forces(dimensional(forces, MACHINE))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("time $T$ [ms]", "contact force $F$ [N]")
    assert_scaled(ax, plot_forces(forces), MILLISECONDS, MACHINE.force_scale)
    assert plot_force_peaks(dimensional(forces, MACHINE)).get_xlabel() == "peak force $F$ [N]"
    found = lyapunov_exponent(ROTOR, start=REST, duration=200.0)
    assert plot_exponents(dimensional(found, MACHINE)).get_ylabel().endswith("[1/s]")


def test_responses_with_folds_and_simulations(curves):
    si = plot_amplitude(**in_si(curves))
    assert si.get_ylabel() == "amplitude $A$ [µm]"
    assert si.get_xlabel() == r"spin speed $\omega$"
    assert_scaled(si, plot_amplitude(**curves), 1.0, MICROMETRES)
    assert_scaled(plot_phase(**in_si(curves)), plot_phase(**curves), 1.0, 1.0)


def test_what_is_drawn_on_a_response_takes_its_unit(curves):
    backbone = free_periods(amplitude=np.linspace(0.6, 2000.0, 50), delta0=0.5)
    jumped = jumps(zeta=ROTOR.zeta, delta0=0.5)
    plain, si = plot_amplitude(curves["exact"]), plot_amplitude(in_si(curves)["exact"])
    plot_jumps(jumped, ax=plot_backbone(backbone, ax=plain))
    plot_jumps(
        dimensional(jumped, MACHINE), ax=plot_backbone(dimensional(backbone, MACHINE), ax=si)
    )
    assert_scaled(si, plain, 1.0, MICROMETRES)
    assert plot_backbone(dimensional(backbone, MACHINE)).get_ylabel() == "amplitude $A$ [mm]"


def test_clearances_periods_fields_extrema_and_basins(curves):
    exact = clearance_curve(omega=0.8, zeta=ROTOR.zeta, limits=(0.0, 1.0))
    simulated = sweep(omega=[0.8], zeta=ROTOR.zeta, delta0=[0.5])
    ax = plot_over_clearance(dimensional(exact, MACHINE), simulated=dimensional(simulated, MACHINE))
    assert ax.get_ylabel() == "amplitude $A$ [µm]"
    assert_scaled(ax, plot_over_clearance(exact, simulated=simulated), 1.0, MICROMETRES)
    table = dimensional(folds(zeta=0.07, delta0=[0.5, 1.0]), MACHINE)
    ax = plot_by_clearance(table, {"fold_amplitude": "folds"}, label="amplitude")
    assert ax.get_ylabel() == "amplitude [µm]"
    periods = free_periods(amplitude=[1.0, 2.0], delta0=0.0)
    ax = plot_periods(dimensional(periods, MACHINE), simulated=dimensional(periods, MACHINE))
    assert ax.get_xlabel() == "period $T$ [ms]"
    field = dimensional(restoring_field(x=[-1, 0, 1], y=[0, 2], delta0=0.5), MACHINE)
    ax = plot_cuts(field, "restoring_x", at=[0.0, 1e-5])
    assert [text.get_text() for text in ax.get_legend().get_texts()] == [
        "$y = 0$ µm",
        "$y = 10$ µm",
    ]
    assert "[N]" in plot_surface(field, "restoring_x").get_title()
    found = bifurcation_diagram(omega=[0.4, 0.8], zeta=ROTOR.zeta, delta0=0.5, starts=[REST])
    ax = plot_extrema(dimensional(found, MACHINE), exact=in_si(curves)["exact"])
    assert ax.get_ylabel() == "radius $|Z|$ [µm]"
    axis = np.linspace(-3.0, 3.0, 4)
    ax = plot_basin(dimensional(basin(ROTOR, x=axis, y=axis), MACHINE))
    assert ax.get_xlabel() == "displacement $X$ [µm]"
    assert all("µm" in text.get_text() for text in ax.get_legend().get_texts()[:1])


def test_solutions_and_their_deviations(plain):
    times = plain.t.values[::1000]
    table = ("solution", "t"), [[0.0, 1.0, 2.0]]
    line = ("t", [0.5, 0.5, 0.5])
    claimed = xr.Dataset(
        {"x": line, "y": line, "solution_x": table, "solution_y": table},
        {"t": times, "solution": ["as printed"]},
    )
    for name in ("x", "y", "solution_x", "solution_y", "t"):
        claimed[name].attrs["units"] = "1"
    si = dimensional(claimed, MACHINE)
    assert_scaled(plot_solutions(si), plot_solutions(claimed), MILLISECONDS, MICROMETRES)
    assert_scaled(plot_deviation(si), plot_deviation(claimed), MILLISECONDS, MICROMETRES)
    assert plot_deviation(si).get_ylabel() == "distance from the simulated $Z$ [µm]"


def test_mixed_units_are_refused(curves):
    si = in_si(curves)
    with pytest.raises(InputError, match="fold_points must have the length scale"):
        plot_amplitude(si["exact"], fold_points=curves["fold_points"])
    with pytest.raises(InputError, match="simulated must have the length scale"):
        plot_amplitude(curves["exact"], simulated=si["simulated"])


def test_dimensionless_dataset_is_drawn_as_it_is(plain):
    assert suited(plain, ["x"]) is plain
    assert alike("plain", plain, plain) is plain
    assert label_of("x", plain["x"]) == "displacement $x$"
    assert unit_of(plain["x"]) == ""


@pytest.mark.parametrize(
    ("largest", "unit"),
    [(0.0, "m"), (999.0, "m"), (1000.0, "km"), (0.999, "mm"), (1e-3, "mm"), (2e-8, "nm"),
     (1e-20, "pm"), (1e12, "Mm")],
)  # fmt: skip
def test_prefix_suits_the_largest_value(machine, largest, unit):
    shown = suited(machine.assign(x=machine.x * 0.0 + largest).assign(
        x=lambda each: each.x.assign_attrs(machine.x.attrs)), ["x"])  # fmt: skip
    assert unit_of(shown["x"]) == unit
    again = suited(shown, ["x"])
    assert unit_of(again["x"]) == unit
    np.testing.assert_allclose(again["x"], shown["x"], rtol=1e-15)
    assert again.attrs["length_scale"] == pytest.approx(shown.attrs["length_scale"], rel=1e-15)
