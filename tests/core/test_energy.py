"""The energy of contacts: what a rebound keeps, what damping takes, and that it balances."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from scipy.optimize import brentq

from rotor_ida import Rotor
from rotor_ida.core import interface, runs
from rotor_ida.core.interface import DONE, UNBALANCED
from rotor_ida.core.runs import RunRequest, follow_run
from rotor_ida.errors import InvariantError
from rotor_ida.simulation.invariants import check_orbit
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

HOW = {"rtol": 1e-12, "atol": 1e-14}
ROOT = Path(__file__).parents[2]
CORE = Path(interface.__file__).parent


def restitution(x):
    """e of ``x (1 + e) = ln((1 + x)/(1 - e x))``, DESIGN section 3."""

    def equation(e):
        return x * (1.0 + e) - np.log1p(x) + np.log1p(-e * x)

    return brentq(equation, 1e-9, min(1.0, 1.0 / x) * (1.0 - 1e-15), xtol=1e-16, rtol=1e-15)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("x", [1.0, 3.0, 10.0])
def test_a_radial_impact_with_contact_damping_rebounds_as_known(x, exponent):
    """x (1 + e) = ln((1 + x)/(1 - e x)) with x = c v, whatever the exponent; the rest is lost."""
    speed, n = 0.7, exponent
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=2.0, contact_damping=x / speed,
                  contact_exponent=exponent)  # fmt: skip
    asked = RunRequest(
        rotor=rotor,
        start=(0.0, 0.0, speed, 0.0),
        duration=60.0,
        method="taylor",
        events=True,
        **HOW,
    )
    seen = follow_run(asked)
    root, impulse, lost, force = (
        seen.contacts[name][0] for name in ("peak_root", "impulse", "lost", "largest_force")
    )
    assert seen.event_kinds[:2].tolist() == [1, -1]
    rebound = -seen.event_states[1, 2] / speed
    assert rebound == pytest.approx(restitution(x), abs=1e-11)
    assert lost == pytest.approx(0.5 * speed**2 * (1.0 - restitution(x) ** 2), rel=1e-10)
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


GENERAL = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.1, load=0.3,
                      contact_damping=0.5)  # fmt: skip
# A term of the series of a contact, and by which part of it that is broken.
BROKEN = {
    "damping": ("2.0 * m->zeta * p", 1e-3),
    "unbalance": ("m->omega * m->omega * c", 1e-4),
    "shaft": ("m->shaft_stiffness * r", 1e-4),
    "load": ("m->load * down_t", 1e-4),
    "normal force": ("(1.0 - m->loose) * w3", 1e-5),
    "work of the contact": ("of_work * share", 1e-5),
}
RUBBING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)
# The same with friction, of the two modes of its contacts.
BROKEN_RUBBING = {
    "friction": ("rub", "m->friction * m->sigma * (1.0 - m->loose) * w3", 1e-4),
    "rim of a disc that slides": ("rub", "m->rim * p", 1e-4),
    "rim of a disc that rolls": ("rolling", "m->rim * (-m->rim) * w6", 1e-4),
    "normal force as it rolls": ("rolling", "(1.0 - m->loose) * w3", 1e-4),
}


@pytest.fixture(scope="module")
def core_to_break(tmp_path_factory):
    """Return a library of the whole model's runs, of which each term can be broken."""
    script = ROOT / "hatch_build.py"
    if not script.is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(script))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    folder = tmp_path_factory.mktemp("broken")
    beside = ("build.c", "lanes*.c", "system*.c")  # of which no run of a disc knows
    others = shutil.ignore_patterns("*.py", "*.so", "__pycache__", ".build-*", *beside)
    shutil.copytree(CORE, folder, ignore=others, dirs_exist_ok=True)
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
    flags = [*hatch_build["flags"](compiler, "baseline", model="whole"), "-O0"]
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
    rotor = RUBBING if rubs else GENERAL
    asked = RunRequest(rotor=rotor, start=(0.3, 0.1, 0.2, 0.1), duration=20.0, events=True, **HOW)
    assert follow_run(asked).status == (DONE if "none" in name else UNBALANCED)
    if "none" not in name:
        with pytest.raises(InvariantError, match="the energy of a contact does not balance"):
            run(asked.rotor, asked.start, 20.0, np.linspace(0.0, 20.0, 3), Options(method="taylor"))


@pytest.mark.parametrize("method", ["taylor", "adams", "bdf"])
@pytest.mark.parametrize("rtol", [1e-4, 1e-9, 1e-12])
def test_energy_balances_over_each_contact_of_any_rotor(method, rtol):
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


def test_a_sample_that_the_ring_would_pull_contradicts_the_mechanics():
    """N >= 0: not loose where 1 + c d' is below 0, or loose where it is above."""
    rotor = replace(GENERAL, contact_damping=3.0)
    orbit = run(rotor, (0.3, 0.1, 0.2, 0.1), 30.0, np.linspace(0.0, 30.0, 3001),
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
