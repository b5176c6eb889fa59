"""Basins of machines: a shaft, a linear contact, contact damping."""

import cmath
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rotor_ida import InputError, Rotor, basin, basin_fractions, simulate, sweep
from rotor_ida.basins.kernel import (
    CONTACT_FREE,
    LANES,
    NO_CONTACT_FREE,
    NOT_COMPUTED,
    REGION,
    SECTION,
    UNDECIDED,
    Labels,
    follow,
)
from rotor_ida.basins.known import contact_free_whirls
from rotor_ida.basins.trapping_regions import trapping_regions
from rotor_ida.closed_forms import eigenvalues
from rotor_ida.model.equations import rotating_field
from rotor_ida.schema import RESPONSE
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from rotor_ida.steady.follow import follow_to_steady_state

GO_ON = np.zeros(1, np.uint8)
NO_REGIONS, NO_SECTIONS = np.empty(0, REGION), np.empty(0, SECTION)
MACHINES = [
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, shaft_stiffness=0.25),
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, contact_exponent=1.0),
    Rotor(omega=1.7, zeta=0.07, delta0=0.5, contact_damping=0.3),
    Rotor(
        omega=1.2, zeta=0.1, delta0=0.8, shaft_stiffness=0.4, contact_exponent=1.0,
        contact_damping=0.7,
    ),
    Rotor(omega=1.7, zeta=0.07, delta0=0.0, contact_exponent=1.0, shaft_stiffness=0.25),
    Rotor(omega=1.7, zeta=0.07, delta0=0.0, shaft_stiffness=0.25),
]  # fmt: skip


def ends_of(rotor: Rotor, states: np.ndarray, duration: float, tolerance: float) -> np.ndarray:
    """Return where the lanes take states in a time; nothing holds them."""
    ends, labels, times = states.copy(), *_unlabelled(states.shape[1])
    nothing = NO_REGIONS, NO_CONTACT_FREE, NO_SECTIONS
    follow(ends, labels, times, rotor, *nothing, duration, tolerance, GO_ON)
    assert (labels == UNDECIDED).all()
    return ends


def _unlabelled(count: int) -> tuple[Labels, np.ndarray]:
    return np.full(count, NOT_COMPUTED, np.int16), np.zeros(count, np.float32)


@pytest.mark.parametrize("rotor", MACHINES, ids=repr)
def test_a_step_of_the_lanes_is_one_of_the_models_own_field(rotor):
    """To rounding, but over the ring and where the contact lets go."""
    states = np.random.default_rng(0).normal(0.0, 3.0, (4, LANES))
    states[:2] *= np.geomspace(0.3, 1.5, LANES)
    step, compared = 0.02, 0
    ends = ends_of(rotor, states, step, 1e3)
    for number in range(LANES):
        start = states[:, number]
        exact = solve_ivp(
            lambda _, state: rotating_field(state, rotor), (0.0, step), start,
            method="DOP853", rtol=1e-13, atol=1e-13,
        ).y[:, -1]  # fmt: skip
        kinks = [_kinks(state, rotor) for state in (start, exact)]
        if kinks[0] == kinks[1]:
            size = 1.0 + np.abs(start).max() ** 1.5
            np.testing.assert_allclose(ends[:, number], exact, rtol=0.0, atol=1e-12 * size)
            compared += 1
    assert compared > LANES // 2


def _kinks(state: np.ndarray, rotor: Rotor) -> tuple[bool, bool]:
    """Return whether a state lies beyond the ring, and whether the contact holds there."""
    x, y, u, v = state
    radius = math.hypot(x, y)
    return radius > rotor.delta0, rotor.contact_damping * (x * u + y * v) > -radius


