"""Units are chosen once; the dataset carries them, and what a dimensionless 1 is in them."""

import math
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    DimensionalRotor,
    InputError,
    bifurcation_diagram,
    branches_through,
    compare,
    contact_forces,
    contact_summary,
    continue_cycle,
    dimensional,
    load,
    rotating,
    run_up,
    save,
    simulate,
    sweep,
)
from rotor_ida.cli.describe import describe
from rotor_ida.closed_forms import cusp, peaks, sommerfeld_curve
from rotor_ida.plot import plot_extrema
from rotor_ida.results.si_units import VALUES_OF, dimensionless, si_of
from rotor_ida.schema import QUANTITIES, labelled
from rotor_ida.schema.quantities import UNITS
from tests.witness import HOW, Disc, followed, in_units

REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=418.0, eccentricity=5e-6,
                           clearance=1e-5, speed=1495.0)  # fmt: skip


@pytest.fixture(scope="module")
def plain():
    return simulate(MACHINE.rotor(), start=REST, duration=20.0, samples=201)


@pytest.mark.parametrize("analysed", [lambda run: run, contact_forces])
def test_every_quantity_has_the_unit_and_the_scale_of_its_kind(plain, analysed):
    chosen = {"length": "um", "time": "ms", "velocity": "mm s-1", "force": "kN", "impulse": "mN s"}
    as_read = chosen | {"length": "\u03bcm", "velocity": "mm/s"}
    plain = analysed(plain)
    shown = dimensional(plain, MACHINE, units=as_read)
    for name, variable in plain.variables.items():
        kind = QUANTITIES[name].scale
        if kind:
            assert shown[name].attrs["units"] == (UNITS | chosen)[kind]
            assert shown[name].values == pytest.approx(
                variable.values * shown.attrs[f"{kind}_scale"], rel=1e-15, nan_ok=True
            )
        else:
            assert shown[name].identical(plain[name].assign_coords(shown[name].coords))


def test_the_torque_of_a_whirl_in_si_units_does_the_work_of_damping():
    """Power balance in SI units: torque times speed is the damping times (amplitude speed)^2."""
    curve = sommerfeld_curve(MACHINE.rotor(), limits=(0.5, 3.0), inertia=20.0, slope=0.3)
    shown = dimensional(curve, MACHINE)
    speed = curve.omega * math.sqrt(1e9 * math.sqrt(5e-6) / 4.0)
    np.testing.assert_allclose(shown.torque, 418.0 * shown.amplitude**2 * speed, rtol=1e-13)
    assert shown.torque.attrs["units"] == "N m"
    assert shown.attrs["slope"] == pytest.approx(
        0.3 * 4.0 * 5e-6**2 * math.sqrt(1e9 * math.sqrt(5e-6) / 4.0), rel=1e-14
    )
    assert shown.attrs["slope_units"] == "N m s"
    assert dimensionless(shown).attrs["slope"] == 0.3


def test_peaks_and_cusps_of_a_machine_are_read_in_its_units():
    reference = math.sqrt(1e9 * math.sqrt(5e-6) / 4.0)
    peak = dimensional(peaks(MACHINE.rotor()), MACHINE)
    ends = dimensional(cusp(delta0=2.0), MACHINE)
    label, scale = si_of(peak, "peak_omega")
    assert (label, scale) == ("peak speed [rpm]", pytest.approx(reference * 30.0 / math.pi))
    assert si_of(ends, "cusp_zeta") == (
        "cusp damping [N s/m]", pytest.approx(2.0 * 4.0 * reference, rel=1e-14)
    )  # fmt: skip
    assert si_of(ends, "cusp_omega")[0] == "cusp speed [rpm]"
    for name in (name for name in VALUES_OF if VALUES_OF[name] == "omega"):
        assert QUANTITIES[name].long_name.endswith("over the reference frequency")


