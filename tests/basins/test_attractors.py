"""Clustering: different attractors stay apart, a chaotic one stays whole, doubt is reported."""

import numpy as np
import pytest

from rotor_ida import Rotor
from rotor_ida.basins import attractors as attractors_module
from rotor_ida.basins import following
from rotor_ida.basins.attractors import Attractor, attractors_of
from rotor_ida.basins.batches import BatchResult, Undecided
from rotor_ida.basins.following import FollowedStarts
from rotor_ida.basins.kernel import UNDECIDED
from rotor_ida.basins.known_attractors import known_attractors
from rotor_ida.simulation.options import Options
from rotor_ida.storage.studies.results import Results

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.fixture
def confirmed(monkeypatch):
    """Let CVODE see whatever the kernel saw."""
    monkeypatch.setattr(attractors_module, "_confirm", lambda _rotor, attractor, *_: attractor)


def results_of(rotor, earlier, later):
    """Return results in which every start is undecided, with these features."""
    count = len(later)
    orbits = Undecided(
        np.arange(count),
        np.asarray(earlier, dtype=np.float32),
        np.asarray(later, dtype=np.float32),
        np.zeros((4, count)),
    )
    labels = np.full(count, UNDECIDED, dtype=np.int16)
    times = np.zeros(count, np.float32)
    kept = Results()
    kept.keep(0, BatchResult(0, labels.copy(), times, orbits), count)
    return FollowedStarts(known_attractors(rotor), labels, times, kept, count)


def radii(low, high, count, scatter, seed=0):
    random = np.random.default_rng(seed)
    columns = np.zeros((count, 5))
    columns[:, 0] = low + scatter * random.uniform(-1.0, 1.0, count)
    columns[:, 1] = high + scatter * random.uniform(-1.0, 1.0, count)
    columns[:, 4] = high
    return columns


def found_in(results):
    nobody = [np.empty((0, 4))] * (len(results.known.regions) + results.known.has_free)
    return attractors_of(results, nobody, Options())


def test_two_periodic_motions_are_two_attractors(confirmed):
    """They differ by one part in a hundred; from one window to the next, in ten thousand."""
    one, two = radii(1.9, 4.10, 30, 1e-4), radii(1.9, 4.15, 20, 1e-4)
    results = results_of(BOUNCER, np.vstack([one, two]), np.vstack([one, two]) + 1e-5)
    found = found_in(results)
    assert [each.kind for each in found] == ["contact_free", "bouncing", "bouncing"]
    assert results.labels.tolist() == [1] * 30 + [2] * 20


@pytest.mark.parametrize("count", [12, 300, 4000])
def test_a_chaotic_motion_is_one_attractor(confirmed, count):
    earlier = radii(1.5, 4.0, count, 0.3, seed=1)
    results = results_of(BOUNCER, earlier, radii(1.5, 4.0, count, 0.3, seed=2))
    assert len(found_in(results)) == 2
    assert (results.labels == 1).mean() > 0.9


def test_motions_that_die_away_stay_undecided(confirmed):
    later = radii(1.9, 2.2, 10, 1e-4)
    results = results_of(BOUNCER, radii(1.9, 2.4, 10, 1e-4), later)
    assert len(found_in(results)) == 1
    assert (results.labels == UNDECIDED).all()


def test_touches_that_get_slighter_for_ever_are_no_bouncing(confirmed):
    """They can last for so long that two windows agree; but each pushes inwards."""
    rotor = Rotor(omega=1.0, zeta=1.0, delta0=3.0)
    features = radii(2.1, 3.0027, 10, 1e-5)
    whirl = -rotor.omega / complex(rotor.omega, -2.0 * rotor.zeta)
    features[:, 2:4] = whirl.real, whirl.imag
    results = results_of(rotor, features, features)
    found_in(results)
    assert (results.labels == UNDECIDED).all()


def test_an_orbit_near_a_stable_whirl_and_nearing_it_belongs_to_it(confirmed):
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.5)
    results = results_of(rotor, np.zeros((2, 5)), np.zeros((2, 5)))
    x, y = results.known.regions[1].centre[:2]
    radius = np.hypot(x, y)
    orbits = next(results.undecided())
    orbits.earlier[:] = radius, radius, x, y, 0.3
    orbits.later[:] = radius, radius, x, y, 0.1
    orbits.later[1, 4] = 0.29  # this one does not come nearer
    found_in(results)
    assert results.labels.tolist() == [1, UNDECIDED]


def test_of_very_many_orbits_a_sample_is_clustered_and_the_rest_matched(confirmed, monkeypatch):
    """Two periodic motions and one of wide scatter: the same labels as when all are compared."""
    one, two = radii(1.9, 4.10, 300, 1e-4), radii(1.9, 4.15, 200, 1e-4, seed=1)
    dying = radii(1.9, 2.4, 10, 1e-4)
    earlier = np.vstack([one, dying, two])
    later = np.vstack([one, radii(1.9, 2.2, 10, 1e-4), two])
    whole = results_of(BOUNCER, earlier, later)
    found_in(whole)
    assert np.unique(whole.labels, return_counts=True)[1].tolist() == [10, 300, 200]
    monkeypatch.setattr(following, "LARGEST_SAMPLE", 60)
    some = results_of(BOUNCER, earlier, later)
    assert some.sample().numbers.tolist() == list(range(0, 510, 9))
    found_in(some)
    np.testing.assert_array_equal(some.labels, whole.labels)


def test_what_cvode_denies_is_undecided():
    """The features are of bouncing, but from these states CVODE finds the contact-free whirl."""
    features = radii(1.9, 4.1, 5, 1e-4)
    results = results_of(BOUNCER, features, features)
    x, y, _ = results.known.free
    next(results.undecided()).states[:] = np.array([[x], [y], [-2.0 * y], [2.0 * x]])
    assert len(found_in(results)) == 1
    assert (results.labels == UNDECIDED).all()


def test_after_an_interrupt_nothing_is_confirmed_but_all_is_labelled():
    features = radii(1.9, 4.1, 5, 1e-4)
    results = results_of(BOUNCER, features, features)
    results.interrupted = True
    found = found_in(results)
    assert (results.labels == 1).all()
    assert not any(each.confirmed for each in found)
    assert isinstance(found[1], Attractor)
    assert found[1].radius_max == pytest.approx(4.1, abs=1e-3)
