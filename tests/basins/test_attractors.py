"""Rows of attractors: numbered in a fixed order, exact, and confirmed by CVODE where it agrees."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor, basin_fractions, limit_cycle
from rotor_ida.basins.attractors import Attractor, attractors_of, confirmed, leads_to
from rotor_ida.basins.following import FollowedStarts
from rotor_ida.basins.kernel import CHAOTIC, UNDECIDED
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.cycles.guess import guess_of
from rotor_ida.cycles.limit_cycle import cycle_from
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.options import Options
from tests.basins.lanes import WHIP

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
BOX = {"x": (-15, 15), "y": (-15, 15)}


def found_with(labels, cycles=(), chaos=(), left=0.0, watched=0.0):
    labels = np.array(labels, dtype=np.int16)
    known = known_from_closed_forms(BOUNCER, np.zeros(1, np.uint8))
    times = np.zeros(labels.size, np.float32)
    motions = {CHAOTIC: np.array(chaos).reshape(-1, 4)}
    return FollowedStarts(
        known, labels, times, list(cycles), [True] * len(cycles), motions, left, watched
    )


def test_labels_number_the_rows():
    """Only what starts end on, but whirls and the contact-free family."""
    cycle = cycle_from(guess_of(BOUNCER, np.zeros(4)))
    found = found_with([CHAOTIC, 2, UNDECIDED, 0, 2], [cycle], [[1.0, 0.0, 0.5, 3.0]], 2.0, 4e4)
    rows = attractors_of(found)
    assert [each.kind for each in rows] == ["contact_free", "bouncing", "chaotic"]
    assert found.labels.tolist() == [2, 1, UNDECIDED, 0, 1]
    assert rows[1].period == cycle.duration
    assert rows[2].lifetime == 2e4
    # 95 % of samples with a mean of 6.296 hold more than two
    assert rows[2].lifetime_low == pytest.approx(4e4 / 6.2958, rel=1e-4)


def test_numbers_are_those_of_the_limit_cycle():
    table = basin_fractions(BOUNCER, **BOX, starts=100)
    row = table.isel(attractor=int(np.flatnonzero(np.isfinite(table.period))[0]))
    exact = limit_cycle(BOUNCER, start=(0, 0, 0, 0))
    for name in ("period", "radius_min", "radius_max"):
        assert float(row[name]) == pytest.approx(float(exact[name]), rel=1e-11)
    spin = float(exact.whirl_amplitude[exact.line_kind.values == 0][0])
    assert float(row.amplitude) == pytest.approx(spin, rel=1e-9)


def test_fading_touches_tend_to_the_whirl_that_just_reaches_the_ring():
    table = basin_fractions(BOUNCER, **BOX, starts=2000)
    row = table.isel(attractor=1)
    assert float(row.radius_max) == BOUNCER.delta0
    assert float(row.radius_min) == pytest.approx(2.0 * float(row.amplitude) - 2.0, abs=1e-2)
    assert 0.0 < float(row.fraction) < 0.02


def test_what_cvode_does_not_find_is_not_confirmed():
    cycle = cycle_from(guess_of(BOUNCER, np.zeros(4)))
    right = Attractor("bouncing", 1.1, 0.0, cycle.radius_min, cycle.radius_max, cycle.duration)
    wrong = replace(right, radius_max=1.001 * cycle.radius_max)
    rows = [right, wrong, replace(right, kind="full_contact"), right]
    found = found_with([0, 1, 2])
    checked = confirmed(found, rows, lambda first, last: cycle.start[:, None], Options())
    assert [each.confirmed for each in checked] == [True, False, False, False]


def test_of_two_kinds_of_whip_cvode_confirms_none_by_the_other():
    """What rolls with a period is no witness of what rolls without one."""
    start, options = np.array([5.0, 0.0, 0.0, -6.3]), Options()
    cycle = limit_cycle(WHIP, start=start)
    radii = (cycle.radius_min.item(), cycle.radius_max.item())
    periodic = Attractor("rolling", 0.278, 0.0, *radii, cycle.period.item())
    assert leads_to(WHIP, periodic, start, options)
    assert not leads_to(WHIP, replace(periodic, period=math.nan), start, options)
    assert not leads_to(WHIP, replace(periodic, period=1.001 * periodic.period), start, options)


def test_a_contact_free_whirl_that_a_shaft_holds_has_a_radius():
    """It is one, and no family whose radii depend on the start."""
    found = basin_fractions(
        Rotor(omega=3.0, zeta=0.1, delta0=1.5, shaft_stiffness=1.0), x=(-1, 1), y=(-1, 1), starts=64
    )
    (number,) = np.flatnonzero(found.kind == RESPONSE["contact_free"])
    exact = 9.0 / abs(complex(1.0 - 9.0, 2.0 * 0.1 * 3.0))
    for name in ("amplitude", "radius_min", "radius_max"):
        assert float(found[name][number]) == pytest.approx(exact, rel=1e-14)
    assert bool(found.confirmed[number])