def test_parameters_beyond_the_papers_stay_and_forces_follow_the_contact_law():
    """A linear spring of k newtons a metre: forces in units of k D, times of sqrt(m/k)."""
    machine = DimensionalRotor(mass=4.0, contact_stiffness=4e6, damping=400.0, eccentricity=5e-6,
                               clearance=1e-5, speed=1200.0, contact_exponent=1.0,
                               shaft_stiffness=1e6, load=39.2, contact_damping=20.0)  # fmt: skip
    run = simulate(machine.rotor(), start=REST, duration=10.0, samples=21)
    run = run.assign(contact_loss=labelled("contact_loss", "contact", run.peak_force.values))
    shown = dimensional(run, machine, units={"force": "kN"})
    for name, value in machine.rotor().beyond.items():
        assert shown[name].item() == run[name].item() == value
        assert (shown[name].attrs["units"], shown.attrs[name]) == ("1", value)
    assert shown.attrs["force_scale"] == pytest.approx(4e6 * 5e-6 / 1e3, rel=1e-15)
    assert shown.attrs["time_scale"] == pytest.approx(1e-3, rel=1e-15)
    assert shown.contact_loss.attrs["units"] == "J"
    assert shown.attrs["energy_scale"] == pytest.approx(4e6 * 5e-6**2, rel=1e-15)


@pytest.mark.parametrize(
    ("units", "message"),
    [({"length": "inch"}, "the unit of length must be one of .*, um, mm, m, km, Mm, got 'inch'"),
     ({"length": 3}, "the unit of length must be one of .*, got 3"),
     ({"rate": "ms-1"}, "the unit of rate must be one of s-1, got 'ms-1'"),
     ({"mass": "kg"}, "units must be of length, time, .*, got 'mass'"),
     ("mm", "units must be a mapping such as .*, got 'mm'")],
)  # fmt: skip
def test_other_units_are_refused(plain, units, message):
    with pytest.raises(InputError, match=f"^{message}$"):
        dimensional(plain, MACHINE, units=units)


def test_units_can_be_chosen_again(plain):
    in_si = dimensional(plain, MACHINE)
    shown = dimensional(in_si, units={"length": "mm"})
    expected = dimensional(plain, MACHINE, units={"length": "mm"})
    xr.testing.assert_allclose(shown, expected, rtol=1e-14)
    assert shown.attrs.keys() == expected.attrs.keys()
    with pytest.raises(InputError, match="machine must be that of the result, Dimens"):
        dimensional(in_si, replace(MACHINE, mass=5.0))
    with pytest.raises(InputError, match="machine must be given for a dimensionless result"):
        dimensional(plain)


@pytest.mark.parametrize("analysis", [contact_summary, rotating, contact_forces])
def test_an_analysis_of_a_run_in_si_units_is_in_them(plain, analysis):
    expected = dimensional(analysis(plain), MACHINE, units={"length": "um", "time": "ms"})
    found = analysis(dimensional(plain, MACHINE, units={"length": "um", "time": "ms"}))
    xr.testing.assert_allclose(found, expected, rtol=1e-12)
    assert found.attrs.keys() == expected.attrs.keys()
    units = {name: found[name].attrs.get("units") for name in found.variables}
    assert units == {name: expected[name].attrs.get("units") for name in expected.variables}


def test_responses_in_si_units_are_compared_with_exact_ones_in_them():
    swept = dimensional(
        sweep(omega=[2.7, 3.0], zeta=0.07, delta0=0.5, starts=[(3, 1, 0, 0)]), MACHINE
    )
    compared = compare(swept)
    assert compared.exact_radius_max.attrs["units"] == "m"
    heads, row = describe(compared)[1][0].cells()
    assert (heads[0], row[0]) == ("clearance [um]", "2.5")  # half of the eccentricity
    scale = MACHINE.length_scale
    plain = branches_through(compare(dimensionless(swept)), limits=(2.6, 3.1))
    limits = (2.6 * MACHINE.reference_frequency, 3.1 * MACHINE.reference_frequency)
    for one, other in zip(branches_through(compared, limits=limits), plain, strict=True):
        np.testing.assert_allclose(one.radius_max / scale, other.radius_max, rtol=1e-9)