@pytest.mark.parametrize("rotor", MACHINES[:4], ids=repr)
@pytest.mark.parametrize("tolerance", [1e-10, 1e-12])
def test_steps_over_the_ring_and_the_release_are_as_exact_as_others(rotor, tolerance):
    """From just outside they fly in, fast enough to be let go on the way where there is c."""
    random, states = np.random.default_rng(2), np.empty((4, LANES))
    directions = np.exp(1j * random.uniform(0.0, 2.0 * math.pi, LANES))
    positions = random.uniform(1.0, 1.5, LANES) * directions
    speeds = -random.uniform(1.0, 6.0, LANES) * directions
    states[:] = positions.real, positions.imag, speeds.real, speeds.imag
    duration, left, released = 1.0, 0, 0
    ends = ends_of(rotor, states, duration, tolerance)
    for number in range(LANES):
        x, y, u, v = states[:, number].tolist()
        done = run(rotor, (x, y, u, v), duration, np.empty(0), Options(method="taylor", rtol=1e-13))
        left += bool((done.event_kinds == -1).any())
        released += bool((done.event_kinds == -4).any())
        turn = cmath.exp(-1j * rotor.omega * duration)
        exact = np.array([complex(*done.end[:2]) * turn, complex(*done.end[2:]) * turn])
        found = np.array([complex(*ends[:2, number]), complex(*ends[2:, number])])
        assert np.abs(found - exact).max() < 300.0 * tolerance
    assert left > LANES // 2
    assert (released > 0) == (rotor.contact_damping > 0.0)


@pytest.mark.parametrize("rotor", MACHINES, ids=repr)
def test_v_falls_on_the_trapping_regions_of_machines(rotor):
    """Along the field of the model itself, at random states on them and inside."""
    random, regions = np.random.default_rng(0), trapping_regions(rotor)
    assert regions
    for each in regions:
        assert each.exists
        factor = np.linalg.cholesky(each.form).T
        for scale in (1.0, 0.7, 0.1):
            directions = random.normal(size=(400, 4))
            directions /= np.linalg.norm(directions, axis=1)[:, None]
            for offset in scale * np.linalg.solve(factor, directions.T).T:
                rate = rotating_field(each.centre + offset, rotor)
                assert offset @ each.form @ rate < 0.0


def test_a_whirl_that_contact_damping_drives_has_no_trapping_region():
    """The small whirl at omega 1.7 is stable at c = 0.5, and past a Hopf point at c = 1."""
    for drag, growth in ((0.5, -1.0), (1.0, 1.0)):
        given = {"omega": 1.7, "zeta": 0.07, "delta0": 0.5, "contact_damping": drag}
        amplitudes = [each.amplitude for each in trapping_regions(Rotor(**given))]
        assert np.sign(eigenvalues(1.1960944557, **given).real.max()) == growth
        assert any(abs(each - 1.1960944557) < 1e-9 for each in amplitudes) == (growth < 0.0)


@pytest.mark.parametrize(
    ("omega", "zeta", "kappa"),
    [(3.0, 0.1, 1.0), (0.5, 0.1, 0.005), (0.8, 0.6, 0.04), (0.8, 0.2, 0.04), (0.0, 0.1, 1.0)],
)
def test_what_a_shaft_holds_inside_never_touches_again(omega, zeta, kappa):
    """Beside little and much damping, at the critical one, and at rest; by CVODE."""
    rotor = Rotor(omega=omega, zeta=zeta, delta0=1.5, shaft_stiffness=kappa)
    free = contact_free_whirls(rotor, GO_ON, fading=True)
    random = np.random.default_rng(3)
    off, moving = (random.normal(size=400) + 1j * random.normal(size=400) for _ in range(2))
    position = free.whirl + 0.5 * free.room * off
    velocity = 1j * omega * free.whirl + 0.5 * free.room * max(zeta, math.sqrt(kappa)) * moving
    states = np.stack([position.real, position.imag, velocity.real, velocity.imag])
    ends, labels, times = states.copy(), *_unlabelled(400)
    follow(ends, labels, times, rotor, NO_REGIONS, free.row, NO_SECTIONS, 1e-9, 1e-6, GO_ON)
    held = np.flatnonzero(labels == 0)
    assert held.size > 20
    for number in held[:40].tolist():
        found = simulate(rotor, start=states[:, number], duration=30.0 / zeta, samples=2)
        assert found.sizes["event"] == 0


