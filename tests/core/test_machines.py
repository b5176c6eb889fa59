"""Runs of machines: the whole model where the paper's rotor has no case like it."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from scipy.linalg import expm

from rotor_ida import Rotor
from rotor_ida.core import interface, runs
from rotor_ida.core.interface import DONE, UNBALANCED
from rotor_ida.core.runs import COLUMNS, RunRequest, follow_run
from rotor_ida.errors import InvariantError
from rotor_ida.simulation.neighbours import shoot
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.orbit import check_orbit
from rotor_ida.simulation.run import run

HOW = {"rtol": 1e-12, "atol": 1e-14}
ROOT = Path(__file__).parents[2]
CORE = Path(interface.__file__).parent


def linear_state(rotor, start, time):
    """Where a linear contact without clearance leads, on the rotating axes: by an exponential.

    The state is ``(z, z', g, e)`` on axes that stand still, g the load's and e the unbalance's.
    """
    stiffness = rotor.shaft_stiffness + 1.0
    matrix = np.array(
        [
            [0.0, 1.0, 0.0, 0.0],
            [-stiffness, -2.0 * rotor.zeta, rotor.load, rotor.omega**2],
            [0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 1j * rotor.omega],
        ]
    )
    x, y, vx, vy = start
    z, v, *_ = expm(matrix * time) @ [complex(x, y), complex(vx, vy), -1j, 1.0]
    z, v = np.array([z, v]) * np.exp(-1j * rotor.omega * time)
    return np.array([z.real, z.imag, v.real, v.imag])


@pytest.mark.parametrize("rtol", [1e-8, 1e-13])
@pytest.mark.parametrize(
    "start", [(1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), (0.7, 1e-9, -0.4, 0)]
)
def test_a_linear_contact_without_clearance_is_felt_through_the_centre(start, rtol):
    """It is linear: what is left out near the axis, where a Hertz contact is not felt, shows."""
    for omega, kappa, load in ((0.0, 0.0, 0.0), (0.0, 0.8, 0.3), (1.7, 0.0, 0.5), (0.0, 0.0, 2.0)):
        rotor = Rotor(omega=omega, zeta=0.0, delta0=0.0, contact_exponent=1.0,
                      shaft_stiffness=kappa, load=load)  # fmt: skip
        seen = follow_run(
            RunRequest(rotor=rotor, start=start, duration=20.0, rtol=rtol, atol=1e-3 * rtol)
        )
        assert seen.status == DONE
        expected = linear_state(rotor, start, 20.0)
        np.testing.assert_allclose(seen.state, expected, rtol=0, atol=40.0 * rtol + 1e-13)


@pytest.mark.parametrize("delta0", [0.0, 1.0])
def test_the_load_points_down_however_long_a_phase_lasts(delta0):
    """Damped, errors of single steps are forgotten; a direction that went astray would not be.

    With clearance the load holds the rotor in contact; then a tighter tolerance is the witness.
    """
    rotor = Rotor(omega=2.0, zeta=0.1, delta0=delta0, contact_exponent=1.0, load=20.0)
    start, time, errors = (0.0, -20.0 - delta0, 0.0, 0.0), 1000.0, []
    for rtol in (1e-7, 1e-8, 1e-9):
        states = [
            follow_run(RunRequest(rotor=rotor, start=start, duration=time, rtol=each,
                                  atol=1e-2 * each, events=True))
            for each in (rtol, 1e-14)
        ]  # fmt: skip
        assert not states[0].event_times.size
        exact = states[1].state if delta0 else linear_state(rotor, start, time)
        errors.append(np.abs(np.subtract(states[0].state, exact)).max() / rtol)
    assert max(errors) < 5.0


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_a_load_alone_leads_from_rest_at_the_axis(exponent):
    """It swings between there and the depth h at which load times h is the energy of the contact:
    h**(n + 1)/(n + 1) = gamma h."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.0, load=0.6, contact_exponent=exponent)
    seen = follow_run(RunRequest(rotor=rotor, start=(0.0,) * 4, duration=30.0, extrema=True, **HOW))
    assert seen.status == DONE
    depth = (0.6 * (exponent + 1.0)) ** (1.0 / exponent)
    highest = seen.extrema["radius"][seen.extrema["kind"] > 0]
    assert highest.size > 2
    np.testing.assert_allclose(highest, depth, rtol=1e-10)


def test_a_machine_has_more_columns_of_parameters_than_the_paper_s_rotor():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.1)
    asked = RunRequest(rotor=rotor, start=(0.0,) * 4, duration=1.0, bundle=np.zeros((7, 4)), **HOW)
    with pytest.raises(ValueError, match=r"a bundle must have 4 or 12 rows of 4, got \(7, 4\)"):
        follow_run(asked)


