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

import mpmath
import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE
from rotor_ida.equations.derivation import derive
from rotor_ida.equations.model import rotating_field
from rotor_ida.equations.modes import CARTESIAN, CONTACT
from tests.equations.symbolic import value_of

ROOT = Path(__file__).parents[2]
CORE = ROOT / "rotor_ida" / "core"
WIDTH, APART, MOST_ORDERS = 8, 16, 25
ROTOR = (1.2, 0.07, 0.5)
IN_CONTACT = (0.3, 0.4, 2.1, 0.6, 0.8, 0.0, 0.0)
ANYWHERE = (0.5, -0.2, 0.1, 0.3)
MODES = {"contact": CONTACT, "cartesian": CARTESIAN}
STARTS = {
    "contact": [
        IN_CONTACT,
        (0.0, 0.7, -1.1, 0.0, -1.0, 3.0, 2.0),
        (2.0, -3.0, 0.0, 1.0, 0.0, 0, 0),
    ],
    "cartesian": [ANYWHERE, (-3.0, 2.0, 0.0, 9.0), (1e-3, 0.0, 0.0, 1.0)],
}
ROTORS = [(1.2, 0.07, 0.5), (0.0, 0.0, 2.0), (8.0, 2.0, 1e-2)]
EACH = [(mode, start, rotor) for mode in MODES for start in STARTS[mode] for rotor in ROTORS]


def given(numbers, writeable=False):
    array = np.ascontiguousarray(numbers, dtype=np.float64)
    assert array is numbers or not writeable
    return array.ctypes.data_as(POINTER(c_double))


@pytest.fixture(scope="module")
def probe(tmp_path_factory):
    """Return the library of `probe.c`."""
    script = ROOT / "hatch_build.py"
    if not script.is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(script))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    path = tmp_path_factory.mktemp("probe") / "probe.so"
    flags = [*hatch_build["flags"](compiler, "baseline"), "-fvisibility=default", f"-I{CORE}"]
    sources = [Path(__file__).parent / "probe.c", CORE / "derived.c", CORE / "flight.c"]
    words = [*compiler, *flags, "-shared", "-Wno-psabi", *map(str, sources), "-lm", "-o", str(path)]
    subprocess.run(words, check=True)
    library = ctypes.CDLL(str(path))
    library.probe_order.argtypes = [c_double]
    library.probe_at.argtypes = [c_double, POINTER(c_double)]
    library.probe_cut.argtypes, library.probe_cut.restype = [POINTER(c_double), c_double], c_double
    library.probe_begin.argtypes = [
        *(c_int, POINTER(c_double), c_double, c_double, c_int, POINTER(c_double))
    ]
    return library


class Series:
    """A truncated power series in 50 digits."""

    def __init__(self, terms):
        self.terms = terms

    def _other(self, other):
        if isinstance(other, Series):
            return other.terms
        return [mpmath.mpf(other)] + [mpmath.mpf(0)] * (len(self.terms) - 1)

    def __add__(self, other):
        return Series([a + b for a, b in zip(self.terms, self._other(other), strict=True)])

    __radd__ = __add__

    def __neg__(self):
        return Series([-a for a in self.terms])

    def __sub__(self, other):
        return self + (-1.0) * Series(self._other(other))

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        a, b = self.terms, self._other(other)
        return Series([mpmath.fdot(a[: n + 1], b[n::-1]) for n in range(len(a))])

    __rmul__ = __mul__

    def __truediv__(self, other):
        a, b, found = self.terms, self._other(other), []
        for n in range(len(a)):
            known = mpmath.fdot(found, b[n:0:-1]) if n else 0
            found.append((a[n] - known) / b[0])
        return Series(found)

    def __rtruediv__(self, other):
        return Series(self._other(other)) / self

    def __pow__(self, exponent):
        """By b = exp(e log a): n a0 bn = sum of (e n - (e + 1) k) a(n-k) bk, k below n."""
        a, e = self.terms, mpmath.mpf(exponent)
        found = [a[0] ** e]
        for n in range(1, len(a)):
            total = sum((e * n - (e + 1) * k) * a[n - k] * found[k] for k in range(n))
            found.append(total / (n * a[0]))
        return Series(found)


def exact_series(mode, start, rotor, order):
    """Return the coefficients of the state, and of four differences, rows of one order each."""
    parameters = SimpleNamespace(
        **dict(zip(("omega", "zeta", "delta0"), map(mpmath.mpf, rotor), strict=True)), felt=1.0
    )
    state = [[mpmath.mpf(number)] for number in start]
    for n in range(order):
        rates = mode.rates([Series(terms) for terms in state], parameters)
        for terms, rate in zip(state, rates, strict=True):
            terms.append(rate.terms[n] / (n + 1))
    whole = dict(zip(mode.state, map(Series, state), strict=True))
    growth = [[value_of(entry, parameters, whole) for entry in row] for row in derive(mode).growth]
    growth = [[Series(Series(state[0])._other(each)) if not isinstance(each, Series) else each
               for each in row] for row in growth]  # fmt: skip
    apart = [[[mpmath.mpf(i == d)] for d in range(4)] for i in range(4)]
    for n in range(order):
        new = [[sum(mpmath.fdot(growth[i][j].terms[: n + 1], apart[j][d][n::-1]) for j in range(4))
                for d in range(4)] for i in range(4)]  # fmt: skip
        for i in range(4):
            for d in range(4):
                apart[i][d].append(new[i][d] / (n + 1))
    rows = [[apart[i][d][n] for i in range(4) for d in range(4)] for n in range(order + 1)]
    return np.array(list(zip(*state, strict=True)), float), np.array(rows, float)