def test_the_rule_for_a_soft_shaft_goes_over_into_that_of_none():
    """In the time that is looked at, a shaft of 1e-9 draws nothing back."""
    random, states = np.random.default_rng(4), np.empty((4, 2000))
    states[:2] = random.uniform(-2.0, 2.0, (2, 2000))
    states[2:] = random.normal(0.0, 0.5, (2, 2000))
    labels_of = []
    for beyond in ({}, {"shaft_stiffness": 1e-9}):
        rotor = Rotor(omega=0.5, zeta=0.2, delta0=2.0, **beyond)
        free = contact_free_whirls(rotor, GO_ON, fading=False)
        ends, (labels, times) = states.copy(), _unlabelled(2000)
        whirl = np.array(((free.whirl.real, free.whirl.imag), free.room**2, -1.0), CONTACT_FREE)
        follow(ends, labels, times, rotor, NO_REGIONS, whirl, NO_SECTIONS, 1e-9, 1e-6, GO_ON)
        labels_of.append(labels)
    assert (labels_of[0] == 0).sum() > 100
    # where the whirl itself moves by 1e-8 a state on the border may change sides
    assert (labels_of[0] != labels_of[1]).sum() <= 1


def test_touches_with_a_linear_contact_fade_from_the_rim():
    """By CVODE, from other states than those by which the excess was found."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_exponent=1.0)
    found = contact_free_whirls(rotor, GO_ON, fading=True)
    assert found.excess > 0.0
    for angle in (0.3, 2.0, 4.4):
        position = cmath.rect(found.room + found.excess, angle) + found.whirl
        velocity = 1j * rotor.omega * found.whirl
        start = (position.real, position.imag, velocity.real, velocity.imag)
        settled = follow_to_steady_state(rotor, start, Options(rtol=1e-10))
        assert settled.response == "touching"


@pytest.mark.parametrize(
    "beyond",
    [
        {"shaft_stiffness": 0.25},
        {"contact_exponent": 1.0},
        {"contact_damping": 0.1},
        {"shaft_stiffness": 1.0, "contact_exponent": 1.0, "contact_damping": 0.2},
    ],
    ids=str,
)
def test_labels_are_what_a_sweep_finds_from_the_same_starts(beyond):
    """Starts of a plane, each followed by CVODE as well."""
    axis = np.linspace(-4.0, 4.0, 5)
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, **beyond)
    found = basin(rotor, x=axis, y=axis)
    assert int(found.undecided_count) == 0
    assert found.coords["zeta"] == 0.07
    for name, value in beyond.items():
        assert found.coords[name] == found.attrs[name] == value
    starts = [(x, y, 0.0, 0.0) for x in axis for y in axis]
    alone = sweep(omega=2.0, zeta=0.07, delta0=2.0, **beyond, starts=starts[::3])
    labels = found.label.values.ravel()[::3]
    kinds = found.kind.values[labels]
    # touches that are still fading may already be inside by another solver's rounding
    family = {RESPONSE["touching"]: RESPONSE["contact_free"]}
    told = [family.get(kind, kind) for kind in np.ravel(alone.response).tolist()]
    assert [family.get(kind, kind) for kind in kinds.tolist()] == told
    steady = ~np.isin(kinds, [RESPONSE["contact_free"], RESPONSE["touching"]])
    for name in ("radius_min", "radius_max"):
        apart = found[name].values[labels] - np.ravel(alone[name])
        assert np.abs(apart[steady]).max(initial=0.0) < 1e-6


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


def test_a_contact_that_is_damped_too_much_is_refused():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=2.0, contact_damping=60.0)
    message = r"^contact_damping must be at most 50 for a basin, got 60.0$"
    with pytest.raises(InputError, match=message):
        basin(rotor, x=[0.0, 1.0], y=[0.0, 1.0])


def test_a_basin_under_a_load_is_refused():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=2.0, load=0.25)
    with pytest.raises(InputError, match=r"^load must be 0 for a basin, as under a load nothing"):
        basin(rotor, x=[0.0, 1.0], y=[0.0, 1.0])
