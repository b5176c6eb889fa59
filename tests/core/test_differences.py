"""Differences carried along with a run: what each parameter adds, and which rows there may be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.runs import COLUMNS
from rotor_ida.simulation.flow import DiscFlow

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
    start = np.array([2.6, 0.75, 0.66, -1.65])

    def end(value):
        return DiscFlow(replace(rotor, **{name: value})).run(start, 6.0, by=COLUMNS).end

    shot, here, step = DiscFlow(rotor).run(start, 6.0, by=COLUMNS), getattr(rotor, name), 1e-6
    if here > 0.0:
        slope = (end(here + step) - end(here - step)) / (2.0 * step)
    else:
        slope = (4.0 * end(step) - end(2.0 * step) - 3.0 * end(0.0)) / (2.0 * step)
    found = shot.by[COLUMNS.index(name)]
    assert np.abs(found - slope).max() < 3e-8 * max(np.abs(slope).max(), 1.0)
    if not rotor.beyond:
        paper = DiscFlow(rotor).run(start, 6.0, by=COLUMNS[:3])
        np.testing.assert_allclose(paper.by, shot.by[:3], rtol=0.0, atol=1e-12)
        assert paper.tangents == pytest.approx(shot.tangents, abs=1e-12)