@pytest.mark.parametrize(("name", "start", "rotor"), EACH)
def test_coefficients_are_the_exact_ones(probe, name, start, rotor):
    """Of the state, and of four differences from it, to rounding at the end of a step."""
    order, mode = 20, MODES[name]
    if name == "cartesian":
        rotor = (*rotor[:2], 0.0)
    with mpmath.workdps(50):
        state, apart = exact_series(mode, start, rotor, order)
    terms, again = np.zeros((2, order + 1, WIDTH))
    differences = np.zeros((order + 1, APART))
    probe.probe_series(
        int(name == "contact"), given((*rotor, 1.0)), given(start), order,
        *(given(each, writeable=True) for each in (terms, again, differences)),
    )  # fmt: skip
    count = len(mode.state)
    # both are rounded, in lanes of another order
    np.testing.assert_allclose(again[:, :count], terms[:, :count], rtol=1e-9, atol=1e-300)
    # as far as the series converges all terms count alike
    reach = np.abs(state[1:]).max(axis=1) ** (1.0 / np.arange(1, order + 1))
    scale = (1.0 / reach.max()) ** np.arange(order + 1)[:, None]
    for found, exact in ((terms[:, :count], state), (again[:, :count], state)):
        size = np.abs(exact * scale).max()
        np.testing.assert_allclose(found * scale, exact * scale, rtol=0, atol=1e-13 * size)
    size = np.abs(apart * scale).max()
    np.testing.assert_allclose(differences * scale, apart * scale, rtol=0, atol=1e-13 * size)


@pytest.mark.parametrize(("name", "start", "rotor"), EACH)
def test_field_and_jacobian_are_those_of_the_model(probe, name, start, rotor):
    """And growth and what parameters add: as the symbols of the derivation have them."""
    mode, derived, size = MODES[name], derive(MODES[name]), len(start)
    rate, matrix = np.zeros(size), np.zeros((size, size))
    growth, added = np.zeros((4, 4)), np.zeros((3, 4))
    probe.probe_values(
        int(name == "contact"), given((*rotor, 1.0)), given(start),
        *(given(each, writeable=True) for each in (rate, matrix, growth, added)),
    )  # fmt: skip
    omega, zeta, delta0 = rotor
    parameters = SimpleNamespace(omega=omega, zeta=zeta, delta0=delta0, felt=1.0)
    state = dict(zip(mode.state, map(float, start), strict=True))
    np.testing.assert_allclose(rate, mode.rates(list(state.values()), parameters), rtol=1e-13)
    for found, expected in (
        (matrix.T, derived.jacobian),
        (growth, derived.growth),
        (added, derived.by_parameters),
    ):
        numbers = [[value_of(entry, parameters, state) for entry in row] for row in expected]
        np.testing.assert_allclose(found, numbers, rtol=1e-13, atol=1e-13)


def test_at_the_centre_there_is_no_force(probe):
    """Nothing is divided by the radius there."""
    order = 6
    terms, again = np.zeros((2, order + 1, WIDTH))
    differences = np.zeros((order + 1, APART))
    start = np.array([0.0, 0.0, 0.3, 0.0])
    for felt in (0.0, 1.0):
        probe.probe_series(
            0, given((1.2, 0.07, 0.0, felt)), given(start), order,
            *(given(each, writeable=True) for each in (terms, again, differences)),
        )  # fmt: skip
        np.testing.assert_allclose(terms[1, :4], rotating_field(start, Rotor(
            omega=1.2, zeta=0.07, delta0=0.0)), rtol=1e-15)  # fmt: skip
        assert np.isfinite(terms).all()
        assert np.isfinite(differences).all()


class Motion:
    """A motion led by the probe."""

    def __init__(self, probe, start=IN_CONTACT, rtol=1e-15, rotor=ROTOR, *, tangents=False):
        self.probe, self.in_contact = probe, len(start) == len(IN_CONTACT)
        self.size = len(start)
        whole = np.append(start, np.eye(4).ravel()) if tangents else np.array(start, float)
        self.count = whole.size
        self.low = self.point = 0.0
        model = given((*rotor, 1.0))
        begun = probe.probe_begin(self.in_contact, model, rtol, 1e-17, tangents, given(whole))
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

    def slope(self, point, h=1e-3):
        """Rate of change at a point of the last step, by differences of order four."""
        a, b, c, d = (self.at(point + k * h) for k in (-2, -1, 1, 2))
        return (a - 8.0 * b + 8.0 * c - d) / (12.0 * h)


def test_the_series_solves_the_equations_of_contact(probe):
    motion = Motion(probe)
    motion.advance()
    parameters = SimpleNamespace(omega=ROTOR[0], zeta=ROTOR[1], delta0=ROTOR[2])
    for part in (0.3, 0.7):
        point = part * motion.point
        rate = CONTACT.rates(motion.at(point).tolist(), parameters)
        np.testing.assert_allclose(motion.slope(point), rate, rtol=0, atol=1e-9)


def test_the_series_solves_the_equations_without_clearance(probe):
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.0)
    motion = Motion(probe, ANYWHERE, rotor=(1.2, 0.07, 0.0))
    motion.advance()
    point = 0.5 * motion.point
    expected = rotating_field(motion.at(point), rotor)
    np.testing.assert_allclose(motion.slope(point), expected, rtol=0, atol=1e-9)


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
