"""What is committed is what the model gives, and what is derived is right."""

import numpy as np
import pytest

from rotor_ida.model import derivation, writing
from rotor_ida.model.derivation import derive
from rotor_ida.model.modes import PAPER
from rotor_ida.model.writing import FOLDER, MODELS
from tests.model.symbolic import value_of
from tests.model.test_modes import (
    STEP,
    centre,
    changed,
    is_contact,
    of_cases,
    rotating_rates,
)

EACH = [
    pytest.param(model, mode, id=f"{model.name}-{mode.name}")
    for model in MODELS
    for mode in model.modes
]
# Lanes that the series of a state may take: whole vectors of four.
MOST_LANES = {"paper": 16, "whole": 20, "run_up": 32}


def test_the_committed_files_are_those_that_the_command_writes(monkeypatch, tmp_path):
    """Else run the command of their first line."""
    if not (FOLDER / "derived.c").is_file():
        pytest.skip("an installed package has no sources")
    monkeypatch.setattr(writing, "FOLDER", tmp_path)
    writing.main()
    written = {path.name: path.read_text("utf-8") for path in tmp_path.iterdir()}
    assert written == {path.name: path.read_text("utf-8") for path in FOLDER.glob("derived*")}
    assert all(writing.COMMAND in text.splitlines()[0] for text in written.values())


def numbers(matrix, state, rotor, mode):
    """Return a matrix of symbols as numbers."""
    named = dict(zip(mode.state, state, strict=True))
    return np.array([[value_of(entry, rotor, named) for entry in row] for row in matrix])


def read(pair, direction):
    """Return displacement and velocity by four components in a basis."""
    z, w = (each / direction for each in pair[:2])
    return np.array([z.real, z.imag, w.real, w.imag])


@of_cases
def test_rates_and_jacobian_are_those_of_the_model(model, mode, states):
    derived = derive(mode, model)
    for state, rotor in states(model, 10):
        for found, way in ((derived.rates, mode.rates), (derived.drawn_rates, mode.drawn_rates)):
            rates = numbers([found], state, rotor, mode)[0]
            np.testing.assert_allclose(rates, way(state, rotor), rtol=1e-11, atol=1e-13)
        matrix = numbers(derived.jacobian, state, rotor, mode)
        for place in range(len(state)):
            aside = STEP * np.eye(len(state))[place]
            high, low = (
                np.array(mode.drawn_rates((state + sign * aside).tolist(), rotor))
                for sign in (1, -1)
            )
            slope = (high - low) / (2.0 * STEP)
            np.testing.assert_allclose(matrix[:, place], slope, rtol=1e-6, atol=1e-6)


@of_cases
def test_growth_is_that_of_differences_of_the_equation_in_a_basis_that_turns(model, mode, states):
    """d' = (R^T J R - Omega E) d by time: J of DESIGN section 2 by differences, Omega the rate at
    which the basis R turns on the rotating axes, E a quarter turn."""
    derived = derive(mode, model)
    quarter = np.kron(np.eye(2), [[0.0, -1.0], [1.0, 0.0]])
    for state, rotor in states(model, 10):
        z, w, down, e = centre(mode, state, rotor)
        columns = []
        for unit in np.eye(4):
            dz, dw = complex(*unit[:2]) * e, complex(*unit[2:]) * e
            high, low = (
                read(rotating_rates(z + sign * dz, w + sign * dw, down, rotor), e)
                for sign in (STEP, -STEP)
            )
            columns.append((high - low) / (2.0 * STEP))
        turning = (z.conjugate() * w).imag / abs(z) ** 2 - rotor.omega if is_contact(mode) else 0.0
        expected = mode.pace(state) * (np.array(columns).T - turning * quarter)
        found = numbers(derived.growth, state, rotor, mode)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


@of_cases
def test_parameters_add_the_differences_of_the_equation(model, mode, states):
    derived = derive(mode, model)
    for state, rotor in states(model, 10):
        z, w, down, e = centre(mode, state, rotor)
        found = numbers(derived.by_parameters, state, rotor, mode)
        for place, name in enumerate(model.columns):
            if name in {"delta0", "contact_damping"} and not is_contact(mode):
                assert not found[place].any()
                continue
            others = (
                changed(rotor, **{name: getattr(rotor, name) + sign}) for sign in (STEP, -STEP)
            )
            high, low = (read(rotating_rates(z, w, down, other), e) for other in others)
            slope = (high - low) / (2.0 * STEP)
            np.testing.assert_allclose(found[place], slope, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(("model", "mode"), EACH)
def test_what_is_constant_takes_no_convolution(model, mode):
    """Lanes are the products and quotients of what changes: each costs its share of a step."""
    needed = derivation.needed(derive(mode, model).rates)
    lanes = [*filter(derivation.needs_convolution, needed)]
    for node in lanes:
        *_, last = derivation.operands(node)
        assert last.changes
        assert node.kind != "*" or node.arguments[0].changes
    assert sum(map(derivation.lanes_of, lanes)) <= MOST_LANES[model.name]


def test_the_paper_s_rotor_is_not_asked_for_more():
    """What it has not is no parameter of what is derived for it."""
    for mode in PAPER.modes:
        derived = derive(mode, PAPER)
        rows = [derived.rates, derived.drawn_rates, *derived.jacobian, *derived.growth]
        needed = derivation.needed(entry for row in rows for entry in row)
        asked = {node.arguments[0] for node in needed if node.kind == "parameter"}
        assert asked <= {"omega", "zeta", "delta0", "felt"}