BASES = {
    "the paper's": {},
    "shaft": {"shaft_stiffness": 0.05},
    "release and press": {"contact_damping": 0.5, "contact_exponent": 1.0},
    "all but a load": {"contact_damping": 2.0, "shaft_stiffness": 0.1},
}


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("name", COLUMNS[:5])
def test_columns_of_parameters_are_differences_of_orbits(base, name):
    """Across flights, contacts, releases and presses; where the parameter is 0, to one side."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, **BASES[base])
    start, stop = np.array([2.6, 0.75, 0.66, -1.65]), np.zeros(1, np.uint8)

    def end(value):
        machine = replace(rotor, **{name: value})
        return shoot(machine, start, 6.0, stop, whole=True).end

    shot, here, step = shoot(rotor, start, 6.0, stop, whole=True), getattr(rotor, name), 1e-6
    if here > 0.0:
        slope = (end(here + step) - end(here - step)) / (2.0 * step)
    else:
        slope = (4.0 * end(step) - end(2.0 * step) - 3.0 * end(0.0)) / (2.0 * step)
    found = shot.by_parameter[:, COLUMNS.index(name)]
    assert np.abs(found - slope).max() < 3e-8 * max(np.abs(slope).max(), 1.0)
    if not rotor.beyond:
        paper = shoot(rotor, start, 6.0, stop)
        assert paper.by_parameter == pytest.approx(shot.by_parameter[:, :3], abs=1e-12)
        assert paper.monodromy == pytest.approx(shot.monodromy, abs=1e-12)


@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_a_start_between_pressed_and_loose_is_decided_by_what_follows(method):
    """1 + c d' and its rate of change vanish there, and then it grows: pressed, without an event.

    Of z = -1 with omega = 1, h = 1 and d' = -1, radial acceleration 0 and radial jerk 3.
    """
    rotor = Rotor(omega=1.0, zeta=0.0, delta0=0.75, contact_damping=1.0)
    start = np.array((-1.0, 0.0, 1.0, -1.0))
    beside = start - (0.0, 0.0, 1e-9, 0.0)
    seen, near = (
        follow_run(
            RunRequest(rotor=rotor, start=tuple(begun), duration=6.0, events=True, method=method,
                  rtol=1e-10, atol=1e-12)
        )
        for begun in (start, beside)
    )  # fmt: skip
    assert seen.event_kinds.tolist() == near.event_kinds.tolist()
    assert seen.event_times[0] > 1e-3
    np.testing.assert_allclose(seen.event_times, near.event_times, rtol=0, atol=1e-7)
    np.testing.assert_allclose(seen.state, near.state, rtol=0, atol=1e-7)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize(("x", "restitution"), [(1.0, 0.593624260), (3.0, 0.306896798)])
def test_a_radial_impact_with_contact_damping_rebounds_as_known(x, restitution, exponent):
    """x (1 + e) = ln((1 + x)/(1 - e x)) with x = c v, whatever the exponent; the rest is lost."""
    speed, n = 0.7, exponent
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=2.0, contact_damping=x / speed,
                  contact_exponent=exponent)  # fmt: skip
    asked = RunRequest(rotor=rotor, start=(0.0, 0.0, speed, 0.0), duration=8.0, events=True, **HOW)
    seen = follow_run(asked)
    root, impulse, lost, force = (
        seen.contacts[name][0] for name in ("peak_root", "impulse", "lost", "largest_force")
    )
    assert seen.event_kinds[:2].tolist() == [1, -1]
    rebound = -seen.event_states[1, 2] / speed
    assert rebound == pytest.approx(restitution, abs=1e-9)
    assert x * (1.0 + rebound) == pytest.approx(np.log((1.0 + x) / (1.0 - rebound * x)), rel=1e-11)
    assert lost == pytest.approx(0.5 * speed**2 * (1.0 - rebound**2), rel=1e-10)
    assert impulse == pytest.approx(speed * (1.0 + rebound), rel=1e-11)
    depth = ((n + 1.0) * (x - np.log1p(x)) / rotor.contact_damping**2) ** (1.0 / (n + 1.0))
    assert root**2 == pytest.approx(depth, rel=1e-11)
    # v of the way in: c**2 d**(n + 1)/(n + 1) = x - c v - ln((1 + x)/(1 + c v))
    c, v = rotor.contact_damping, np.linspace(0.0, speed, 200_001)
    way = (n + 1.0) / c**2 * (x - c * v - np.log((1.0 + x) / (1.0 + c * v)))
    forces = np.maximum(way, 0.0) ** (n / (n + 1.0)) * (1.0 + c * v)
    assert force == pytest.approx(forces.max(), rel=1e-9)


def energy(rotor, state):
    """Of disc and shaft, on the ring, where the spring of the contact is at rest."""
    x, y, vx, vy = state
    return 0.5 * (vx * vx + vy * vy + rotor.shaft_stiffness * (x * x + y * y))


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_what_contacts_have_lost_is_missing_from_the_energy(exponent):
    """Through release and press, where a stiff shaft and much damping pull the rotor loose."""
    released = 0
    for number in range(12):
        draw = np.random.default_rng(number)
        more = dict(
            zip(("contact_damping", "shaft_stiffness"), draw.uniform(0.5, 8.0, 2), strict=True)
        )
        rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.5, contact_exponent=exponent, **more)
        start = tuple(draw.normal(size=4))
        asked = RunRequest(rotor=rotor, start=start, duration=20.0, events=True, **HOW)
        seen = follow_run(asked)
        kinds, states = seen.event_kinds, seen.event_states
        entries, exits = (states[kinds == kind] for kind in (1, -1))
        released += np.count_nonzero(kinds == -4)
        first = int(seen.began == 1)  # a contact without an entry
        for contact, entry, left in zip(
            seen.contacts[first:], entries, exits[first:], strict=False
        ):
            missing = energy(rotor, entry) - energy(rotor, left)
            assert contact["lost"] == pytest.approx(missing, rel=1e-9, abs=1e-11)
    assert released > 20


WHOLE_MACHINE = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.1, load=0.3,
                      contact_damping=0.5)  # fmt: skip
# A term of the series of a contact, and by which part of it that is broken.
BROKEN = {
    "damping": ("2.0 * m->zeta * p", 1e-3),
    "unbalance": ("m->omega * m->omega * c", 1e-4),
    "shaft": ("m->shaft_stiffness * r", 1e-4),
    "load": ("m->load * down_t", 1e-4),
    "normal force": ("m->pressed * w3", 1e-5),
    "work of the contact": ("of_work * share", 1e-5),
}
RUBBING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)
# The same with friction, of the two modes of its contacts.
BROKEN_RUBBING = {
    "friction": ("rub", "m->friction * m->sigma * m->pressed * w3", 1e-4),
    "rim of a disc that slides": ("rub", "m->rim * p", 1e-4),
    "rim of a disc that rolls": ("rolling", "m->rim * (-m->rim) * w6", 1e-4),
    "normal force as it rolls": ("rolling", "m->pressed * w3", 1e-4),
}


@pytest.fixture(scope="module")
def core_to_break(tmp_path_factory):
    """Return a library of the whole model, of which each term can be broken."""
    script = ROOT / "hatch_build.py"
    if not script.is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(script))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    folder = tmp_path_factory.mktemp("broken")
    for path in (*CORE.glob("*.c"), *CORE.glob("*.h")):
        if path.name != "build.c":
            shutil.copy(path, folder)
    derived = folder / "derived_whole.c"
    text = derived.read_text("utf-8")
    terms = [("contact", term) for term, _ in BROKEN.values()]
    terms += [(mode, term) for mode, term, _ in BROKEN_RUBBING.values()]
    for place, (mode, term) in enumerate(terms):
        before, head, after = text.partition(f"static void {mode}_expand(")
        assert term in after
        text = before + head + after.replace(term, f"(1.0 + broken[{place}]) * {term}", 1)
    made = f"CORE_API double broken[{len(terms)}];"
    text = text.replace('#include "motion.h"', f'#include "motion.h"\n{made}')
    derived.write_text(text, encoding="utf-8")
    flags = [*hatch_build["flags"](compiler, "baseline", model="whole"), "-O1"]
    words = [*compiler, *flags, "-shared", "-Wno-psabi", *map(str, folder.glob("*.c"))]
    subprocess.run([*words, "-lm", "-o", str(folder / "broken.so")], check=True)
    core = ctypes.CDLL(str(folder / "broken.so"))
    core.core_run.argtypes = [ctypes.c_void_p]
    return core


@pytest.mark.parametrize("name", ["none", "none with friction", *BROKEN, *BROKEN_RUBBING])
def test_a_contact_whose_energy_does_not_balance_ends_the_run(core_to_break, monkeypatch, name):
    """A ten-thousandth of a force too much is seen at the end of the first contact; with friction,
    of which the heat is in the balance, in either way in which a contact goes on."""
    monkeypatch.setattr(runs, "library_of", lambda *_, **__: core_to_break)
    parts = {each: part for each, (*_, part) in {**BROKEN, **BROKEN_RUBBING}.items()}
    broken = (ctypes.c_double * len(parts)).in_dll(core_to_break, "broken")
    for place, (each, part) in enumerate(parts.items()):
        broken[place] = part if each == name else 0.0
    rubs = name in BROKEN_RUBBING or name == "none with friction"
    rotor = RUBBING if rubs else WHOLE_MACHINE
    asked = RunRequest(rotor=rotor, start=(0.3, 0.1, 0.2, 0.1), duration=20.0, events=True, **HOW)
    assert follow_run(asked).status == (DONE if "none" in name else UNBALANCED)
    if "none" not in name:
        with pytest.raises(InvariantError, match="the energy of a contact does not balance"):
            run(asked.rotor, asked.start, 20.0, np.linspace(0.0, 20.0, 3), Options(method="taylor"))


@pytest.mark.parametrize("method", ["taylor", "adams", "bdf"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-9, 1e-12])
def test_energy_balances_over_each_contact_of_any_machine(method, rtol):
    """By each method at any tolerance: none of these runs is called unbalanced."""
    draw = np.random.default_rng(5)
    for _ in range(15):
        chosen = draw.uniform(0.0, (3.0, 0.3, 3.0, 1.0, 5.0)) * (draw.random(5) < 0.7)
        omega, zeta, kappa, load, damping = chosen.tolist()
        rotor = Rotor(omega=omega, zeta=zeta, delta0=float(draw.uniform(0.3, 3.0)), load=load,
                      shaft_stiffness=kappa, contact_damping=damping,
                      contact_exponent=float(draw.choice([1.0, 1.5])))  # fmt: skip
        start = tuple((draw.uniform(-1.5, 1.5, 4) * rotor.delta0).tolist())
        asked = RunRequest(rotor=rotor, start=start, duration=15.0, method=method, rtol=rtol,
                      atol=1e-2 * rtol)  # fmt: skip
        assert follow_run(asked).status == DONE, rotor


@pytest.mark.parametrize("method", ["adams", "bdf"])
@pytest.mark.parametrize("delta0", [0.0, 1.0])
def test_by_cvode_too_the_load_points_down_however_long_a_phase_lasts(method, delta0):
    """Its direction comes from the time: what a step leaves open does not add up to a turn."""
    rotor = Rotor(omega=2.0, zeta=0.1, delta0=delta0, contact_exponent=1.0, load=20.0)
    errors = []
    for time in (250.0, 1000.0):
        asked = RunRequest(rotor=rotor, start=(0.0, -20.0 - delta0, 0.0, 0.0), duration=time,
                      rtol=1e-9, atol=1e-11, method=method)  # fmt: skip
        exact = follow_run(replace(asked, method="taylor", rtol=1e-13)).state
        errors.append(np.abs(np.subtract(follow_run(asked).state, exact)).max())
    assert max(errors) < 2e-6  # 9e-6 and 2e-5 where its rate alone turned it


def test_a_sample_that_the_ring_would_pull_contradicts_the_mechanics():
    """N >= 0: pressed where 1 + c d' is below 0, or loose where it is above."""
    machine = replace(WHOLE_MACHINE, contact_damping=3.0)
    orbit = run(machine, (0.3, 0.1, 0.2, 0.1), 30.0, np.linspace(0.0, 30.0, 3001),
                Options(method="taylor"))  # fmt: skip
    check_orbit(orbit)
    kinds, times = orbit.event_kinds.tolist(), orbit.event_times
    loose = kinds.index(-4)
    for first, sign in ((loose, 1.0), (kinds.index(1), -1.0)):
        place = int(np.searchsorted(orbit.times, times[first])) + 1
        assert orbit.times[place] < times[first + 1]
        x, y, vx, vy = orbit.states[place]
        broken = orbit.states.copy()
        outwards = np.array([x, y]) / np.hypot(x, y)
        along = sign - np.dot(outwards, (vx, vy))
        broken[place, 2:] += along * outwards
        with pytest.raises(InvariantError, match="normal force of a sample is below 0, or missing"):
            check_orbit(replace(orbit, states=broken))
