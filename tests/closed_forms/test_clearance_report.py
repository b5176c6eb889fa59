"""Reports on close clearances: against closed forms, settled runs and the formulas themselves."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from rotor_ida import (
    Bearing,
    Contact,
    InputError,
    RotorSystem,
    Stator,
    Unbalance,
    clearance_report,
    decode_flags,
    simulate,
    synchronous_response,
)
from rotor_ida.closed_forms.clearances.critical_speeds import (
    Peak,
    critical_modes,
    margins,
    peak_between,
)
from rotor_ida.model.assembly import assemble
from rotor_ida.units import quantity
from tests.axisymmetric_systems import beam

RPM = math.pi / 30.0
MASS, STIFFNESS, DAMPING = 20.0, 4e6, 1800.0
DISC = RotorSystem(mass=MASS * np.eye(2), stiffness=STIFFNESS * np.eye(2),
                   damping=DAMPING * np.eye(2), nodes={"disc": (0, 1)})  # fmt: skip
SEAL = Contact(node="disc", clearance=100e-6, stiffness=1e8, exponent=1.0, friction=0.1,
               radius=0.05)  # fmt: skip


def test_one_disc_is_that_of_the_formulas():
    """Unbalance, limit, scale, share, critical speed and amplification, written out again."""
    low, high, trip = 600.0, 1500.0, 1650.0
    report = clearance_report(DISC, contacts=[SEAL], probes=["disc"], speed=(low, high, trip))
    n = high / RPM
    unbalance = 2.0 * 6350.0 / n * MASS * 1e-6  # g mm
    limit = 25.4e-6 * math.sqrt(12_000.0 / n)

    def axis(omega):
        dynamic = STIFFNESS - omega**2 * MASS + 1j * omega * DAMPING
        return 2.0 * unbalance * omega**2 / abs(dynamic)

    assert report.applied_unbalance.item() == pytest.approx(unbalance, rel=1e-12)
    assert report.vibration_limit.item() == pytest.approx(limit, rel=1e-12)
    scale = min(limit / axis(low), 6.0)
    assert report.scale_factor.item() == pytest.approx(scale, rel=1e-9)
    assert report.running_share.item() == pytest.approx(scale * axis(low) / 200e-6, rel=1e-9)
    assert report.running_share_speed.item() == pytest.approx(low)
    # the peak of r**2/sqrt((1 - r**2)**2 + (2 zeta r)**2), and its width
    zeta, natural = DAMPING / (2.0 * math.sqrt(MASS * STIFFNESS)), math.sqrt(STIFFNESS / MASS)
    critical = natural / math.sqrt(1.0 - 2.0 * zeta**2)
    assert report.critical_speed.item() == pytest.approx(critical, rel=1e-6)
    assert report.passage_share.item() == pytest.approx(scale * axis(critical) / 200e-6, rel=1e-9)
    b = 1.0 - 2.0 * zeta**2  # with y = r**-2: y**2 - 2 b y + 1 = 2 (1 - b**2) at 0.707
    half = math.sqrt(b**2 - 1.0 + 2.0 * (1.0 - b**2))
    ends = [natural / math.sqrt(b + side * half) for side in (1.0, -1.0)]
    factor = critical / (ends[1] - ends[0])
    assert report.amplification_factor.item() == pytest.approx(factor, rel=1e-5)
    assert report.separation_margin.item() == pytest.approx((low - critical) / low, rel=1e-5)
    needed = 0.17 * (1.0 - 1.0 / (factor - 1.5))
    assert report.required_margin.item() == pytest.approx(min(needed, 0.16), rel=1e-5)
    assert decode_flags(report).clearance_verdict.values.tolist() == ["passes"]


@pytest.mark.parametrize(
    ("factor", "speed", "margin", "needed"),
    [
        (2.4, 90.0, 0.1, 0.0), (math.nan, 90.0, 0.1, 0.0), (2.5, 90.0, 0.1, 0.0),
        (4.0, 90.0, 0.1, 0.102), (50.0, 90.0, 0.1, 0.16), (4.0, 250.0, 0.25, 0.202),
        (50.0, 250.0, 0.25, 0.26), (4.0, 120.0, -0.2, 0.102), (4.0, 199.0, -0.005, 0.202),
    ],
)  # fmt: skip
def test_margins_by_the_amplification_factor(factor, speed, margin, needed):
    found = margins(Peak(speed, factor), 100.0, 200.0)
    assert found == pytest.approx((margin, needed), abs=1e-12)


@pytest.mark.parametrize(("zeta", "sharp"), [(0.6, False), (0.1, True)])
def test_a_mode_without_a_sharp_peak_is_not_too_near(zeta, sharp):
    """Both lie within the running speeds; without a peak the table asks no margin."""
    damping = 2.0 * zeta * math.sqrt(MASS * STIFFNESS) * np.eye(2)
    report = clearance_report(replace(DISC, damping=damping), contacts=[SEAL], points=40,
                              speed=(300.0, 400.0) if not sharp else (400.0, 500.0))  # fmt: skip
    assert report.separation_margin.item() < 0.0
    assert (report.required_margin.item() > 0.0) == sharp
    words = report.attrs["sentence"]
    assert ("Too near to the running speeds" in words) == sharp
    assert ("None is asked at 3,416 rpm, as there is no sharp peak." in words) != sharp
    assert "nan" not in words


@pytest.mark.parametrize(("stiffness", "deep"), [(1e8, False), (1e3, True)])
def test_a_rub_beyond_the_model_is_said_to_be(stiffness, deep):
    """The soft seal gives way by more than its clearance, as its force over its stiffness says."""
    report = clearance_report(
        DISC, contacts=[replace(SEAL, stiffness=stiffness, friction=0.0)], speed=(400.0, 500.0),
        unbalance=[Unbalance(node="disc", moment=0.01)], points=40, probes=["disc"],
        vibration_limit=0.01,
    )  # fmt: skip
    force = float(max(report.rub_force.item(), report.passage_rub_force.item()))
    assert (force / stiffness > SEAL.clearance) == deep
    assert ("Beyond the model: contact 0 at 'disc' is indented" in report.attrs["sentence"]) == deep


def uneven_beam():
    """Return the beam on bearings that are softer along y."""
    system = beam()
    stiffness, damping = system.stiffness.copy(), 4.0 * system.damping
    for node in (0, 40):
        stiffness[node + 1, node + 1] -= 4e6
    return RotorSystem(mass=system.mass, stiffness=stiffness, damping=damping,
                       gyroscopic=system.gyroscopic, nodes=system.nodes)  # fmt: skip


def test_the_axes_are_those_of_settled_runs_of_a_rotor_on_uneven_bearings():
    """The farthest of 2,000 samples of a settled orbit, on both sides; and why no rub is told."""
    system = uneven_beam()
    contacts = [Contact(node="3", clearance=1e-3, stiffness=5e6, exponent=1.0)]
    report = clearance_report(system, contacts=contacts, probes=["1", "9"], speed=(200.0, 500.0),
                              points=40)  # fmt: skip
    row = int(np.argmin(np.abs(report.speed.values - 430.0)))
    speed = float(report.speed.values[row])
    for case in range(report.sizes["case"]):
        applied = [
            Unbalance(node=str(node), moment=moment, phase=phase)
            for node, moment, phase in zip(
                report.node.values, report.applied_unbalance.values[case],
                report.applied_phase.values[case], strict=True)
            if moment > 0.0
        ]  # fmt: skip
        run = simulate(system, contacts=[], unbalance=applied, speed=speed, start="settled",
                       duration=2.0 * math.pi / speed, samples=2001)  # fmt: skip
        farthest = 2.0 * np.hypot(run.x, run.y).max("t")
        found = report.isel(case=case, speed=row)
        assert found.major_axis.item() == pytest.approx(farthest.sel(node="3").item(), rel=1e-5)
        for probe in ("1", "9"):
            seen = found.probe_major_axis.sel(probe=probe).item()
            assert seen == pytest.approx(farthest.sel(node=probe).item(), rel=1e-5)
    # modes along x and along y with the same antinodes are one case
    applied = (report.applied_unbalance * np.exp(1j * report.applied_phase)).values
    assert len(np.unique(applied.round(12), axis=0)) == len(applied) < report.sizes["critical"]
    assert "stiffness is not the same along x and y" in report.attrs["not_exact"]
    assert (decode_flags(report).rub_stability == "absent").all()
    told = "Whirls that follow a touch have no closed form: the stiffness is not the same along x "
    assert told in report.attrs["sentence"]
    assert "a run-up or a sweep computes them." in report.attrs["sentence"]


def test_a_given_unbalance_rubs_as_the_exact_whirls_do():
    """Dimensionless: the hardest stable rub at continuous speeds, and one on the way up."""
    system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), damping=0.1 * np.eye(2),
                         nodes={"disc": (0, 1)}, units="1")  # fmt: skip
    contact = Contact(node="disc", clearance=2.0, stiffness=4.0, exponent=1.0)
    given = [Unbalance(node="disc", moment=0.25)]
    report = clearance_report(
        system, contacts=[contact], probes=["disc"], speed=(1.2, 1.8), unbalance=given,
        multiple=4.0, vibration_limit=1000.0,
    )  # fmt: skip
    assert report.scale_factor.item() == 6.0
    whirls = synchronous_response(
        system, contacts=[contact], unbalance=[Unbalance(node="disc", moment=6.0)],
        speed=np.linspace(1.2, 1.8, 41),
    )  # fmt: skip
    stable = (whirls.stability == 1) & (whirls.in_contact.isel(contact=0) == 1)
    forces = whirls.normal_force.isel(contact=0).where(stable)
    assert report.rub_force.item() == pytest.approx(float(forces.max()), rel=1e-12)
    assert report.rub_speed.item() == pytest.approx(
        float(forces.max("branch").idxmax("speed")), rel=1e-12
    )
    assert report.passage_rub_force.item() >= report.rub_force.item()
    words = decode_flags(report)
    assert words.clearance_verdict.item() == "touches"
    assert words.rub_stability.item() == "stable"
    # 6 W**2 = 2 |1 - W**2 + 0.1 i W|, with y = W**2: 32 y**2 + 7.96 y - 4 = 0
    first = math.sqrt((math.sqrt(7.96**2 + 4.0 * 32.0 * 4.0) - 7.96) / 64.0)
    assert report.first_touch_speed.item() == pytest.approx(first, rel=1e-7)
    told = f"With the scaled unbalance contact 0 at 'disc' touches first, at a speed of {first:.4g}"
    assert report.attrs["sentence"].splitlines()[0].startswith(told)
    assert report.attrs["sentence"].splitlines()[1].startswith("Contact 0 at 'disc' touches: ")
    assert "Without friction there is no dry whip." in report.attrs["sentence"]
    assert "at a speed of" in report.attrs["sentence"]


def test_the_hardest_rub_lies_between_the_speeds_of_the_report():
    """At the peak of the exact response, where two speeds of the same amplitude meet."""
    zeta, shaft, clearance = 0.07, 0.2, 0.5
    system = replace(DISC, mass=np.eye(2), stiffness=shaft * np.eye(2),
                     damping=2.0 * zeta * np.eye(2), units="1")  # fmt: skip
    report = clearance_report(
        system, speed=(1.5, 2.2), multiple=1.0, vibration_limit=1000.0,
        contacts=[Contact(node="disc", clearance=clearance, stiffness=1.0)],
        unbalance=[Unbalance(node="disc", moment=1.0 / 6.0)],
    )  # fmt: skip

    # A**2 ((S - q)**2 + 4 zeta**2 q) = q**2 with q = W**2 has one root q where this vanishes
    def unequal(amplitude):
        stiffness = shaft + (amplitude - clearance) ** 1.5 / amplitude
        least = amplitude**2 * (stiffness - 2.0 * zeta**2) ** 2
        return least - (amplitude**2 - 1.0) * stiffness**2

    amplitude = brentq(unequal, 2.0, 40.0, xtol=1e-14)
    stiffness = shaft + (amplitude - clearance) ** 1.5 / amplitude
    speed = amplitude * math.sqrt((stiffness - 2.0 * zeta**2) / (amplitude**2 - 1.0))
    for name in ("rub", "passage_rub"):
        assert report[f"{name}_force"].item() == pytest.approx((amplitude - clearance) ** 1.5)
        assert report[f"{name}_speed"].item() == pytest.approx(speed)
        assert decode_flags(report)[f"{name}_stability"].item() == "stable"


def test_a_scale_factor_below_1_is_said_beside_the_verdict():
    """The orbit has an axis of 2 u/(omega**2 - 1) omega**2 and more; scaled, of the limit."""
    system = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), damping=0.01 * np.eye(2),
                         nodes={"disc": (0, 1)}, units="1")  # fmt: skip
    gaps = [Contact(node="disc", clearance=each, stiffness=4.0) for each in (2.0, 0.2)]
    report = clearance_report(
        system, contacts=gaps, speed=(1.2, 1.8),
        unbalance=[Unbalance(node="disc", moment=1.0)], multiple=2.0, vibration_limit=0.4,
    )  # fmt: skip
    axis = 2.0 * 2.0 * 1.44 / np.hypot(0.44, 0.012)
    assert report.scale_factor.item() == pytest.approx(0.4 / axis, rel=1e-6)
    said = report.attrs["sentence"].splitlines()
    # the first touch, then the worst: the probes, the clearance that is filled, the one that is not
    assert said[0].startswith("With the scaled unbalance contact 1 at 'disc' touches first")
    assert said[1].startswith("At the probes the response exceeds the vibration limit: the scale")
    assert said[2].startswith("Contact 1 at 'disc' fails")
    (kept,) = (each for each in said[3:] if each.startswith("Contact 0"))
    assert kept.startswith(
        f"Contact 0 at 'disc' passes with the scale factor {0.4 / axis:.3g}: the scaled orbit "
        "fills at most 10 % of the clearance at a speed of 1.2, that of the applied unbalance "
        f"{100.0 * axis / 4.0:.3g} %; 75 % are allowed."
    )
    assert f"the scale factor is {0.4 / axis:.3g}, below 1." in report.attrs["sentence"]


def test_the_static_sag_is_told_beside_the_orbit():
    """The weight over the stiffness, as where a settled simulation without unbalance rests."""
    sag = 40e-6
    heavy = replace(DISC, static_force=(0.0, -sag * STIFFNESS))
    given = {"contacts": [SEAL], "unbalance": [Unbalance(node="disc", moment=2e-3)]}
    report, light = (
        clearance_report(each, speed=(600.0, 1500.0), **given) for each in (heavy, DISC)
    )
    assert report.sag_share.item() == pytest.approx(0.4, rel=1e-12)
    np.testing.assert_allclose(report.running_share, light.running_share, rtol=1e-12)
    most = (report.running_share / report.scale_factor).item()
    said = (
        "The static sag, which the rule leaves out, takes 40 % of it: with the sag the orbit "
        f"reaches up to {100.0 * (0.4 + most):.3g} %."
    )
    assert most > 0.6
    assert said in report.attrs["sentence"]
    assert "sag" not in light.attrs["sentence"]
    run = simulate(heavy, contacts=[SEAL], unbalance=[], speed=600.0, start="rest", duration=0.01)
    assert -run.y.values[-1].item() / SEAL.clearance == pytest.approx(0.4, rel=1e-6)
    free = replace(heavy, stiffness=np.diag([STIFFNESS, 0.0]))
    assert "sag" not in clearance_report(free, speed=(600.0, 1500.0), **given).attrs["sentence"]


def test_without_probes_the_clearances_are_where_vibration_is_measured():
    """There the scaled orbit is the vibration limit, where the scale factor is below 6."""
    report = clearance_report(DISC, contacts=[SEAL], speed=(460.0, 700.0))
    assert report.probe.values.tolist() == ["disc"]
    assert report.scale_factor.item() < 6.0
    share = report.vibration_limit.item() / 200e-6
    assert report.running_share.item() == pytest.approx(share, rel=1e-9)
    again = clearance_report(DISC, contacts=[SEAL], speed=(460.0, 700.0), probes=["disc"])
    del report.attrs["question"], again.attrs["question"]  # as each was asked
    assert again.identical(report)


def test_a_sentence_says_what_dry_whip_would_do():
    report = clearance_report(DISC, contacts=[SEAL], probes=["disc"], speed=(600.0, 1500.0))
    told = report.attrs["sentence"]
    assert f"backwards at {-report.whip_speed.item() / RPM:,.0f} rpm" in told
    assert f"with {quantity(report.whip_force.item(), 'N')}" in told
    slippery = Contact(node="disc", clearance=100e-6, stiffness=1e8, exponent=1.0, friction=1e-4,
                       radius=0.05)  # fmt: skip
    report = clearance_report(DISC, contacts=[slippery], probes=["disc"], speed=(600.0, 1500.0))
    assert "Friction cannot hold dry whip." in report.attrs["sentence"]


UNSTABLE = RotorSystem(mass=MASS * np.eye(2), damping=MASS * np.eye(2), nodes={"disc": (0, 1)},
                       stiffness=STIFFNESS * np.array([[1.0, 0.01], [-0.01, 1.0]]))  # fmt: skip
UNDAMPED = RotorSystem(mass=MASS * np.eye(2), stiffness=STIFFNESS * np.eye(2),
                       nodes={"disc": (0, 1)})  # fmt: skip
PLAIN = RotorSystem(mass=np.eye(2), damping=np.eye(2), stiffness=np.eye(2),
                    nodes={"disc": (0, 1)}, units="1")  # fmt: skip


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"speed": (500.0,)}, "speed must be two or three speeds"),
        ({"speed": (500.0, 400.0)}, "speed must increase, got 400 rad/s after 500 rad/s"),
        ({"speed": (0.0, 400.0)}, "speed must be positive, got 0"),
        ({"probes": []}, "probes must be a list of names"),
        ({"probes": "disc"}, "probes must be a list of names"),
        ({"probes": ["dusc"]}, "node must be one of 'disc', got 'dusc'; did you mean"),
        ({"contacts": []}, "contacts must be at least one clearance, got none"),
        ({"multiple": 0.0}, "multiple must be positive"),
        ({"multiple": 1e9}, "multiple must lie from 1e-06 to 1000000.0, got"),
        ({"probes": [3]}, "probes must be a list of names of nodes"),
        ({"mass": -1.0}, "mass must be positive"),
        ({"points": 1}, "points must be at least 2"),
        ({"vibration_limit": math.inf}, "vibration_limit must be a finite"),
        ({"unbalance": 3.0}, "unbalance must be a list of Unbalance"),
        (
            {"system": UNSTABLE},
            "system must be stable for a report: at 44.* rad/s its motion without "
            r"contact grows at a rate of \d.* per second, as a whirl at 4,2.* rpm",
        ),
        ({"system": UNDAMPED}, "system must be damped at its critical speeds .* at 447.214"),
        ({"system": PLAIN}, "vibration_limit must be given without SI units"),
        ({"system": PLAIN, "vibration_limit": 1.0}, "unbalance must be given without SI units"),
    ],
)
def test_what_cannot_be_reported_is_refused(change, words):
    given = {"system": DISC, "contacts": [SEAL], "probes": ["disc"], "speed": (600.0, 1500.0)}
    with pytest.raises(InputError, match=words) as refusal:
        clearance_report(**{**given, **change})
    assert "\n" not in str(refusal.value)


def test_growth_above_the_trip_speed_is_no_reason_to_refuse():
    """A film drives its disc from the threshold on; its critical speed is above the trip speed."""
    film = Bearing(
        node="disc", speed=[10.0, 4000.0], damping=[800.0, 800.0],
        stiffness=[[[4e6, 1e3 * w], [-1e3 * w, 4e6]] for w in (10.0, 4000.0)],
    )  # fmt: skip
    system = RotorSystem(mass=10.0 * np.eye(2), stiffness=np.zeros((2, 2)), nodes={"disc": (0, 1)},
                         bearings=[film], contacts=[SEAL])  # fmt: skip
    threshold = 0.8 * np.sqrt(4e5)  # where the cross-coupling is the damping at sqrt(k/m)
    (mode,) = critical_modes(assemble(system), 700.0)
    assert mode.decay < 0.0
    speeds = (0.5 * threshold, 0.95 * threshold)
    assert speeds[1] < mode.speed < 1.5 * speeds[1]
    report = clearance_report(system, speed=speeds, probes=["disc"])
    assert "disc" in report.attrs["sentence"]
    with pytest.raises(InputError, match=r"must be stable for a report: at .* rad/s its motion"):
        clearance_report(system, speed=(*speeds, 1.01 * threshold), probes=["disc"])


@pytest.mark.parametrize("ends", [(0.5, 1.0), (1.0, 1.5), (0.5, 1.5)])
def test_a_peak_at_the_end_of_its_range_is_one(ends):
    """Where the ranges of two modes meet: the response of half-width 0.1 is 0.707 of its peak."""
    speeds = np.linspace(0.0, 2.0, 41)

    def response(speed):
        return 1.0 / np.hypot(1.0, (speed - 1.0) / 0.1)

    peak = peak_between(response, speeds, response(speeds), *ends)
    assert peak.speed == pytest.approx(1.0, rel=1e-6)
    assert peak.amplification == pytest.approx(5.0, rel=1e-4)


def fine_beam(elements):
    """A shaft by Euler and Rayleigh, of one plane, on springs, with discs: mass, stiffness, G."""
    length, diameter, size = 1.3 / elements, 0.05, 2 * (elements + 1)
    area, bend = math.pi * diameter**2 / 4.0, math.pi * diameter**4 / 64.0
    scale = np.diag([1.0, length, 1.0, length])
    mass, stiffness, turning = np.zeros((3, size, size))
    for first in range(0, size - 2, 2):
        part = np.s_[first : first + 4, first : first + 4]
        stiffness[part] += 2.11e11 * bend / length**3 * scale @ np.array(
            [[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]]
        ) @ scale  # fmt: skip
        rotary = 7810.0 * bend / (30.0 * length) * scale @ np.array(
            [[36, 3, -36, 3], [3, 4, -3, -1], [-36, -3, 36, -3], [3, -1, -3, 4]]
        ) @ scale  # fmt: skip
        mass[part] += rotary + 7810.0 * area * length / 420.0 * scale @ np.array(
            [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]
        ) @ scale  # fmt: skip
        turning[part] += 2.0 * rotary
    for disc, polar in ((elements // 2, 0.11), (3 * elements // 4, 0.09)):
        place = 2 * disc
        mass[place, place] += 12.0
        mass[place + 1, place + 1] += 0.55 * polar
        turning[place + 1, place + 1] += polar
    for bearing in (0, size - 2):
        stiffness[bearing, bearing] += 1e7
    return mass, stiffness, turning


@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("turns", [False, True])
def test_critical_speeds_of_fine_finite_elements_are_those_of_one_plane(turns, damped):
    """No digit is lost to modes a thousand times as fast, no speed told twice, none invented."""
    mass, stiffness, turning = fine_beam(24)
    size, both = len(mass), np.eye(2)
    bearings = np.zeros_like(mass)
    bearings[0, 0] = bearings[-2, -2] = 1e3
    system = RotorSystem(
        mass=np.kron(both, mass), stiffness=np.kron(both, stiffness),
        gyroscopic=np.kron([[0.0, 1.0], [-1.0, 0.0]], turning) if turns else None,
        damping=np.kron(both, bearings) if damped else None,
        nodes={f"{place}": (2 * place, size + 2 * place) for place in range(size // 2)},
        unbalance=[Unbalance(node="8", moment=1e-4)],
    )  # fmt: skip
    found = synchronous_response(system, speed=[10.0, 2000.0]).critical_speed.values
    held = mass - turning if turns else mass
    squares = np.linalg.eigvals(np.linalg.solve(stiffness, held)).real
    speeds = np.sort(1.0 / np.sqrt(squares[squares > 1.0 / 2000.0**2]))
    assert speeds.size == 3
    # the bearings' damping of 1e3 N s/m moves them by parts of a thousand
    np.testing.assert_allclose(found, speeds, rtol=5e-3 if damped else 1e-9)


def two_discs(stiffness, *, films, **parts):
    """Two discs, each on its own bearing or spring; damped."""
    held = [] if films else stiffness
    tables = [
        Bearing(node=name, speed=[0.1, 1.0, 3.0], stiffness=[value] * 3, damping=[0.05] * 3)
        for name, value in zip(("one", "other"), stiffness, strict=True) if films
    ]  # fmt: skip
    return RotorSystem(
        mass=np.eye(4), stiffness=np.diag(np.repeat(held, 2)) if held else np.zeros((4, 4)),
        damping=None if films else 0.05 * np.eye(4), nodes={"one": (0, 1), "other": (2, 3)},
        bearings=tables, units="1", unbalance=[Unbalance(node="one", moment=1.0)], **parts,
    )  # fmt: skip


@pytest.mark.parametrize("films", [False, True])
def test_equal_discs_have_a_critical_speed_each(films):
    """Four eigenvectors of each eigenvalue, forward and backward, in whatever mixture."""
    found = synchronous_response(two_discs([1.0, 1.0], films=films), speed=[0.2, 2.0])
    assert found.critical_speed.values == pytest.approx([math.sqrt(1.0 - 0.025**2)] * 2, rel=1e-12)
    assert np.isfinite(found.peak_speed.values).sum() == 1


def test_a_stator_beside_the_rotor_has_no_critical_speed():
    """Unbalance does not move it: what its motions move the rotor is rounding."""
    stator = Stator(mass=0.7, stiffness=1.5, damping=0.2)
    touching = Contact(node="one", clearance=1.0, stiffness=2.0, stator=stator)
    system = two_discs([0.5, 1.0], films=True)
    coupled = np.kron([[1.3, -0.8], [-0.8, 1.1]], np.eye(2))
    system = replace(system, stiffness=coupled, gyroscopic=np.kron(
        np.diag([0.1, 0.2]), [[0.0, 1.0], [-1.0, 0.0]]))  # fmt: skip
    alone = synchronous_response(system, speed=[0.2, 2.9])
    beside = synchronous_response(system, contacts=[touching], speed=[0.2, 2.9])
    assert alone.sizes["critical"] == 2
    assert beside.critical_speed.values == pytest.approx(alone.critical_speed.values, rel=1e-12)


def test_equal_contacts_whose_rubs_are_hard_to_separate_are_reported():
    """Their slopes are parallel but for rounding: a matrix that no library inverts."""
    contacts = [
        Contact(node=node, clearance=1e-5, stiffness=1e7, exponent=1.5, friction=0.02, radius=0.02)
        for node in ("2", "3")
    ]
    system = replace(beam(), unbalance=[], contacts=contacts)
    report = clearance_report(
        system, speed=(300.0, 700.0, 750.0), vibration_limit=1e-3, multiple=20
    )
    assert (report.rub_force > 0.0).any()
