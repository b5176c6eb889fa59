"""Formulas spelled out in plain text read as formulas, and nothing else is touched."""

import pytest

from rotor_ida.paper.typesetting import typeset


@pytest.mark.parametrize(
    ("plain", "shown"),
    [
        ("omega = 1.7, delta0 = 0.5", "ω = 1.7, δ<sub>0</sub> = 0.5"),
        ("C3 exp(lambda1 t)", "C<sub>3</sub> exp(λ<sub>1</sub> t)"),
        ("|z'|^2/2 + V", "|z′|<sup>2</sup>/2 + V"),
        ("A = (1.25 y0'^2)^0.4", "A = (1.25 y<sub>0</sub>′<sup>2</sup>)<sup>0.4</sup>"),
        ("f_x at (1, 0)", "f<sub>x</sub> at (1, 0)"),
        ("agree to 2e-10, 8e+02", "agree to 2·10<sup>−10</sup>, 8·10<sup>2</sup>"),
        ("exponents -0.07 and x' = -15", "exponents −0.07 and x′ = −15"),
        ("eqs (24)-(28)", "eqs (24)–(28)"),
        ("the runs' ends, a one-harmonic curve", "the runs' ends, a one-harmonic curve"),
        ("a < b & c", "a &lt; b &amp; c"),
    ],
)
def test_formula_is_set(plain, shown):
    assert typeset(plain) == shown
