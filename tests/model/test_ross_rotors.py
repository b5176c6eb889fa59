"""Rotors of the package ROSS: stand-ins with its methods, and its own rotors where it is installed.

The stand-in is a chain in each direction, ground, spring, pedestal, bearing, rotor, whose motion
has a closed form.
"""

import json
import re
import sys
import warnings
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    RotorSystem,
    Support,
    Unbalance,
    campbell,
    clearance_report,
    drop,
    load_system,
    run_up,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.cli import main
from rotor_ida.cli.describe import describe
from rotor_ida.results.archived_system import system_of
from rotor_ida.steady.drop_words import sentence_of

MASSES, PEDESTALS = (30.0, 20.0), (10.0, 5.0)  # kg
BEARINGS, GROUND = (4e6, 3e6), (2e7, 3e7)  # N/m
GRAVITY, SPEED = 9.81, 200.0
NOTE = "coefficients that depend on the speed are frozen at 200 rad/s (1,910 rpm): Seal 0"


class Spring:
    """A bearing or seal between a node and the ground or a link, as ROSS has them."""

    def __init__(self, places, stiffness, *, mass=0.0, damping=0.0, frequency=None, tag=""):
        self.dof_global_index, self.frequency, self.tag = places, frequency, tag
        self.axial = len(places) // 3
        self.coefficients = (stiffness, damping, mass)
        for letter, given in zip("kcm", self.coefficients, strict=True):
            own = np.broadcast_to(given, np.shape(frequency) if frequency is not None else (1,))
            for pair in ("xx", "xy", "yx", "yy"):
                setattr(self, letter + pair, (own if pair in {"xx", "yy"} else 0.0 * own).tolist())

    def _matrix(self, coefficient, frequency):
        here = coefficient if self.frequency is None or np.ndim(coefficient) == 0 else np.interp(
            frequency, self.frequency, coefficient)  # fmt: skip
        own = np.diag([here, here, 0.0])
        return own if self.axial == 1 else np.block([[own, -own], [-own, own]])

    def K(self, frequency):
        return self._matrix(self.coefficients[0], frequency)

    def C(self, frequency):
        return self._matrix(self.coefficients[1], frequency)

    def M(self, frequency):
        return self._matrix(self.coefficients[2], frequency)


def places(start, node):
    return {f"{axis}_{node}": start + i for i, axis in enumerate("xyz")}


class Rotor:
    """Two rigid discs of six coordinates each, on two links of three, as ROSS numbers them."""

    number_dof = 6
    starts = (0, 6, 12, 15)

    def __init__(self, *seals):
        ends = [places(start, node) for node, start in enumerate(self.starts)]
        self.bearing_elements = [
            *(Spring(ends[i] | ends[i + 2], k, damping=200.0) for i, k in enumerate(BEARINGS)),
            *(Spring(ends[i + 2], k) for i, k in enumerate(GROUND)), *seals,
        ]  # fmt: skip
        self.elements = [SimpleNamespace(dof_global_index=each) for each in ends]
        self.elements += self.bearing_elements
        self.nodes_pos = [0.0, 1.0]
        self.M0, self.K0 = np.eye(18), np.diag([0.0] * 2 + [1e6] * 4 + [0.0] * 2 + [1e6] * 4
                                               + [0.0, 0.0, 1e6] * 2)  # fmt: skip
        self.C0 = np.zeros((18, 18))
        for start, mass in zip(self.starts, MASSES + PEDESTALS, strict=True):
            self.M0[[start, start + 1], [start, start + 1]] = mass

    def _with_bearings(self, whole, name, frequency):
        whole = whole.copy()
        for each in self.bearing_elements:
            at = list(each.dof_global_index.values())
            whole[np.ix_(at, at)] += getattr(each, name)(frequency)
        return whole

    def M(self, frequency=None, synchronous=False):
        assert not synchronous
        return self._with_bearings(self.M0, "M", frequency or 0.0)

    def K(self, frequency):
        return self._with_bearings(self.K0, "K", frequency)

    def C(self, frequency):
        return self._with_bearings(np.zeros((18, 18)), "C", frequency)

    def G(self):
        return np.zeros((18, 18))


