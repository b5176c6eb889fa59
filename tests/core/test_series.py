"""Taylor series of the core: their coefficients are the exact ones, and their steps hide nothing.

Coefficients are held against the model itself, run over power series of 50 digits. What the core
offers to nobody is asked of a library of its own, compiled here from the core's sources.
"""

from __future__ import annotations

import ctypes
import math
import subprocess
from ctypes import POINTER, c_double, c_int
from itertools import pairwise
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE
from rotor_ida.model.derivation import derive
from rotor_ida.model.equations import rotating_field
from rotor_ida.model.modes import PAPER, WHOLE
from rotor_ida.model.writing import absent_from
from tests.model.symbolic import value_of

ROOT = Path(__file__).parents[2]
CORE = ROOT / "rotor_ida" / "core"
WIDTH, APART, MOST_ORDERS = {"paper": 8, "whole": 12}, 16, 25
ROTOR = (1.2, 0.07, 0.5)
IN_CONTACT = (0.3, 0.4, 2.1, 0.6, 0.8, 0.0, 0.0)
ANYWHERE = (0.5, -0.2, 0.1, 0.3)
STARTS = {
    "contact": [
        IN_CONTACT,
        (0.0, 0.7, -1.1, 0.0, -1.0, 3.0, 2.0),
        (2.0, -3.0, 0.0, 1.0, 0.0, 0, 0),
    ],
    "cartesian": [ANYWHERE, (-3.0, 2.0, 0.0, 9.0), (1e-3, 0.0, 0.0, 1.0)],
}
STARTS["rub"] = STARTS["contact"]
STARTS["rolling"] = [(*start[:2], 0.0, *start[3:]) for start in STARTS["contact"]]
DOWN = (0.28, -0.96)
# Friction, the radius of the disc, and the sense in which surfaces slide.
SLIDES = (0.3, 1.7, -1.0)
# As `probe.c` numbers them.
NUMBERS = {"cartesian": 0, "contact": 1, "rub": 2, "rolling": 3}
ROTORS = [(1.2, 0.07, 0.5), (0.0, 0.0, 2.0), (8.0, 2.0, 1e-2)]
# What a machine has beside: shaft, contact damping, load, and whether by Hertz, and whether loose.
MORE = [(0.8, 0.3, 0.5, 1, 1), (0.0, 2.0, 0.0, 0, 1), (1.7, 0.3, 4.0, 1, 0), (2.5, 0.0, 1.0, 0, 0)]


def parameters_of(model, rotor, more=None, felt=1.0):
    """Return the parameters of a mode, by name."""
    found = dict(zip(("omega", "zeta", "delta0"), rotor, strict=True)) | {"felt": felt}
    if model is WHOLE:
        kappa, damping, load, hertz, loose = (0.0, 0.0, 0.0, 1, 0) if more is None else more
        found |= {"shaft_stiffness": kappa, "contact_damping": damping, "load": load}
        found |= {"hertz": float(hertz), "linear": 1.0 - hertz, "loose": float(loose)}
        found |= dict(zip(("friction", "disc_radius", "sigma"), SLIDES, strict=True))
        found["rim"] = found["disc_radius"] * found["omega"]
    return found


def as_given(model, parameters):
    """Return them as the core takes them, with those that only other models have."""
    absent = {name: model.constants.get(name, 0.0) for name in absent_from(model)}
    return given([(parameters | absent)[name] for name in (*model.parameters, *absent)])


def start_of(model, name, start):
    """Return a start with what the whole model has beside."""
    if model is PAPER:
        return start
    if name == "cartesian":
        return (*start, *DOWN)
    whole = (*start[:5], *DOWN, *start[5:], -0.4, 0.3)
    return whole if name == "contact" else (*whole, 0.2)


def cases():
    for model in (PAPER, WHOLE):
        for mode in model.modes:
            for place, start in enumerate(STARTS[mode.name]):
                for number, rotor in enumerate(ROTORS):
                    clear = rotor if mode.name != "cartesian" else (*rotor[:2], 0.0)
                    # each more with each start, and with each rotor
                    for more in [None] if model is PAPER else MORE[(place + number) % 2 :: 2]:
                        begun = start_of(model, mode.name, start)
                        yield pytest.param(
                            model, mode, begun, parameters_of(model, clear, more),
                            id=f"{model.name}-{mode.name}-{place}-{number}-{more}",
                        )  # fmt: skip


of_cases = pytest.mark.parametrize(("model", "mode", "start", "parameters"), [*cases()])


