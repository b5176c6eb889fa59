"""Rows of attractors: numbered in a fixed order, exact, and confirmed by CVODE where it agrees."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, basin_fractions, limit_cycle
from rotor_ida.basins.attractors import Attractors, Followed, confirm, disc_row, leads_to
from rotor_ida.basins.disc import Disc, cycle_row
from rotor_ida.basins.following import BatchResult, follow_starts
from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.core.runs import NO_STOP
from rotor_ida.cycles.guess import guess_of
from rotor_ida.cycles.limit_cycle import cycle_from
from rotor_ida.parallel import Workers
from rotor_ida.results.studies.results import Results
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from tests.basins.lanes import WHIP

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
BOX = {"x": (-15, 15), "y": (-15, 15)}


def changed(row, **numbers):
    row = row.copy()
    for name, number in numbers.items():
        row[name] = number
    return row


def test_labels_number_the_rows():
    """Of all batches, each with its own numbers; whirls in flight are listed without starts."""
    disc = Disc.of(BOUNCER, 1e-6, NO_STOP)
    cycle = cycle_row(cycle_from(guess_of(BOUNCER, np.zeros(4))), True)
    chaos = disc_row("chaotic", 1.0, 0.0, 0.5, 3.0)
    kept = Results()
    for number, (rows, watched) in enumerate((([chaos, cycle], (2.0, 3e4)), ([cycle], (0.0, 1e4)))):
        labels = np.array([0, len(rows) - 1, UNDECIDED], np.int16)
        rechecked = np.array([2, 1])
        kept.keep(number, BatchResult(
            512 * number, labels, np.zeros(3, np.float32), np.array(rows), np.array(watched), 1e-6,
            rechecked), 3)  # fmt: skip
    found = follow_starts(
        disc, lambda *_: np.empty((4, 0)), 515, kept, workers=Workers("serial", 1), progress=None
    )
    assert found.kinds == ["contact_free", "bouncing", "chaotic"]
    assert found.labels[[0, 1, 2, 512, 513, 514]].tolist() == [2, 1, UNDECIDED, 1, 1, UNDECIDED]
    assert found.rows["period"][1] == cycle["period"]
    assert found.rechecked.tolist() == [4, 2]
    assert found.rows["lifetime"][2] == 2e4
    # 95 % of samples with a mean of 6.296 hold more than two
    assert found.rows["lifetime_low"][2] == pytest.approx(4e4 / 6.2958, rel=1e-4)


def test_whirls_beside_a_fold_stay_two():
    """One batch lists both, however near; one found later is the first that it agrees with."""
    whirl = disc_row("synchronous", 3.0, 0.0, 3.0, 3.0, state=[3.0, 0.0, 0.0, 6.0])
    other = changed(whirl, final_state=(1.0 + 1e-7) * whirl["final_state"])
    met = Attractors(DiscFlow(BOUNCER))
    assert met.numbers_of([whirl, other]) == [0, 1]
    assert met.numbers_of([whirl, other]) == [0, 1]
    assert met.find(other) == 0
    assert met.find(changed(whirl, final_state=1.001 * whirl["final_state"])) is None


def test_fading_touches_tend_to_the_whirl_that_just_reaches_the_ring():
    table = basin_fractions(BOUNCER, **BOX, starts=2000)
    row = table.isel(attractor=1)
    assert float(row.radius_max) == BOUNCER.delta0
    assert float(row.radius_min) == pytest.approx(2.0 * float(row.amplitude) - 2.0, abs=1e-2)
    assert 0.0 < float(row.fraction) < 0.02


def test_what_cvode_does_not_find_is_not_confirmed():
    right = cycle_row(cycle_from(guess_of(BOUNCER, np.zeros(4))), True)
    wrong = changed(right, radius_max=1.001 * right["radius_max"])
    rows = np.array([right, wrong, changed(right, response=RESPONSE["full_contact"]), right])
    found = Followed(np.array([0, 1, 2], np.int16), np.zeros(3, np.float32), rows, 1e-6)
    start = right["final_state"][:, None]
    confirm(BOUNCER, found, lambda first, last: start, Options(), can_stop=False)
    assert found.rows["confirmed"].tolist() == [1, 0, 0, 0]


def test_of_two_kinds_of_whip_cvode_confirms_none_by_the_other():
    """What rolls with a period is no witness of what rolls without one."""
    start, options = np.array([5.0, 0.0, 0.0, -6.3]), Options()
    cycle = limit_cycle(WHIP, start=start)
    radii = (cycle.radius_min.item(), cycle.radius_max.item())
    periodic = disc_row("rolling", 0.278, 0.0, *radii, period=cycle.period.item())
    assert leads_to(WHIP, periodic, start, options)
    assert not leads_to(WHIP, changed(periodic, period=math.nan), start, options)
    longer = changed(periodic, period=1.001 * periodic["period"])
    assert not leads_to(WHIP, longer, start, options)


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
