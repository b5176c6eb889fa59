"""What is committed is what the model gives, and what is derived is right."""

from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida.equations import derivation, writing
from rotor_ida.equations.derivation import PARAMETERS, derive
from rotor_ida.equations.modes import CARTESIAN, CONTACT, MODES
from rotor_ida.equations.symbols import Graph
from rotor_ida.equations.writing import FOLDER, sources
from tests.equations.symbolic import value_of
from tests.equations.test_modes import (
    STEP,
    cartesian_states,
    centre,
    contact_states,
    rotating_rates,
    rotor_of,
)

CASES = [
    pytest.param(CONTACT, contact_states, id="contact"),
    pytest.param(CARTESIAN, cartesian_states, id="cartesian"),
]


@pytest.mark.parametrize("name", ["derived.c", "derived.h"])
def test_the_committed_files_are_those_that_the_model_gives(name):
    """Else run the command of their first line."""
    if not (FOLDER / name).is_file():
        pytest.skip("an installed package has no sources")
    assert (FOLDER / name).read_text("utf-8") == sources()[name]


def test_the_command_writes_them(monkeypatch, tmp_path):
    monkeypatch.setattr(writing, "FOLDER", tmp_path)
    writing.main()
    assert {path.name: path.read_text("utf-8") for path in tmp_path.iterdir()} == sources()
    assert writing.COMMAND in sources()["derived.c"].splitlines()[0]


def numbers(matrix, state, parameters, mode):
    """Return a matrix of symbols as numbers."""
    named = dict(zip(mode.state, state, strict=True))
    rotor = rotor_of(*parameters)
    return np.array([[value_of(entry, rotor, named) for entry in row] for row in matrix])


def read(pair, direction):
    """Return displacement and velocity by four components in a basis."""
    z, w = (each / direction for each in pair)
    return np.array([z.real, z.imag, w.real, w.imag])


@pytest.mark.parametrize(("mode", "states"), CASES)
def test_rates_and_jacobian_are_those_of_the_model(mode, states):
    derived = derive(mode)
    for state, parameters in states(10):
        rates = numbers([derived.rates], state, parameters, mode)[0]
        np.testing.assert_allclose(rates, mode.rates(state, rotor_of(*parameters)), rtol=1e-12)
        drawn = numbers([derived.drawn_rates], state, parameters, mode)[0]
        expected = mode.drawn_rates(state, rotor_of(*parameters))
        np.testing.assert_allclose(drawn, expected, rtol=1e-12, atol=1e-14)
        matrix = numbers(derived.jacobian, state, parameters, mode)
        for place in range(len(state)):
            aside = STEP * np.eye(len(state))[place]
            high, low = (
                np.array(mode.drawn_rates((state + sign * aside).tolist(), rotor_of(*parameters)))
                for sign in (1, -1)
            )
            slope = (high - low) / (2.0 * STEP)
            np.testing.assert_allclose(matrix[:, place], slope, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(("mode", "states"), CASES)
def test_growth_is_that_of_differences_of_the_equation_in_a_basis_that_turns(mode, states):
    """d' = (R^T J R - Omega E) d by time: J of DESIGN section 2 by differences, Omega the rate at
    which the basis R turns on the rotating axes, E a quarter turn."""
    derived = derive(mode)
    quarter = np.kron(np.eye(2), [[0.0, -1.0], [1.0, 0.0]])
    for state, parameters in states(10):
        z, w, e = centre(state, parameters[2])
        columns = []
        for unit in np.eye(4):
            dz, dw = complex(*unit[:2]) * e, complex(*unit[2:]) * e
            high, low = (
                read(rotating_rates(z + sign * dz, w + sign * dw, *parameters), e)
                for sign in (STEP, -STEP)
            )
            columns.append((high - low) / (2.0 * STEP))
        turning = (z.conjugate() * w).imag / abs(z) ** 2 - parameters[0] if mode is CONTACT else 0.0
        expected = mode.pace(state) * (np.array(columns).T - turning * quarter)
        found = numbers(derived.growth, state, parameters, mode)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(("mode", "states"), CASES)
def test_parameters_add_the_differences_of_the_equation(mode, states):
    derived = derive(mode)
    for state, parameters in states(10):
        z, w, e = centre(state, parameters[2])
        found = numbers(derived.by_parameters, state, parameters, mode)
        for place in range(3 if mode is CONTACT else 2):
            aside = STEP * np.eye(3)[place]
            high, low = (
                read(rotating_rates(z, w, *(parameters + sign * aside)), e) for sign in (1, -1)
            )
            slope = (high - low) / (2.0 * STEP)
            np.testing.assert_allclose(found[place], slope, rtol=1e-6, atol=1e-6)
        if mode is CARTESIAN:
            assert not found[2].any()


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
def test_what_is_constant_takes_no_convolution(mode):
    """Lanes are the products and quotients of what changes: each costs its share of a step."""
    lanes = [*filter(derivation.needs_convolution, derivation.needed(derive(mode).rates))]
    for node in lanes:
        *_, last = derivation.operands(node)
        assert last.changes
        assert node.kind != "*" or node.arguments[0].changes
    assert sum(map(derivation.lanes_of, lanes)) <= 16


def test_a_new_force_reaches_everything_that_is_derived(monkeypatch):
    """A stiffness of the shaft, added to the stated line alone, shows in all that is derived."""
    from rotor_ida.equations import modes

    stated = modes.acceleration
    with_shaft = lambda along, push, rotor: stated(along, push, rotor) - 3.0 * along.position  # noqa: E731
    monkeypatch.setattr(modes, "acceleration", with_shaft)
    changed = derive(CARTESIAN)
    monkeypatch.undo()
    before = derive(CARTESIAN)
    state, parameters = [0.3, -0.2, 0.1, 0.7], (1.2, 0.07, 0.0)
    for name in ("jacobian", "growth"):
        more = [numbers(getattr(each, name), state, parameters, CARTESIAN)
                for each in (changed, before)]  # fmt: skip
        expected = np.zeros((4, 4))
        expected[2, 0] = expected[3, 1] = -3.0
        np.testing.assert_allclose(more[0] - more[1], expected, rtol=0.0, atol=1e-14)


def test_constants_are_folded_and_what_is_one_is_kept_once():
    graph = Graph()
    x, a = graph.state("x"), graph.parameter("a")
    assert (2.0 * x) * 3.0 is 6.0 * x
    assert x * 0.0 is graph.of(0.0)
    assert x + x is 2.0 * x
    assert x - 0.0 is x
    assert (a * x) * (a * x) is (a * a) * (x * x)
    assert x / a is (1.0 / a) * x
    assert x * x is x * x


def test_parameters_are_those_of_a_rotor():
    rotor = SimpleNamespace(**dict.fromkeys(PARAMETERS, 0.0))
    for mode in MODES:
        mode.rates([1.0] * len(mode.state), rotor)