class MultiRotor(Rotor):
    """A gear train, by the name of its class."""


def seal(**coefficients):
    return Spring(places(0, 0), 1e5, tag="Seal 0", **coefficients)


def of_table():
    """Return a rotor with a seal whose coefficients depend on the speed."""
    varying = seal(mass=np.array([2.0, 4.0]), damping=np.array([300.0, 500.0]),
                   frequency=np.array([0.0, 400.0]))  # fmt: skip
    with pytest.warns(UserWarning, match="frozen at 200 rad/s"):
        return RotorSystem.from_ross(Rotor(varying), speed=SPEED)


def test_links_are_nodes_with_three_coordinates():
    system = RotorSystem.from_ross(Rotor(), speed=SPEED)
    assert dict(system.nodes) == {"0": (0, 1), "1": (6, 7), "2": (12, 13), "3": (15, 16)}
    assert system.positions is None  # links have none
    rotor = Rotor()
    rotor.nodes_pos = [0.0, 1.0, 0.0, 1.0]
    known = RotorSystem.from_ross(rotor, speed=SPEED).positions
    assert known == {"0": 0.0, "1": 1.0, "2": 0.0, "3": 1.0}
    assert not system.note
    unbalance = [Unbalance(node="0", moment=1e-4), Unbalance(node="1", moment=2e-4)]
    found = synchronous_response(system, speed=SPEED, unbalance=unbalance)
    force = 1e-4 * SPEED**2
    for i, (moved, k, ground) in enumerate(zip(MASSES, BEARINGS, GROUND, strict=True)):
        bearing = k + 200.0j * SPEED
        matrix = [[bearing - moved * SPEED**2, -bearing],
                  [-bearing, bearing + ground - PEDESTALS[i] * SPEED**2]]  # fmt: skip
        disc, pedestal = np.abs(np.linalg.solve(matrix, [(i + 1) * force, 0.0]))
        here = found.node_amplitude.isel(speed=0, branch=0)
        assert float(here.sel(node=str(i))) == pytest.approx(disc, rel=1e-10)
        assert float(here.sel(node=str(i + 2))) == pytest.approx(pedestal, rel=1e-10)


def test_all_pedestals_weigh_and_the_added_mass_of_seals_does_not():
    """The seal stiffens the bearing at node 0 and moves 3 kg of fluid, which are not lifted."""
    rotor = Rotor(seal(mass=3.0))
    system = RotorSystem.from_ross(rotor, speed=SPEED)
    assert system.mass[0, 0] == MASSES[0] + 3.0
    weight = system.weight((0.0, -GRAVITY))
    total = GRAVITY * sum(MASSES + PEDESTALS)
    assert -system.unit_translations()[:, 1] @ weight == pytest.approx(total, rel=1e-14)
    run = simulate(system, gravity=(0.0, -GRAVITY), start="rest", speed=0.0, duration=0.01,
                   samples=2)  # fmt: skip
    sag = GRAVITY * np.array(MASSES) / BEARINGS
    below = GRAVITY * np.add(MASSES, PEDESTALS) / GROUND
    np.testing.assert_allclose(-run.y.isel(t=-1).values[[1, 3]], [sag[1] + below[1], below[1]],
                               rtol=1e-9)  # fmt: skip
    matrix = [[BEARINGS[0] + 1e5, -BEARINGS[0]], [-BEARINGS[0], BEARINGS[0] + GROUND[0]]]
    lifted = np.linalg.solve(matrix, GRAVITY * np.array([MASSES[0], PEDESTALS[0]]))
    np.testing.assert_allclose(-run.y.isel(t=-1).values[[0, 2]], lifted, rtol=1e-9)
    small = system.reduced(modes=8, keep=["0"])
    for name in system.nodes:
        of_all, of_few = (
            each.rows(name)[1] @ np.linalg.lstsq(each.stiffness, each.weight((0.0, 1.0)))[0]
            for each in (system, small)
        )
        assert of_few == pytest.approx(of_all, rel=1e-8)


def test_added_mass_is_that_at_the_speed():
    assert of_table().mass[0, 0] == pytest.approx(MASSES[0] + 3.0)