def test_an_archive_in_si_units_tells_start_and_time_in_them(plain):
    told = describe(dimensional(plain, MACHINE))[0]["parameters"]
    assert told["duration"] == pytest.approx(plain.attrs["duration"] * MACHINE.time_scale)
    scales = [MACHINE.length_scale] * 2 + [MACHINE.velocity_scale] * 2
    np.testing.assert_allclose(told["start"], plain.attrs["start"] * scales, rtol=1e-15)


def test_special_points_of_a_branch_in_si_units_tell_the_parameter_in_them():
    """Where the cycle just touches, the clearance is its least radius, in the next columns."""
    start = np.multiply((2.6, 0.75, 0.66, -1.65), [MACHINE.length_scale] * 2
                        + [MACHINE.velocity_scale] * 2)  # fmt: skip
    branch = continue_cycle(MACHINE, start=start, parameter="clearance", limits=(9e-6, 1.1e-5),
                            points=12)  # fmt: skip
    _, (_, specials, *_) = describe(branch)
    heads, *rows = specials.cells()
    (graze,) = (dict(zip(heads, row, strict=True)) for row in rows if "graze" in row)
    assert float(graze["clearance [um]"]) == pytest.approx(9.09, abs=0.05)
    assert float(graze["clearance [um]"]) == pytest.approx(float(graze["radius min [um]"]), 1e-5)


def test_the_table_of_a_sweep_in_si_units_has_them_in_its_heads():
    swept = dimensional(sweep(omega=[1.2], zeta=0.07, delta0=0.5), MACHINE)
    _, (_, responses, _) = describe(swept, most=1)
    heads, row = responses.cells()
    assert {"speed [rpm]", "radius min [um]", "radius max [um]"} <= {*heads}
    speed = row[heads.index("speed [rpm]")]
    rpm = 1.2 * MACHINE.reference_frequency * 30.0 / math.pi
    assert float(speed) == pytest.approx(rpm, rel=1e-5)


# ---- Speeds that change ----

TURNED = DimensionalRotor(mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5,
                          clearance=8e-6, speed=60.0, shaft_stiffness=2e3)  # fmt: skip
RPM = math.pi / 30.0
RATE, STALL, SLOPE, INERTIA = 900.0 * RPM, 2e-3, 5e-6, 4e-6


@pytest.mark.parametrize(
    ("changes", "drive"),
    [({"to": 1500.0 * RPM, "rate": RATE}, {"rate": RATE}),
     ({"torque": (STALL, SLOPE), "inertia": INERTIA, "duration": 0.8},
      {"torque": (STALL, SLOPE), "inertia": INERTIA})],
    ids=["ramp in rpm", "limited power in N m"],
)  # fmt: skip
def test_a_run_up_in_si_units_obeys_newton_and_euler_in_si_units(changes, drive):
    """The same run by SciPy, from the equations with kilograms, newtons and metres."""
    shown = run_up(TURNED, samples=2, rtol=1e-9, **changes)
    assert shown.sizes["contact"] > 0
    pieces = [(float(shown.t[-1]), Disc(TURNED, **drive))]
    how = in_units(HOW, TURNED.eccentricity, TURNED.time_scale)
    end = followed(pieces, (0.0, 0.0, 0.0, 0.0), TURNED.speed, how=how).end[[0, 1, 2, 3, 5]]
    for name, value in zip(("x", "y", "vx", "vy", "speed"), end, strict=True):
        scale = float(abs(shown[name]).max())
        assert float(shown[name][-1]) == pytest.approx(value, abs=2e-6 * scale)
    if "to" in changes:
        assert float(shown.t[-1]) == pytest.approx((1500.0 * RPM - 60.0) / RATE, rel=1e-12)


