"""Where attractors end: at the folds of the closed forms, and the special points of branches."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    continue_cycle,
    folds,
    limit_cycle,
    synchronous_response,
)
from rotor_ida.basins.atlas.extents import (
    End,
    extent_of_contact_free,
    extent_of_cycle,
    extent_of_whirl,
    varied,
)
from rotor_ida.closed_forms import eigenvalues, stability_determinant
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.cycles.guess import guess_of
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.schema import SPECIAL
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc
from tests.basins.atlas.reports import WIDE
from tests.basins.lanes import WHIP

STOP = np.zeros(1, np.uint8)


def with_value(rotor, name, value):
    return Rotor(**{each: getattr(rotor, each) for each in PARAMETERS} | {name: value})


def stable_whirls(**parameters):
    """Return the amplitudes of the stable whirls in contact over one parameter; else NaN."""
    whirls = synchronous_response(**parameters).squeeze()
    held = (whirls.stability == 1) & (whirls.in_contact == 1)
    return np.atleast_1d(whirls.amplitude.where(held).values)


def stable_amplitudes(rotor):
    found = stable_whirls(**{name: getattr(rotor, name) for name in PARAMETERS})
    return found[np.isfinite(found)]


def count_of_whirls(rotor):
    """Return the number of whirls in contact."""
    found = synchronous_response(**{name: getattr(rotor, name) for name in PARAMETERS})
    return int(found.in_contact.sum())


# Rotors that are drawn; and how many of them are led to the ends of their whirls in small steps.
DRAWN, LED = 12, 5


@cache
def drawn():
    """Return rotors all over the plane with a stable whirl in contact each."""
    random = np.random.default_rng(7)
    rotors = []
    while len(rotors) < DRAWN:
        rotor = Rotor(
            omega=random.uniform(0.3, 4.0), zeta=10.0 ** random.uniform(-2.0, -0.5),
            delta0=random.choice([0.0, random.uniform(0.05, 3.0)]),
        )  # fmt: skip
        if stable_amplitudes(rotor).size:
            rotors.append(rotor)
    return rotors


def extents(rotor):
    """Return both ends of each whirl along each parameter, with its amplitude."""
    return [
        (name, amplitude, extent_of_whirl(rotor, amplitude, name))
        for name in PARAMETERS
        for amplitude in stable_amplitudes(rotor).tolist()
    ]


# With little damping the curves are long and thin, and folds lie far off or close to the ring.
LITTLE_DAMPING = [
    Rotor(omega=2.8, zeta=0.0024, delta0=0.0),
    Rotor(omega=3.4, zeta=0.00275, delta0=0.05),
    Rotor(omega=3.033, zeta=0.00155, delta0=0.167),
    Rotor(omega=0.0355, zeta=9.4e-6, delta0=2.4),
    Rotor(omega=16.5, zeta=1.1e-6, delta0=2e-4),
]
# Parts of the way to an end, closer where it begins and ends.
PARTS = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 0.99, 4000))


@pytest.mark.parametrize("number", range(DRAWN + len(LITTLE_DAMPING)))
def test_a_whirl_ends_where_the_locus_of_folds_says(number):
    """`folds` finds them otherwise: by crossings of one function along the locus.

    Two whirls are lost at a fold, which are one there, and one where the whirl leaves the ring.
    """
    rotor = [*drawn(), *LITTLE_DAMPING][number]
    for name, amplitude, ends in extents(rotor):
        for way, end in zip((-1.0, 1.0), ends, strict=True):
            if end.kind == "none":
                assert end.value == (math.inf if end.value > 0.0 else 0.0)
                continue
            there = with_value(rotor, name, end.value)
            before, beyond = (
                with_value(rotor, name, end.value * (1.0 + side * 1e-7 * way))
                for side in (-1.0, 1.0)
            )
            lost = count_of_whirls(before) - count_of_whirls(beyond)
            assert lost == {"fold": 2, "touch": 1}[end.kind]
            if rotor in LITTLE_DAMPING:
                continue
            if end.kind == "fold":
                known = folds(zeta=there.zeta, delta0=there.delta0).fold_omega.values
                assert np.nanmin(np.abs(known / there.omega - 1.0)) < 1e-7
            else:
                size = there.omega / math.hypot(there.omega, 2.0 * there.zeta)
                assert size == pytest.approx(there.delta0, rel=1e-12)
            if number < LED:
                check_it_can_be_followed(rotor, name, amplitude, end.value)


def check_it_can_be_followed(rotor, name, amplitude, end):
    """In small steps, each to the nearest stable whirl: none jumps before the end."""
    begin, here = getattr(rotor, name), amplitude
    values = begin + (end - begin) * PARTS
    parameters = {each: getattr(rotor, each) for each in PARAMETERS} | {name: values}
    for row in stable_whirls(**parameters).reshape(values.size, -1):
        nearest = float(row[np.nanargmin(np.abs(row - here))])
        assert abs(nearest - here) < 0.03 * here
        here = nearest


@pytest.mark.parametrize(
    ("omega", "zeta", "delta0"), [(1.2, 1e-6, 1e3), (1.2, 1e-6, 1.5), (0.15, 3.5e-6, 642.0)]
)
def test_a_whirl_that_never_fits_into_the_clearance_ends_at_folds(omega, zeta, delta0):
    """It ends close to the ring, where |w| < 1 <= delta0 leaves no touch, or at a sharp peak."""
    rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
    (amplitude,) = stable_amplitudes(rotor).tolist()
    low, high = extent_of_whirl(rotor, amplitude, "omega")
    known = folds(zeta=zeta, delta0=delta0).fold_omega.values.ravel()
    assert high.value == pytest.approx(known[-1], rel=1e-7)
    assert low.value == (0.0 if low.kind == "none" else pytest.approx(known[0], rel=1e-7))
    for name in ("zeta", "delta0"):
        low, high = extent_of_whirl(rotor, amplitude, name)
        assert (low.kind, high.kind) == ("none", "fold")
        there = with_value(rotor, name, high.value)
        found = folds(zeta=there.zeta, delta0=there.delta0).fold_omega.values
        assert np.nanmin(np.abs(found / omega - 1.0)) < 1e-7


def test_the_jumps_of_the_paper_are_ends():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    small, large = stable_amplitudes(rotor).tolist()
    low, high = folds(zeta=0.07, delta0=0.0).fold_omega.values.ravel().tolist()
    assert extent_of_whirl(rotor, small, "omega")[0].value == pytest.approx(low, rel=1e-11)
    assert extent_of_whirl(rotor, large, "omega")[1].value == pytest.approx(high, rel=1e-11)
    assert extent_of_whirl(rotor, small, "delta0")[0].value == 0.0  # there is no less


def test_the_contact_free_whirl_ends_where_it_fills_the_clearance():
    rotor = Rotor(omega=0.05, zeta=0.07, delta0=0.5)
    for name in PARAMETERS:
        ends = [end for end in extent_of_contact_free(rotor, name) if end.kind == "touch"]
        there = with_value(rotor, name, ends[0].value)
        size = there.omega / math.hypot(there.omega, 2.0 * there.zeta)
        assert size == pytest.approx(there.delta0, rel=1e-12)
    wide = Rotor(omega=2.0, zeta=0.07, delta0=1.5)
    assert [end.value for end in extent_of_contact_free(wide, "omega")] == [0.0, math.inf]


@pytest.mark.parametrize("name", PARAMETERS)
@pytest.mark.parametrize(
    ("rotor", "start"),
    [
        (Rotor(omega=2.0, zeta=0.07, delta0=2.0), (0.0, 0.0, 0.0, 0.0)),
        (Rotor(omega=3.0, zeta=0.07, delta0=0.5), (3.0, 1.0, 0.0, 0.0)),
    ],
)
def test_a_cycle_ends_at_the_special_points_of_its_branch(rotor, start, name):
    cycle = limit_cycle(rotor, start=start)
    guess, here = guess_of(rotor, cycle), getattr(rotor, name)
    low, high = extent_of_cycle(rotor, guess.state, guess.period, name, STOP)
    limits = (0.2 * here, 4.0 * here)
    branch = continue_cycle(rotor, start=cycle, parameter=name, limits=limits, points=600)
    values = branch.special_value.values
    for kind in ("fold", "period_doubling"):
        for end in (low, high):
            if end.kind == kind and limits[0] < end.value < limits[1]:
                own = values[branch.special_kind.values == SPECIAL[kind]]
                assert np.abs(own / end.value - 1.0).min() < 1e-8
    assert high.kind in {"fold", "period_doubling"}
    assert low.value < here < high.value


def test_a_cycle_ends_where_a_torus_is_born():
    """There a pair of multipliers, of an orbit closed at the end itself, is on the unit circle."""
    rotor = Rotor(
        omega=1.6, zeta=0.05, delta0=0.75, load=1.6, shaft_stiffness=1.0, contact_exponent=1.0,
        contact_damping=0.4,
    )  # fmt: skip
    cycle = limit_cycle(rotor, start=(0.0, -1.0, 0.0, 0.0))
    guess = guess_of(rotor, cycle)
    _, high = extent_of_cycle(rotor, guess.state, guess.period, "contact_damping", STOP)
    assert high.kind == "torus"
    sizes = []
    for part in (1.0 - 1e-4, 1.0, 1.0 + 1e-4):
        there = replace(rotor, contact_damping=part * high.value)
        found = limit_cycle(there, start=guess.state, period=guess.period)
        sizes.append(np.hypot(found.multiplier_real, found.multiplier_imag).values.max())
    assert sizes[1] == pytest.approx(1.0, abs=1e-9)
    assert sizes[0] < 1.0 < sizes[2]


@pytest.mark.parametrize("beyond", [1e-6, 1e-2])
def test_a_whirl_that_barely_touches_ends_on_the_side_of_the_ring(beyond):
    zeta, delta0 = 0.5, 0.9
    touch = 2.0 * zeta * delta0 / math.sqrt(1.0 - delta0**2)
    rotor = Rotor(omega=touch * (1.0 + beyond), zeta=zeta, delta0=delta0)
    (amplitude,) = stable_amplitudes(rotor).tolist()
    low, high = extent_of_whirl(rotor, amplitude, "omega")
    assert (low.kind, high.kind) == ("touch", "none")
    assert low.value == pytest.approx(touch, rel=1e-12)
    for name in PARAMETERS:
        low, high = extent_of_whirl(rotor, amplitude, name)
        assert low.value <= getattr(rotor, name) <= high.value


def test_a_fold_far_off_is_found():
    rotor = Rotor(omega=2.0, zeta=0.005, delta0=1.0)
    (amplitude,) = stable_amplitudes(rotor).tolist()[-1:]
    end = extent_of_whirl(rotor, amplitude, "delta0")[1]
    assert end.kind == "fold"
    assert end.value > 100.0
    near = folds(zeta=rotor.zeta, delta0=end.value).fold_omega.values
    assert np.nanmin(np.abs(near / rotor.omega - 1.0)) < 1e-9


def test_contact_damping_ends_a_whirl_where_its_growth_rate_passes_zero():
    given = {"omega": 1.7, "zeta": 0.07, "delta0": 0.5}
    amplitude = 1.1960944557
    rotor = Rotor(**given, contact_damping=0.3)
    low, high = extent_of_whirl(rotor, amplitude, "contact_damping")
    assert (low, high.kind) == (End(0.0, "none"), "hopf")
    rates = eigenvalues(amplitude, **given, contact_damping=high.value)
    assert abs(rates.real.max()) < 1e-11
    assert abs(rates[np.argmax(rates.real)].imag) > 0.1


def test_over_the_stiffness_a_whirl_ends_at_a_fold():
    given = {"omega": 1.7, "zeta": 0.07, "delta0": 0.5, "contact_exponent": 1.5}
    rotor = Rotor(**given, shaft_stiffness=0.25)
    low, high = extent_of_whirl(rotor, 1.4231, "shaft_stiffness")
    assert (low, high.kind) == (End(0.0, "none"), "fold")
    sizes = synchronous_response(**given, shaft_stiffness=high.value).amplitude.values.ravel()
    beside = {**given, "shaft_stiffness": high.value}
    assert np.abs(stability_determinant(sizes, **beside)).min() < 1e-6


@pytest.mark.parametrize(
    "rotor",
    [
        Rotor(omega=3.0, zeta=0.1, delta0=1.5, shaft_stiffness=1.0),
        Rotor(omega=0.5, zeta=0.1, delta0=1.5, shaft_stiffness=1.0),
        Rotor(omega=0.5, zeta=0.1, delta0=0.6, shaft_stiffness=1.0),
        Rotor(omega=1.0, zeta=0.6, delta0=1.5, shaft_stiffness=1.0),
    ],
    ids=repr,
)
def test_the_contact_free_whirl_of_a_shaft_ends_where_it_just_reaches_the_ring(rotor):
    assert varied(rotor) == ("omega", "zeta", "delta0", "shaft_stiffness")
    touches = 0
    for name in varied(rotor):
        low, high = extent_of_contact_free(rotor, name)
        assert low.value < getattr(rotor, name) < high.value
        for end in (low, high):
            given = rotor.given | {name: end.value}
            if end.kind == "touch":
                size = abs(complex_amplitude(*(given[each] for each in
                           ("omega", "zeta", "shaft_stiffness"))))  # fmt: skip
                assert size == pytest.approx(given["delta0"], rel=1e-12)
                touches += 1
            else:
                assert end in (End(0.0, "none"), End(math.inf, "none"))
    assert touches


def test_whip_ends_at_the_corner_where_it_no_longer_rolls():
    """There it meets a cycle that does not. Led down in small steps it lasts up to there."""
    cycle = limit_cycle(WHIP, start=(5.0, 0.0, 0.0, -6.3))
    state = np.array([float(cycle[name][0]) for name in WIDE])
    low, high = extent_of_cycle(WHIP, state, float(cycle.period), "friction", np.zeros(1, np.uint8))
    assert low.kind == "fold"
    assert high.kind == "not_found"  # it lasts for as far as the branch was followed
    place = tuple(state.tolist())
    for friction in np.geomspace(0.2, 1.001 * low.value, 8).tolist():
        settled = settle_disc(replace(WHIP, friction=friction), place, Options())
        assert settled.kind == "rolling"
        place = settled.motion.state
    below = settle_disc(replace(WHIP, friction=0.999 * low.value), place, Options())
    assert below.kind == "synchronous"
