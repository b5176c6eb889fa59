"""What no region holds is followed to its attractor, which then is known; chaos says how long."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import Rotor, basin_fractions, continue_cycle, limit_cycle
from rotor_ida.basins import fates
from rotor_ida.basins import known as known_module
from rotor_ida.basins.cycle_sections import cycle_section
from rotor_ida.basins.fates import Batch, decide
from rotor_ida.basins.kernel import CHAOTIC, NOT_COMPUTED, UNDECIDED
from rotor_ida.basins.known import known_from_closed_forms
from rotor_ida.schema import RESPONSE, TRAPPING
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
BOX = dict.fromkeys(("x", "y", "vx", "vy"), (-8.0, 8.0))


def batch_of(rotor, states, stop=None):
    stop = np.zeros(1, np.uint8) if stop is None else stop
    known = known_from_closed_forms(rotor, np.zeros(1, np.uint8))
    return Batch(known, states, 1e-6, stop)


def random_states(count, half_width=8.0, seed=0):
    return np.random.default_rng(seed).uniform(-half_width, half_width, (4, count))


def test_a_cycle_is_found_once_and_holds_the_others(monkeypatch):
    followed = []
    one_by_one = fates.fate_of

    def counted(batch, number):
        followed.append(number)
        return one_by_one(batch, number)

    monkeypatch.setattr(fates, "fate_of", counted)
    batch = batch_of(BOUNCER, random_states(200))
    decide(batch)
    assert len(batch.known.cycles) == 1
    exact = limit_cycle(BOUNCER, start=(0, 0, 0, 0))
    assert batch.known.cycles[0].cycle.duration == pytest.approx(float(exact.period), rel=1e-12)
    assert (batch.labels == batch.known.first_cycle).sum() > 50
    assert (batch.labels >= 0).all()
    assert len(followed) < 5


def test_close_to_a_period_doubling_orbits_creep_and_are_held_as_soon_as_others():
    """At omega 1.80339 the period doubles; the cycle's multiplier here is -0.9989.

    From return to return an orbit is nearer on one side and farther on the other, by turns: seen
    once round the set that returns into itself would be a tenth as wide, and be reached after 1,000
    units of time and more.
    """
    rotor = Rotor(omega=1.8036, zeta=0.07, delta0=2.0)
    batch = batch_of(rotor, np.vstack([random_states(40)[:2], np.zeros((2, 40))]))
    decide(batch)
    assert (batch.labels >= 0).all()
    (section,) = batch.known.cycles
    assert section.cycle.duration == pytest.approx(5.05367623, rel=1e-8)
    creeping = batch.labels == batch.known.first_cycle
    assert creeping.sum() > 5
    assert batch.times[creeping].max() < 500.0
    widths = 1.0 / np.linalg.svd(section.form, compute_uv=False)
    assert widths.min() > 0.03
    beside = section.centre + 0.5 * np.linalg.pinv(section.form)[:, 0]
    soon = DiscFlow(rotor, batch.stop).run(beside, 50.0).extrema["radius"].max()
    there = DiscFlow(rotor, batch.stop).run(beside, 3000.0).end
    late = DiscFlow(rotor, batch.stop).run(there, 50.0).extrema["radius"].max()
    radius_max = section.cycle.radius_max
    assert 0.0 < late - radius_max < 0.3 * (soon - radius_max)


def test_only_a_stable_cycle_beside_an_orbit_counts():
    """From rest beside the bouncing cycle, but not far out; below the doubling it is unstable."""
    settled = settle_disc(BOUNCER, (0.0, 0.0, 0.0, 0.0), Options())
    beside = np.array([settled.motion.state, (12.0, 0.0, 0.0, 0.0)]).T
    batch = batch_of(BOUNCER, beside)
    assert fates.beside_cycle(batch, 0)
    assert len(batch.known.cycles) == 1
    assert not fates.beside_cycle(batch, 1)
    assert fates.beside_cycle(batch, 0)
    assert len(batch.known.cycles) == 1
    unstable = continue_cycle(
        Rotor(omega=1.85, zeta=0.07, delta0=2.0), start=(0, 0, 0, 0), limits=(1.75, 1.85)
    )
    place = int(np.argmin(np.abs(unstable.omega.values - 1.78)))
    there = unstable.isel(point=place)
    rotor = Rotor(omega=float(there.omega), zeta=0.07, delta0=2.0)
    state = np.array([[float(there[name])] for name in ("x", "y", "vx", "vy")])
    batch = batch_of(rotor, state)
    assert not fates.beside_cycle(batch, 0)


def test_two_cycles_of_one_rotor_stay_apart():
    """Periods 21.47 and 64.38, one three times the other but for a thousandth."""
    found = basin_fractions(
        Rotor(omega=1.7, zeta=0.07, delta0=2.0), x=(-15, 15), y=(-15, 15), starts=400
    )
    periods = np.sort(found.period.values[np.isfinite(found.period)])
    assert periods == pytest.approx([21.467766, 64.381321], abs=1e-5)
    assert int(found.undecided_count) == 0
    assert (found.trapping == TRAPPING["estimated"]).sum() == 3


def test_chaos_that_lasts_says_so():
    found = basin_fractions(Rotor(omega=1.69, zeta=0.07, delta0=2.0), **BOX, starts=32)
    chaos = found.isel(attractor=int(np.flatnonzero(found.kind == RESPONSE["chaotic"])[0]))
    assert float(chaos.fraction) > 0.2
    assert math.isinf(float(chaos.lifetime))
    assert float(chaos.lifetime_low) > 1e4
    assert int(chaos.trapping) == TRAPPING["none"]
    assert 1.5 < float(chaos.radius_min) < float(chaos.radius_max) < 4.5


def test_chaos_that_is_a_transient_says_how_long_it_lasts():
    found = basin_fractions(Rotor(omega=1.5, zeta=0.01, delta0=2.0), **BOX, starts=100)
    chaos = found.isel(attractor=int(np.flatnonzero(found.kind == RESPONSE["chaotic"])[0]))
    assert 0.1 < float(chaos.fraction) < 0.5
    # some ten of them leave while they are watched; were it none, the bound would be 46,000
    assert 3e3 < float(chaos.lifetime_low) < 1e5
    assert float(chaos.lifetime) > float(chaos.lifetime_low)


NARROW = {
    "beside a doubling": (Rotor(omega=1.8036, zeta=0.07, delta0=2.0), 12),
    "weak chaos": (Rotor(omega=1.69, zeta=0.07, delta0=2.0), 6),
    "chaos that is left": (Rotor(omega=1.5, zeta=0.01, delta0=2.0), 12),
}


def names_of(batch):
    """What each label means, whatever its number: cycles by their periods."""
    first, cycles = batch.known.first_cycle, batch.known.cycles
    return [
        round(cycles[number - first].cycle.duration, 6) if number >= first else number
        for number in batch.labels.tolist()
    ]


@pytest.mark.parametrize("name", NARROW)
@pytest.mark.parametrize("sections", [True, False])
def test_no_label_hangs_on_what_else_is_in_the_batch(name, sections, monkeypatch):
    """The first half of some starts, alone and with the others, with sections of cycles or not."""
    if not sections:
        monkeypatch.setattr(known_module, "cycle_section", without_a_set)
    rotor, count = NARROW[name]
    count = count if sections else 2
    states, half = random_states(count, seed=1), count // 2
    alone, together = decide(batch_of(rotor, states[:, :half])), decide(batch_of(rotor, states))
    assert names_of(alone) == names_of(together)[:half]


def without_a_set(cycle, stop):
    """A section of a cycle that holds nothing."""
    return replace(cycle_section(cycle, stop), form=np.full((3, 4), np.inf))


def test_all_that_are_left_over_are_followed(monkeypatch):
    """However many in turn are not decided, each is, for as long as the others."""
    monkeypatch.setattr(fates, "fate_of", lambda batch, number, longest=0.0: UNDECIDED)
    monkeypatch.setattr(fates, "beside_cycle", lambda batch, number: False)
    batch = decide(batch_of(Rotor(omega=1.8034, zeta=0.07, delta0=2.0), random_states(40)))
    left = batch.labels == UNDECIDED
    assert left.sum() > 10
    assert (batch.times[left] >= fates.longest_time(batch.known.rotor)).all()


def test_the_time_of_an_orbit_followed_alone_counts():
    """What it took from where the others left it is part of the time after which it was decided."""
    batch = batch_of(BOUNCER, np.array([[0.0], [0.0], [0.0], [0.0]]))
    batch.follow(np.arange(1), 10.0)
    passed = float(batch.times[0])
    label = fates.fate_of(batch, 0)
    assert label == batch.known.first_cycle
    assert float(batch.times[0]) > passed + 300.0


def test_a_batch_that_is_stopped_is_not_computed():
    batch = batch_of(BOUNCER, random_states(100), np.ones(1, np.uint8))
    decide(batch)
    assert (batch.labels == NOT_COMPUTED).all()
    assert not {UNDECIDED, CHAOTIC} & set(batch.labels.tolist())


def test_beside_touches_that_fade_the_others_are_followed_together(monkeypatch):
    """One by one, nine starts of a fast rotor would take a minute."""
    looked_at = []

    def fading(batch, number):
        looked_at.append(number)
        batch.times[number] += 3000.0
        return batch.known.fading_label

    monkeypatch.setattr(fates, "fate_of", fading)
    batch = batch_of(Rotor(omega=100.0, zeta=1.0, delta0=1.0), random_states(9, half_width=3.0))
    decide(batch)
    assert len(looked_at) == 1
    assert (batch.labels == batch.known.fading_label).all()