def test_how_a_speed_changed_is_told_in_the_units_it_was_given_in():
    """What is put in by hand in rpm, rpm/s, N m and kg m2 comes out of the attributes again."""
    run = run_up(TURNED, to=1500.0 * RPM, rate=9e4 * RPM, samples=2, rtol=1e-6)
    shown = dimensional(run, units={"speed": "rpm"})
    assert shown.attrs["to"] == pytest.approx(1500.0, rel=1e-14)
    assert shown.attrs["rate"] == pytest.approx(9e4, rel=1e-14)
    assert (shown.attrs["to_units"], shown.attrs["rate_units"]) == ("rpm", "rpm s-1")
    assert shown.speed.values == pytest.approx([60.0 / RPM, 1500.0], rel=1e-12)
    assert shown.speed.attrs["units"] == shown.event_speed.attrs["units"] == "rpm"

    table = [(0.0, 62.8), (0.01, 78.5), (0.02, 78.5)]
    run = run_up(TURNED, speeds=table, samples=2, rtol=1e-6)
    shown = dimensional(run, units={"time": "ms", "speed": "rad/s"})
    turns = np.multiply(table, [1e3, 1.0]).ravel()
    assert shown.attrs["speeds"] == pytest.approx(turns, rel=1e-14)
    assert shown.attrs["speeds_units"] == "ms, s-1"

    run = run_up(
        TURNED, torque=(STALL, SLOPE), inertia=INERTIA, duration=0.02, samples=2, rtol=1e-6
    )
    shown = dimensional(run, units={"time": "ms", "speed": "rpm"})
    assert shown.attrs["torque"] == pytest.approx([STALL, SLOPE], rel=1e-14)
    assert shown.attrs["inertia"] == pytest.approx(INERTIA, rel=1e-14)
    assert (shown.attrs["torque_units"], shown.attrs["inertia_units"]) == ("N m, N m s", "kg m2")
    record, _ = describe(shown)
    assert record["torque"] == pytest.approx([STALL, SLOPE], rel=1e-14)


def test_a_bifurcation_diagram_in_si_units_has_its_rate_and_lengths_in_them(tmp_path):
    """The speeds and rate that went in come out in rpm; its archive is the diagram to the bit."""
    machine = replace(MACHINE, damping=4e4)
    rate = machine.reference_frequency
    plain = bifurcation_diagram(
        omega=[600.0 * RPM / rate, 900.0 * RPM / rate], zeta=machine.rotor().zeta, delta0=2.0,
        starts=1, x=(0.0, 3.0), extrema_time=20.0, direction="up", rate=90.0 * RPM / rate**2,
    )  # fmt: skip
    shown = dimensional(plain, machine, units={"length": "um", "time": "ms", "speed": "rpm"})
    told = {name: shown.attrs[name] for name in ("rate", "extrema_time")}
    expected = {"rate": 90.0, "extrema_time": 20.0 * 1e3 / rate}
    assert told == pytest.approx(expected, rel=1e-12)
    np.testing.assert_allclose(shown.attrs["range_x"], [0.0, 15.0])
    units = [shown.attrs[f"{name}_units"] for name in (*told, "range_x", "range_vy")]
    assert units == ["rpm s-1", "ms", "um", "m s-1"]
    assert shown.extremum_speed.attrs["units"] == "rpm"
    assert 600.0 <= shown.extremum_speed.min() < 605.0
    assert 895.0 < shown.extremum_speed.max() <= 900.0
    again = dimensionless(load(save(shown, tmp_path / "diagram.nc")))
    for name in told:
        assert again.attrs[name] == plain.attrs[name]
    np.testing.assert_allclose(again.extremum_speed, plain.extremum_speed, rtol=1e-15)
    drawn, before = (plot_extrema(each).lines[0].get_xdata() for each in (shown, plain))
    np.testing.assert_allclose(drawn, before, rtol=1e-12)  # its ticks are in rpm


def test_attributes_of_a_user_stay_and_a_lacking_start_is_named(plain):
    in_si = dimensional(plain, MACHINE).assign_attrs(sensor="A", sensor_units="V")
    assert {"sensor": "A", "sensor_units": "V"}.items() <= dimensionless(in_si).attrs.items()
    del in_si.attrs["dimensionless_start"]
    with pytest.raises(InputError, match="must have dimensionless_start, got none"):
        dimensionless(in_si)