def test_a_constant_table_is_no_table():
    constant = seal(mass=np.array([2.0, 2.0]), frequency=np.array([0.0, 400.0]))
    assert not RotorSystem.from_ross(Rotor(constant), speed=SPEED).note


def test_a_speed_outside_a_table_is_refused():
    varying = seal(damping=np.array([300.0, 500.0]), frequency=np.array([0.0, 150.0]))
    with pytest.raises(InputError, match=r"speed must lie within .* '0', from 0 to 150, got 200"):
        RotorSystem.from_ross(Rotor(varying), speed=SPEED)


def test_many_tables_are_counted():
    with pytest.warns(UserWarning, match=r"\): 5 bearings and seals$"):
        RotorSystem.from_ross(
            Rotor(*[seal(damping=np.array([3.0, 5.0]), frequency=np.array([0.0, 400.0]))] * 5),
            speed=SPEED,
        )


def answers(system):
    """Yield a result of each kind of a system whose coefficients are frozen."""
    touch = Contact(node="0", clearance=5e-5, stiffness=1e7, exponent=1.0)
    around = {"contacts": [touch], "unbalance": [Unbalance(node="0", moment=2e-3)]}
    brief = {**around, "duration": 0.02, "samples": 3, "modes": 6}
    yield simulate(system, speed=SPEED, **brief)
    yield run_up(system, speed=SPEED, rate=10.0, **brief)
    yield sweep(system, speed=[SPEED], modes=6, **around)
    yield campbell(system, speed=[SPEED, 2.0 * SPEED])
    yield synchronous_response(system, speed=[SPEED], **around)
    yield clearance_report(system, contacts=[touch], speed=(SPEED, 1.5 * SPEED), points=20)
    yield drop(system, contacts=[touch], supports=[Support(node="0", stiffness=1e6)],
               unbalance=around["unbalance"], speed=SPEED, duration=0.02, modes=6)  # fmt: skip


def test_every_answer_tells_that_coefficients_are_frozen():
    for found in answers(of_table()):
        assert found.attrs["note"] == NOTE
        told = [each for each in describe(found)[1] if isinstance(each, str)]
        assert sum(each.count(f"Note: {NOTE}.") for each in told) == 1
        assert system_of(found).note == NOTE
    assert f"Note: {NOTE}." in sentence_of(found, None)


def test_a_file_keeps_the_note_and_the_added_mass(tmp_path):
    system, path = of_table(), tmp_path / "rotor.npz"
    np.savez(path, mass=system.mass, stiffness=system.stiffness, added_mass=system.added_mass,
             note=system.note, node_0=system.nodes["0"])  # fmt: skip
    again = RotorSystem.from_file(path)
    assert again.note == NOTE
    np.testing.assert_array_equal(again.added_mass, system.added_mass)


def test_shafts_of_different_speeds_are_refused():
    with pytest.raises(InputError, match="rotor must be one shaft line, got a MultiRotor"):
        RotorSystem.from_ross(MultiRotor(), speed=SPEED)
    with pytest.raises(InputError, match="rotor must be a rotor of ROSS"):
        RotorSystem.from_ross(3, speed=SPEED)


