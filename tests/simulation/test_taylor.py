"""Taylor series: they solve the equations, to rounding, and nothing is hidden inside a step."""

import math
from itertools import pairwise

import numpy as np
import pytest

from rotor_ida import InputError, Rotor, simulate
from rotor_ida.closed_forms import planar_period
from rotor_ida.equations.model import energy, rotating_field
from rotor_ida.simulation.contact_phase import P, Q, T, cartesian, contact_field, regularised
from rotor_ida.simulation.motion import GOES_ON
from rotor_ida.simulation.taylor.motion import open_taylor
from rotor_ida.simulation.taylor.roots import bernstein_basis, sign_changes
from rotor_ida.simulation.taylor.rows import LANES, evaluate, sum_known, sum_products
from rotor_ida.simulation.taylor.steps import order_for

ROTOR = (1.2, 0.07, 0.5)
IN_CONTACT = (0.3, 0.4, 2.1, 0.6, 0.8, 0.0, 0.0)


def begun(start=IN_CONTACT, rtol=1e-15, rotor=ROTOR, *, regularised=True, vectors=()):
    motion = open_taylor(*rotor, regularised, rtol, len(vectors) > 0)
    whole = np.append(start, vectors)
    motion.restart(whole, np.full(whole.size, 1e-17))
    return motion


def slope(motion, point, h=1e-3):
    """Rate of change at a point of the last step, by differences of order four."""
    a, b, c, d = (motion.at(point + k * h).copy() for k in (-2, -1, 1, 2))
    return (a - 8.0 * b + 8.0 * c - d) / (12.0 * h)


def test_the_series_solves_the_equations_of_contact():
    motion, rate = begun(), np.empty(7)
    assert motion.advance() == GOES_ON
    for part in (0.3, 0.7):
        point = part * motion.point
        contact_field(motion.at(point).copy(), rate, *ROTOR)
        np.testing.assert_allclose(slope(motion, point), rate, rtol=0, atol=1e-9)


def test_the_series_solves_the_equations_without_clearance():
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.0)
    motion = begun((0.5, -0.2, 0.1, 0.3), rotor=(1.2, 0.07, 0.0), regularised=False)
    assert motion.advance() == GOES_ON
    point = 0.5 * motion.point
    expected = rotating_field(motion.at(point).copy(), rotor)
    np.testing.assert_allclose(slope(motion, point), expected, rtol=0, atol=1e-9)


@pytest.mark.parametrize("rtol", [1e-5, 1e-8, 1e-11, 1e-14])
def test_a_step_keeps_its_tolerance(rtol):
    """Against steps of a tenth of the length at the tightest tolerance."""
    motion = begun(rtol=rtol)
    motion.advance()
    exact = begun()
    while exact.point < motion.point:
        exact.advance()
    error = np.abs(exact.at(motion.point) - motion.values)
    assert error.max() < 4.0 * rtol + 1e-15


def test_the_order_grows_with_the_digits():
    orders = [order_for(10.0**-n) for n in range(4, 17)]
    assert orders == sorted(orders)
    assert orders[0] == 6
    assert orders[-1] == math.ceil(1.0 + 8.0 * math.log(10.0))


def test_a_graze_is_in_no_step_twice():
    """Half a swing of q in u lasts pi/W: a step that spans two would end where it began."""
    z, v = 0.5 + 0j, 1e-9 + 0.2j
    motion = begun(regularised(z, v, 0.0), rtol=1e-6, rotor=(0.1, 0.0, 0.5))
    seen = []
    while motion.values[Q] >= 0.0:
        assert motion.advance() == GOES_ON
        seen.append(motion.values.copy())
    assert seen[-1][Q] < 0.0 < motion.at(motion.low + 1e-3 * (motion.point - motion.low))[Q]
    peaks = sum(first[P] > 0.0 >= last[P] for first, last in pairwise(seen))
    assert peaks <= 1


@pytest.mark.parametrize("roots", [(), (0.5,), (0.2, 0.4), (0.5, 0.50001), (0.1, 0.6, 0.9)])
def test_roots_inside_a_step_are_counted(roots):
    terms = np.polynomial.polynomial.polyfromroots([*roots, -1.0, 2.0])
    basis = bernstein_basis(terms.size - 1)
    room = np.empty((1, terms.size)), np.empty(LANES)
    assert sign_changes(terms[:, None], 0, 1.0, basis, *room) == len(roots)


def test_planar_vibration_through_the_centre_keeps_its_period():
    """Without clearance the force is not smooth at the centre."""
    period = planar_period(3.0)
    run = simulate(
        Rotor(omega=0.0, zeta=0.0, delta0=0.0), start=(3.0, 0.0, 0.0, 0.0),
        duration=10.0 * period, samples=11, method="taylor", rtol=1e-15, atol=1e-17,
    )  # fmt: skip
    np.testing.assert_allclose(run.x, 3.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.vx, 0.0, rtol=0, atol=1e-11)