def given(numbers, writeable=False):
    array = np.ascontiguousarray(numbers, dtype=np.float64)
    assert array is numbers or not writeable
    return array.ctypes.data_as(POINTER(c_double))


@pytest.fixture(scope="module")
def probes(tmp_path_factory):
    """Return the libraries of `probe.c`, by name of the model."""
    script = ROOT / "hatch_build.py"
    if not script.is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(script))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    derived = [CORE / f"{name}.c" for name in ("derived", "derived_whole", "guards", "spending")]
    sources = [str(path) for path in (Path(__file__).parent / "probe.c", *derived)]
    found = {}
    for model in (PAPER, WHOLE):
        path = tmp_path_factory.mktemp("probe") / f"{model.name}.so"
        flags = hatch_build["flags"](compiler, "baseline", model=model.name)
        flags += ["-fvisibility=default", f"-I{CORE}", "-shared", "-Wno-psabi", "-O0"]
        subprocess.run([*compiler, *flags, *sources, "-lm", "-o", str(path)], check=True)
        library = ctypes.CDLL(str(path))
        library.probe_order.argtypes = [c_double]
        library.probe_at.argtypes = [c_double, POINTER(c_double)]
        library.probe_cut.argtypes = [POINTER(c_double), c_double]
        library.probe_cut.restype = c_double
        library.probe_begin.argtypes = [
            *(c_int, POINTER(c_double), c_double, c_double, c_int, POINTER(c_double))
        ]
        found[model.name] = library
    return found


@pytest.fixture
def probe(probes):
    """Return the library of the paper's rotor."""
    return probes["paper"]


def series_of(probe, model, mode, start, parameters, order):
    """Return the coefficients of the state, twice, and of four differences."""
    terms, again = np.zeros((2, order + 1, WIDTH[model.name]))
    differences = np.zeros((order + 1, APART))
    probe.probe_series(
        NUMBERS[mode.name], as_given(model, parameters), given(start), order,
        *(given(each, writeable=True) for each in (terms, again, differences)),
    )  # fmt: skip
    return terms, again, differences


@pytest.mark.parametrize("model", [PAPER, WHOLE], ids=lambda model: model.name)
def test_the_probe_is_given_what_the_core_has(probes, model):
    assert probes[model.name].probe_width() == WIDTH[model.name]
    assert probes[model.name].probe_parameters() == len(model.parameters) + len(absent_from(model))


@of_cases
def test_field_and_jacobian_are_those_of_the_model(probes, model, mode, start, parameters):
    """And growth and what parameters add: as the symbols of the derivation have them."""
    derived, size = derive(mode, model), len(start)
    rate, matrix = np.zeros(size), np.zeros((size, size))
    growth, added = np.zeros((4, 4)), np.zeros((len(model.columns), 4))
    probes[model.name].probe_values(
        NUMBERS[mode.name], as_given(model, parameters), given(start),
        *(given(each, writeable=True) for each in (rate, matrix, growth, added)),
    )  # fmt: skip
    rotor = SimpleNamespace(**model.constants, **parameters)
    state = dict(zip(mode.state, map(float, start), strict=True))
    drawn = mode.drawn_rates(list(state.values()), rotor)
    np.testing.assert_allclose(rate, drawn, rtol=1e-12, atol=1e-13)
    for found, expected in (
        (matrix.T, derived.jacobian),
        (growth, derived.growth),
        (added, derived.by_parameters),
    ):
        numbers = [[value_of(entry, rotor, state) for entry in row] for row in expected]
        np.testing.assert_allclose(found, numbers, rtol=1e-13, atol=1e-13)


@pytest.mark.parametrize("model", [PAPER, WHOLE], ids=lambda model: model.name)
def test_at_the_centre_there_is_no_force(probes, model):
    """Nothing is divided by the radius there."""
    start = np.array(start_of(model, "cartesian", (0.0, 0.0, 0.3, 0.0)))
    for felt in (0.0, 1.0):
        parameters = parameters_of(model, (1.2, 0.07, 0.0), (0.8, 0.0, 0.5, 1, 1), felt)
        terms, _, differences = series_of(
            probes[model.name], model, model.modes[1], start, parameters, 6
        )
        expected = rotating_field(start[:4], Rotor(omega=1.2, zeta=0.07, delta0=0.0))
        if model is WHOLE:
            expected[2:] += 0.5 * np.array(DOWN)
        np.testing.assert_allclose(terms[1, :4], expected, rtol=1e-15)
        assert np.isfinite(terms).all()
        assert np.isfinite(differences).all()