@cache
def ross():
    """Return the package ROSS, or skip the test."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip("ross", reason="there is no ROSS")


def of_ross(**sealing):
    """Return a rotor of ROSS on two pedestals of 10 and 20 kg, perhaps with a seal at node 2."""
    rs = ross()
    steel = rs.Material(name="steel", rho=7810, E=211e9, G_s=81.2e9)
    shaft = [rs.ShaftElement(L=0.25, idl=0, odl=0.05, material=steel) for _ in range(4)]
    disc = rs.DiskElement.from_geometry(n=2, material=steel, width=0.07, i_d=0.05, o_d=0.28)
    bearings = [
        rs.BearingElement(n=0, n_link=5, kxx=1e7, cxx=2e3, kzz=1e5),
        rs.BearingElement(n=4, n_link=6, kxx=1e7, cxx=2e3, kzz=1e5),
        rs.BearingElement(n=5, kxx=2e7, cxx=1e3, kzz=1e6),
        rs.BearingElement(n=6, kxx=3e7, cxx=1e3, kzz=1e6),
    ]
    if sealing:
        bearings.append(rs.SealElement(n=2, **sealing))
    return rs.Rotor(shaft, [disc], bearings, [rs.PointMass(n=5, m=10.0), rs.PointMass(n=6, m=20.0)])


TABLE = np.linspace(0.0, 900.0, 10)
SEALS = {
    "none": {},
    "constant": {"kxx": 1e5, "cxx": 500.0, "mxx": 10.0},
    "table": {"kxx": 1e5 + 100.0 * TABLE, "cxx": 500.0 + TABLE, "mxx": 5.0 + TABLE / 100.0,
              "frequency": TABLE},
}  # fmt: skip


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", SEALS)
def test_ross_itself_has_the_same_response_weight_and_critical_speeds(kind):
    rotor, speed = of_ross(**SEALS[kind]), 300.0
    system = RotorSystem.from_ross(rotor, speed=speed)
    assert bool(system.note) == (kind == "table")
    moments, phases, nodes = [2e-4, 1e-4], [0.0, 1.0], [2, 1]
    theirs = rotor.run_unbalance_response(nodes, moments, phases, np.array([299.0, speed, 301.0]))
    unbalance = [Unbalance(node=str(n), moment=m, phase=p)
                 for n, m, p in zip(nodes, moments, phases, strict=True)]  # fmt: skip
    ours = synchronous_response(system, speed=[speed], unbalance=unbalance).isel(speed=0, branch=0)
    moved = ours.node_amplitude.values * np.exp(-1j * ours.node_phase_lag.values)
    along_x = [x for x, _ in system.nodes.values()]
    np.testing.assert_allclose(moved, theirs.forced_resp[along_x, 1], rtol=1e-9)
    total = rotor.m + 30.0  # without the fluid
    assert system.unit_translations()[:, 0] @ system.weight((1.0, 0.0)) == pytest.approx(total)
    if kind != "table":
        found = campbell(system, speed=np.linspace(0.0, 1000.0, 101)).critical_speed.values
        known = np.asarray(rotor.run_critical_speed(num_modes=24).wd())
        assert found.size >= 3
        np.testing.assert_allclose(
            found, [known[np.abs(known - each).argmin()] for each in found], rtol=1e-4
        )


# ---- Each bearing with its own table ----


@cache
def recorded():
    """Return what ROSS has computed, and the rotor of which: see tests/data/README.md."""
    held = json.loads((Path(__file__).parents[1] / "data" / "ross_films.json").read_text())
    matrices = {}
    for name, each in held["matrices"].items():
        matrices[name] = np.zeros((each["size"],) * 2)
        matrices[name][each["rows"], each["columns"]] = each["values"]
    frequency = np.array(held["speed"])
    elements = [
        SimpleNamespace(
            **{name: each[name] for name in each if name != "places"}, frequency=frequency,
            dof_global_index=each["places"],
            **dict.fromkeys(("mxx", "mxy", "myx", "myy"), 0.0 * frequency),
            **dict.fromkeys("KCM", lambda _: np.zeros((3, 3))),
        )
        for each in held["elements"]
    ]  # fmt: skip
    rotor = SimpleNamespace(
        **{name: matrices[name] for name in ("M0", "K0", "C0")}, G=lambda: matrices["G"],
        Ksdt=lambda: matrices["Ksdt"], nodes_pos=held["nodes_pos"], number_dof=6,
        bearing_elements=elements,
    )  # fmt: skip
    return held, rotor


def test_eigenvalues_on_tables_are_those_recorded():
    held, rotor = recorded()
    system = RotorSystem.from_ross(rotor)
    names = {each.node: each.name for each in system.bearings}
    assert names == {"0": "film 0", "2": "Seal 0", "4": "film 4"}
    again = system_of(synchronous_response(system, speed=held["speed"][:1]))
    assert {each.node: each.name for each in again.bearings} == names
    found = campbell(system, speed=held["speed"], modes=16)
    for number, values in enumerate(held["eigenvalues"]):
        known = np.array(values) @ [1.0, 1.0j]
        one = found.isel(speed=number, contact_stiffness=0)
        ratio, turning = one.damping_ratio.values, np.abs(one.whirl_speed.values)
        oscillates = (turning > 0.0) & (turning < known.imag.max())
        size = turning[oscillates] / np.sqrt(1.0 - ratio[oscillates] ** 2)
        mine = -ratio[oscillates] * size + 1j * turning[oscillates]
        apart = np.abs(mine[:, np.newaxis] - known).min(axis=1)
        assert oscillates.sum() >= 4
        assert (apart < 1e-9 * np.abs(mine)).all()
    assert (found.damping_ratio.values < 0.0).any() == any(
        np.array(values)[:, 0].max() > 0.0 for values in held["eigenvalues"]
    )


def test_the_program_keeps_the_tags_of_bearings(tmp_path, monkeypatch, capsys):
    ross = SimpleNamespace(Rotor=SimpleNamespace(load=lambda _: recorded()[1]))
    monkeypatch.setitem(sys.modules, "ross", ross)
    saved, out = tmp_path / "saved.toml", tmp_path / "rotor.toml"
    saved.touch()
    assert main(["from-ross", str(saved), "--out", str(out)]) == 0
    assert re.search(r"film 0 +0 +ground +[\d.,]+ +[\d.,]+\n", capsys.readouterr().out)
    names = [each.name for each in load_system(out).bearings]
    assert names == [each.tag for each in recorded()[1].bearing_elements]
    assert main(["campbell", str(out), "--speed", "1rpm"]) == 2
    assert "within the table of the bearing 'film 0' at '0', from" in capsys.readouterr().err


def test_the_unbalance_response_on_tables_is_that_recorded():
    held, rotor = recorded()
    system = RotorSystem.from_ross(
        rotor,
        unbalance=[Unbalance(node="1", moment=2e-3), Unbalance(node="2", moment=1e-3, phase=1.0)],
    )
    found = synchronous_response(system, speed=held["speed"])
    ahead, back = (
        found[f"node_{sense}_amplitude"] * np.exp(side * 1j * found[f"node_{sense}_phase_lag"])
        for sense, side in (("forward", -1.0), ("backward", 1.0))
    )
    x, y = ahead + np.conj(back), -1j * (ahead - np.conj(back))
    known = np.array(held["response"]["real"]) + 1j * np.array(held["response"]["imag"])
    for name, (one, other) in system.nodes.items():
        for mine, theirs in ((x, known[one]), (y, known[other])):
            scale = np.abs(theirs).max()
            np.testing.assert_allclose(mine.sel(node=name), theirs, atol=1e-9 * scale)


@pytest.mark.parametrize("node", [0, 2])
def test_tables_and_frozen_coefficients_agree_between_rows(node):
    """Of a seal to the ground and one between a node and a link, by cubics through their rows."""
    places_of = places(0, 0) | (places(12, 2) if node else {})
    rows, speed = np.array([300.0, 500.0, 450.0]), 130.0
    varying = Spring(places_of, 1e3 * rows, damping=rows, tag="Seal 0",
                     frequency=np.array([0.0, 200.0, 400.0]))  # fmt: skip
    tables = RotorSystem.from_ross(Rotor(varying))
    with pytest.warns(UserWarning, match="frozen at 130 rad/s"):
        frozen = RotorSystem.from_ross(Rotor(varying), speed=speed)
    held = tables.at(speed)
    for name in ("mass", "stiffness", "damping"):
        apart = np.abs(getattr(held, name) - getattr(frozen, name))
        assert apart.max() < 1e-12 * np.abs(getattr(held, name)).max()
    assert len(tables.bearings) == len(Rotor(varying).bearing_elements)
    stators = [each.stator for each in tables.bearings]
    assert stators == ["2", "3", None, None, "2" if node else None]


def test_an_added_mass_that_depends_on_the_speed_needs_a_speed():
    varying = seal(mass=np.array([2.0, 4.0]), frequency=np.array([0.0, 400.0]))
    with pytest.raises(InputError, match="speed must be given, as the added mass of Seal 0"):
        RotorSystem.from_ross(Rotor(varying))