@pytest.mark.parametrize("miss", [1e-3, 1e-6, 1e-9, 1e-12, 0.0])
def test_passing_close_to_the_centre_conserves_energy_and_moment(miss):
    run = simulate(
        Rotor(omega=0.0, zeta=0.0, delta0=0.0), start=(2.0, 0.0, 0.0, miss), duration=50.0,
        samples=101, method="taylor", rtol=1e-14, atol=1e-17,
    )  # fmt: skip
    states = np.stack([run[name] for name in ("x", "y", "vx", "vy")], axis=-1)
    energies = energy(states, 0.0)
    np.testing.assert_allclose(energies, energies[0], rtol=2e-12)
    moments = run.x * run.vy - run.y * run.vx
    np.testing.assert_allclose(moments, 2.0 * miss, rtol=1e-10, atol=0.0)


def test_plain_python_takes_the_same_steps():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    runs = [
        simulate(rotor, start=(0, 0, 0, 0), duration=12.0, samples=21, method="taylor",
                 rtol=1e-12, backend=backend)
        for backend in ("compiled", "python")
    ]  # fmt: skip
    assert runs[0].sizes["event"] == runs[1].sizes["event"] > 0
    np.testing.assert_allclose(runs[0].event_time, runs[1].event_time, rtol=1e-13)
    np.testing.assert_allclose(runs[0].x, runs[1].x, rtol=0, atol=1e-12)


def test_compiled_sums_are_those_of_python():
    from rotor_ida.equations.compiling import compiled

    draw = np.random.default_rng(0)
    left, right = draw.normal(size=(2, 9, LANES))
    factors, parts = draw.normal(size=(6, 9)), draw.normal(size=(2, 9, LANES))
    terms = draw.normal(size=(9, 8))

    def work(known, total, values):
        sum_known(left, right, known, 8)
        sum_products(factors, 3, parts, (0, 0), 7, total)
        evaluate(terms, 8, 0.3, values)

    plain, quick = ([np.ones(LANES), np.ones(LANES), np.ones(8)] for _ in range(2))
    work(*plain)
    compiled(work)(*quick)
    for expected, found in zip(plain, quick, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-13)


START, TIME = np.array([1.2, 0.3, -0.2, 0.9]), 0.4


def motion_from(state, rotor, vectors=()):
    z, v = complex(state[0], state[1]), complex(state[2], state[3])
    start = regularised(z, v, math.sqrt(abs(z) - rotor[2]))
    return begun(start, rotor=rotor, vectors=vectors)


def point_of(motion, time):
    low, high = motion.low, motion.point
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if motion.at(middle)[T] < time else (low, middle)
    return high


def state_at(state, rotor):
    motion = motion_from(state, rotor)
    while motion.values[T] < TIME:
        motion.advance()
    z, v = cartesian(motion.at(point_of(motion, TIME)), rotor[2])
    return np.array([z.real, z.imag, v.real, v.imag])


def by_central_differences(change):
    """Derivatives of the state at the end by what `change` makes of start and rotor, as columns."""
    h = 1e-5
    columns = [(state_at(*change(n, h)) - state_at(*change(n, -h))) / (2.0 * h) for n in range(3)]
    return np.stack(columns, axis=1)


def followed():
    """Matrix of the differences that the start makes at the end."""
    motion = motion_from(START, ROTOR, np.eye(4).ravel())
    while motion.values[T] < TIME:
        assert motion.advance() == GOES_ON
    return motion.at(point_of(motion, TIME))[7:].reshape(4, 4)


def test_differences_are_those_of_neighbours_at_equal_times():
    expected = by_central_differences(lambda n, h: (START + h * np.eye(4)[n], ROTOR))
    matrix = followed()
    np.testing.assert_allclose(matrix[:, :3], expected, rtol=0, atol=1e-9)
    # all areas shrink alike
    assert np.linalg.det(matrix) == pytest.approx(math.exp(-4.0 * ROTOR[1] * TIME), rel=1e-13)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"flight": "cvode"}, "flight must be 'exact' with taylor, got 'cvode'"),
        ({"rtol": 1e-3}, "rtol must lie from 1e-15 to 0.0001"),
        ({"rtol": 1e-16}, "rtol must lie from 1e-15 to 0.0001"),
    ],
)
def test_what_it_cannot_do_is_refused(settings, message):
    with pytest.raises(InputError, match=message):
        simulate(
            Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), duration=1.0,
            method="taylor", **settings,
        )  # fmt: skip