class Motion:
    """A motion led by the probe; of the whole model where more than a rotor's own is given."""

    def __init__(self, probe, start=IN_CONTACT, rtol=1e-15, rotor=ROTOR, *, more=None):
        model = PAPER if more is None else WHOLE
        self.probe, self.size = probe, len(start)
        self.in_contact = len(start) == len(model.modes[0].state)
        self.count = len(start)
        self.low = self.point = 0.0
        parameters = as_given(model, parameters_of(model, rotor, more))
        begun = probe.probe_begin(self.in_contact, parameters, rtol, 1e-17, 0, given(start))
        assert begun == DONE

    def advance(self):
        ends = np.zeros(2)
        assert self.probe.probe_advance(given(ends, writeable=True)) == DONE
        self.low, self.point = ends.tolist()

    def at(self, point):
        values = np.zeros(self.count)
        self.probe.probe_at(point, given(values, writeable=True))
        return values

    @property
    def values(self):
        return self.at(self.point)


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-11, 1e-14])
def test_a_step_keeps_its_tolerance(probe, rtol):
    """Against steps of a tenth of the length at the tightest tolerance."""
    motion = Motion(probe, rtol=rtol)
    motion.advance()
    point, values = motion.point, motion.values
    exact = Motion(probe)
    while exact.point < point:
        exact.advance()
    assert np.abs(exact.at(point) - values).max() < 4.0 * rtol + 1e-15


def test_the_order_grows_with_the_digits(probe):
    orders = [probe.probe_order(10.0**-n) for n in range(4, 17)]
    assert orders == sorted(orders)
    assert orders[0] == 6
    assert orders[-1] == math.ceil(1.0 + 8.0 * math.log(10.0))
    for odd in (0.0, -1.0, math.inf, math.nan, 5e-324):
        assert 6 <= probe.probe_order(odd) <= MOST_ORDERS - 1


def test_a_graze_is_in_no_step_twice(probe):
    """Half a swing of q in u lasts pi/W: a step that spans two would end where it began."""
    q, p = 0, 1
    motion = Motion(probe, (0.0, 1e-9, 0.1, 1.0, 0.0, 0.0, 0.0), rtol=1e-6, rotor=(0.1, 0.0, 0.5))
    seen = []
    while not seen or seen[-1][q] >= 0.0:
        motion.advance()
        seen.append(motion.values)
    assert seen[-1][q] < 0.0 < motion.at(motion.low + 1e-3 * (motion.point - motion.low))[q]
    peaks = sum(first[p] > 0.0 >= last[p] for first, last in pairwise(seen))
    assert peaks <= 1


@pytest.mark.parametrize(
    "roots", [(), (0.5,), (0.2, 0.4), (0.5, 0.50001), (0.1, 0.6, 0.9), (1.5,), (-0.1, 0.7)]
)
def test_a_step_is_cut_until_it_holds_one_root(probe, roots):
    """No more than it must be: halved while it holds two."""
    terms = np.zeros(MOST_ORDERS)
    polynomial = np.polynomial.polynomial.polyfromroots([*roots, -1.0, 2.0])
    terms[: polynomial.size] = polynomial
    expected = 1.0
    while sum(0.0 < root <= expected for root in roots) > 1:
        expected *= 0.5
    for rtol in (1e-4, 1e-10, 1e-15):
        assert probe.probe_cut(given(terms), rtol) == expected


@pytest.mark.parametrize("rtol", [1e-4, 1e-12])
@pytest.mark.parametrize("loose", [1, 0])
def test_a_step_holds_one_release_or_press_at_most(probes, loose, rtol):
    """Where the radial velocity swings about that at which 1 + c d' vanishes, by a stiff shaft."""
    p, seen = 1, 0
    for start in np.random.default_rng(3).normal(size=(20, 3)):
        begun = start_of(WHOLE, "contact", (2.0 + start[0] ** 2, *start[1:], 0.6, 0.8, 0.0, 0.0))
        motion = Motion(probes["whole"], begun, rtol, more=(9.0, 0.8, 0.5, 1, loose))
        for _ in range(4):
            motion.advance()
            points = np.linspace(motion.low, motion.point, 200)
            above = np.array([motion.at(point)[p] for point in points]) + 1.0 / 0.8
            changes = np.count_nonzero(above[1:] * above[:-1] < 0.0)
            assert changes <= 1
            seen += changes
            if motion.values[0] <= 0.0:
                break
    assert seen > 5
