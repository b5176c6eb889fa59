"""What parameters add over a stretch, against differences of whole stretches."""

from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.core.interface import DONE
from rotor_ida.core.runs import COLUMNS, RunRequest, follow_run
from rotor_ida.simulation.flow import DiscFlow

START = (1.2, 0.3, -0.2, 0.9)
CONTACT = Rotor(omega=1.2, zeta=0.07, delta0=0.5)
FREE = Rotor(omega=1.2, zeta=0.07, delta0=0.0)
FLIGHT = Rotor(omega=1.2, zeta=0.07, delta0=9.0)


def followed(rotor, duration, bundle=None):
    asked = RunRequest(
        rotor=rotor, start=START, duration=duration, rtol=1e-15, atol=1e-17, bundle=bundle
    )
    seen = follow_run(asked)
    assert seen.status == DONE
    return np.array(seen.state)


@pytest.mark.parametrize("duration", [0.05, 0.4])
@pytest.mark.parametrize("rotor", [CONTACT, FREE, FLIGHT], ids=["contact", "free", "flight"])
def test_parameters_add_the_differences_of_neighbouring_rotors(rotor, duration):
    """Central differences of the state at one time, within one phase."""
    h, bundle = 1e-5, np.zeros((7, 4))
    end = followed(rotor, duration, bundle)
    np.testing.assert_array_equal(bundle[:4], 0.0)
    np.testing.assert_allclose(end, followed(rotor, duration), rtol=0.0, atol=1e-14)
    for name, added in zip(("omega", "zeta", "delta0"), bundle[4:], strict=True):
        if name == "delta0" and rotor is not CONTACT:
            assert not added.any()
            continue
        value = getattr(rotor, name)
        ahead, behind = (
            followed(replace(rotor, **{name: value + sign * h}), duration) for sign in (1, -1)
        )
        np.testing.assert_allclose(added, (ahead - behind) / (2.0 * h), rtol=0, atol=1e-9)


def test_what_is_added_comes_on_top_of_what_there_was():
    """Rows begin where they are and are carried by the flow like any difference."""
    rows = np.random.default_rng(0).normal(size=(7, 4))
    bundle, alone, matrix = rows.copy(), np.zeros((7, 4)), np.eye(4)
    for each in (bundle, alone, matrix):
        followed(CONTACT, 3.0, each)
    np.testing.assert_allclose(bundle, rows @ matrix + alone, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("delta0", [2.0, 0.0], ids=["bouncing", "free"])
def test_a_load_that_turns_faster_adds_to_what_the_speed_does(delta0):
    """Central differences over two revolutions, with entries and exits."""
    rotor = Rotor(omega=1.6, zeta=0.07, delta0=delta0, load=0.3)
    start, duration, h = np.array([2.1, 0.3, 0.5, -0.4]), 4.0 * np.pi / 1.6, 1e-6
    shot = DiscFlow(rotor).run(start, duration, by=COLUMNS)
    for name in ("omega", "zeta", "delta0", "load"):
        value = getattr(rotor, name)
        if value == 0.0:
            continue
        ends = [
            DiscFlow(replace(rotor, **{name: value + sign * h}))
            .run(start, duration, by=COLUMNS)
            .end
            for sign in (1, -1)
        ]
        column = shot.by[COLUMNS.index(name)]
        np.testing.assert_allclose(column, (ends[0] - ends[1]) / (2.0 * h), rtol=0, atol=1e-7)
    ends = [DiscFlow(rotor).run(start, duration + sign * h).end for sign in (1, -1)]
    np.testing.assert_allclose(shot.end_rate, (ends[0] - ends[1]) / (2.0 * h), rtol=0, atol=1e-7)
