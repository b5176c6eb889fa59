"""Whirls, cycles and rest, of simulated motions of every rotor, with what is known of them."""

import math
import re

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    SimulationError,
    folds,
    limit_cycle,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms.rest import rest
from rotor_ida.model.equations import rotated
from rotor_ida.schema import RESPONSE, STABILITY
from rotor_ida.simulation.flow import DiscFlow
from rotor_ida.simulation.options import Options
from rotor_ida.steady.decision import CLEAR_STRETCH
from rotor_ida.steady.follow import (
    DECAY_TIMES,
    LONGEST,
    LONGEST_DECAY_TIMES,
    LONGEST_FIRST_WAIT,
    LONGEST_OF_ALL,
    longest_time,
    settle_disc,
)
from tests.rotors import KNOCKED, WHIP
from tests.steady.following import LOADED, REST, SHAFT, followed, of_paper
from tests.witness import flown

TAYLOR = Options(method="taylor")
# ---- Whirls ----


WHIRLING = {
    "no clearance": ({"zeta": 0.07, "delta0": 0.0}, 20),
    "shaft": ({"shaft_stiffness": 0.3}, 30),
    "shaft and linear contact": ({"shaft_stiffness": 1.0, "contact_exponent": 1.0}, 30),
    "linear contact with damping": ({"contact_exponent": 1.0, "contact_damping": 0.2}, 30),
    "shaft and contact damping": ({"shaft_stiffness": 0.5, "contact_damping": 1.0}, 30),
    "friction": (
        {"shaft_stiffness": 0.3, "contact_exponent": 1.0, "contact_damping": 2.0, "friction": 0.15},
        10,
    ),
}


@pytest.mark.parametrize("name", WHIRLING)
def test_what_whirls_steadily_is_a_stable_whirl_of_the_closed_forms(name):
    """Amplitude and phase lag, over speeds and clearances."""
    changes, fewest = WHIRLING[name]
    given = {"omega": np.linspace(0.3, 2.6, 24), "zeta": 0.1, "delta0": [0.5, 2.0]} | changes
    disc = {"disc_radius": 3.0} if "friction" in given else {}
    swept = sweep(**given, **disc, method="taylor").squeeze("start").squeeze("direction")
    steady = swept.response.isin([RESPONSE["contact_free"], RESPONSE["synchronous"]])
    exact = synchronous_response(**given)
    whirl = exact.amplitude * np.exp(-1j * exact.phase_lag)
    apart = np.abs(whirl / (swept.amplitude * np.exp(-1j * swept.phase_lag)) - 1.0)
    nearest = apart.fillna(np.inf).argmin("branch")
    assert float(apart.isel(branch=nearest).where(steady, 0.0).max()) < 1e-9
    stable = exact.stability.isel(branch=nearest) != STABILITY["unstable"]
    assert bool(stable.where(steady, True).all())
    assert bool(np.isnan(swept.period.where(steady)).all())
    free = swept.response == RESPONSE["contact_free"]
    assert bool((free == (swept.amplitude < swept.delta0)).where(steady, True).all())
    assert int(steady.sum()) > fewest


def test_the_ghost_of_a_fold_is_no_response():
    """Just above the upper fold only the small whirl exists; the rotor creeps where it was."""
    fold = folds(zeta=0.07, delta0=0.0).isel(zeta=0, delta0=0, fold=1)
    omega, amplitude = fold.fold_omega.item() + 1e-7, fold.fold_amplitude.item()
    lag = math.asin(2.0 * 0.07 * amplitude / omega)
    z = amplitude * np.exp(-1j * (math.pi - lag))
    v = 1j * omega * z
    start = (z.real, z.imag, v.real, v.imag)
    assert of_paper(omega, 0.0, start, longest=500.0).kind == "unresolved"


@pytest.mark.parametrize("load", [0.4, 1.2])
def test_clear_of_the_ring_it_whirls_about_where_the_shaft_holds_the_load(load):
    """z = -i load/kappa + A exp(i omega t), exactly."""
    rotor = Rotor(omega=1.7, zeta=0.1, delta0=4.0, shaft_stiffness=0.5, load=load)
    settled = followed(rotor, (1.0, 0.0, 0.0, 1.0))
    whirl = 1.7**2 / complex(0.5 - 1.7**2, 2.0 * 0.1 * 1.7)
    assert settled.kind == "contact_free"
    assert math.isnan(settled.features.period)
    assert settled.features.amplitude == pytest.approx(abs(whirl), rel=1e-9)
    assert settled.features.radius_max == pytest.approx(abs(whirl) + load / 0.5, rel=1e-9)
    assert settled.features.radius_min == pytest.approx(abs(abs(whirl) - load / 0.5), abs=1e-9)
    x, y, vx, vy = settled.motion.state
    assert complex(x, y) == pytest.approx(whirl - 1j * load / 0.5, abs=1e-8)
    assert complex(vx, vy) == pytest.approx(1.7j * whirl, abs=1e-8)


def test_where_that_whirl_would_reach_the_ring_it_does_not_stay_free():
    """Its largest radius, 1.21 + 0.8, decides, not that of the whirl alone."""
    whirl = 1.7**2 / abs(complex(0.5 - 1.7**2, 2.0 * 0.1 * 1.7))
    machine = {"omega": 1.7, "zeta": 0.1, "shaft_stiffness": 0.5, "load": 0.4}
    for clearance, kinds in ((0.999, {"bouncing", "full_contact"}), (1.001, {"contact_free"})):
        rotor = Rotor(delta0=clearance * (whirl + 0.8), **machine)
        assert followed(rotor).kind in kinds


def swing_by_a_small_load(omega, zeta, delta0):
    """How far a unit of a rotating load swings the radius of a synchronous whirl, if small."""
    whirls = synchronous_response(omega=omega, zeta=zeta, delta0=delta0)
    amplitude = whirls.amplitude.values.ravel()[0]
    secant = (amplitude - delta0) ** 1.5 / amplitude
    slope, q = 1.5 * math.sqrt(amplitude - delta0), omega**2
    stiffness = np.array([[slope - q, -2.0 * zeta * omega], [2.0 * zeta * omega, secant - q]])
    damping = np.array([[2.0 * zeta, -2.0 * omega], [2.0 * omega, 2.0 * zeta]])
    resistance = stiffness + 1j * omega * damping - q * np.eye(2)
    return amplitude, abs(np.linalg.solve(resistance, [1.0, 1j])[0])


def test_a_slight_load_swings_a_synchronous_whirl_as_linear_theory_says():
    """So a sweep comes to that without load, to first order, as the load goes to 0."""
    amplitude, swing = swing_by_a_small_load(1.2, 0.07, 0.5)
    missed = []
    for load in (1e-2, 1e-3, 1e-4):
        settled = followed(Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=load))
        assert settled.kind == "full_contact"
        assert settled.features.period == pytest.approx(2.0 * math.pi / 1.2, rel=1e-14)
        low, high = settled.features.radius_min, settled.features.radius_max
        assert (high - low) / (2.0 * load) == pytest.approx(swing, rel=5.0 * load)
        missed.append(abs(settled.features.amplitude - amplitude))
    # the part at the spin speed changes by the square of the load
    assert np.polyfit([-2.0, -3.0, -4.0], np.log10(missed), 1)[0] == pytest.approx(2.0, abs=0.05)


# ---- Cycles ----


KNOWN = {
    (2.0, 2.0): ("bouncing", 4.563916675380, 4.104416607),
    (3.0, 0.5): ("full_contact", 3.115214254929, 3.000222126),
}


@pytest.mark.parametrize("flight", ["exact", "cvode"])
@pytest.mark.parametrize(("omega", "delta0"), KNOWN)
def test_periods_and_radii_of_known_cycles(omega, delta0, flight):
    """To nine digits and more; two programs that share nothing agree on them."""
    kind, period, radius_max = KNOWN[omega, delta0]
    settled = of_paper(omega, delta0, options=Options(flight=flight))
    assert settled.kind == kind
    assert settled.features.period == pytest.approx(period, rel=1e-10)
    # the reference has ten digits
    assert settled.features.radius_max == pytest.approx(radius_max, rel=2e-10)


def test_the_error_of_a_period_falls_with_the_tolerance():
    tolerances = [1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10]
    several = [Options(rtol=rtol, atol=rtol) for rtol in tolerances]
    periods = [of_paper(2.0, 2.0, options=each).features.period for each in several]
    errors = np.abs(np.array(periods) - 4.563916675380)
    # single errors scatter, so the order is that of a line through six
    assert 0.5 < np.polyfit(np.log(tolerances), np.log(errors), 1)[0] < 1.5


@pytest.mark.parametrize(
    ("rotor", "start", "options", "digits"),
    [
        (Rotor(omega=2.0, zeta=0.07, delta0=2.0), REST, Options(method="bdf"), 9),
        (Rotor(omega=2.0, zeta=0.05, load=0.6, **SHAFT), REST, Options(), 8),
        (
            Rotor(omega=1.5, zeta=0.1, load=0.3, contact_damping=0.3, **SHAFT), REST, Options(), 8,
        ),
        (
            Rotor(omega=2.0, zeta=1.0, load=0.6, **SHAFT), REST,
            Options(backend="python", rtol=1e-9), 7,
        ),
    ],
    ids=["bdf", "under a load", "contact damping", "the reference in plain Python"],
)  # fmt: skip
def test_methods_and_backends_agree_on_a_cycle(rotor, start, options, digits):
    taylor, other = followed(rotor, start), settle_disc(rotor, start, options)
    assert other.kind == taylor.kind == "bouncing"
    for name in ("period", "amplitude", "radius_min", "radius_max"):
        one, found = getattr(taylor.features, name), getattr(other.features, name)
        assert found == pytest.approx(one, rel=10.0**-digits)
    if rotor.load:  # whole revolutions
        assert other.features.period == taylor.features.period


def test_a_doubled_cycle_has_twice_the_period():
    """At omega 1.6 the transient alternates for long; the cycle that is left does not."""
    settled = of_paper(1.6, 1.0)
    assert settled.kind == "bouncing"
    assert settled.features.period == pytest.approx(7.6498386845, rel=1e-9)
    assert settled.motion.time > 1500.0


@pytest.mark.parametrize("name", LOADED)
def test_a_cycle_comes_again_after_whole_revolutions_by_another_integrator(name):
    """And not after fewer; radii and the part at the spin speed are those of that integrator."""
    rotor, count = LOADED[name]
    settled = followed(rotor)
    revolution = 2.0 * math.pi / rotor.omega
    assert settled.features.period == pytest.approx(count * revolution, rel=1e-14)
    times = np.linspace(0.0, count * revolution, 1024 * count + 1)
    x, y, vx, vy = flown(rotor, settled.motion.state, times[-1], at=times).states[:, :4].T
    z, v = x + 1j * y, vx + 1j * vy
    at_start = np.array([z[:1], v[:1]])
    apart = np.abs(np.array([z[::1024], v[::1024]]) - at_start).max(axis=0)
    assert apart[-1] < 1e-8
    assert (apart[1:-1] > 1e-2).all()
    radius, features = np.abs(z), settled.features
    assert settled.kind == ("bouncing" if radius.min() < rotor.delta0 else "full_contact")
    # between samples the radius turns
    assert features.radius_max == pytest.approx(radius.max(), rel=1e-4)
    assert features.radius_min == pytest.approx(radius.min(), abs=2e-3)
    spin = complex((z[:-1] * np.exp(-1j * rotor.omega * times[:-1])).mean())
    assert features.amplitude == pytest.approx(abs(spin), rel=1e-6)
    assert features.phase_lag == pytest.approx(-np.angle(spin), rel=1e-6)


# Cycles: one that rolls and slips, one that only rolls, one that slides backwards too, and one that
# only slides forwards.
RUBBING = {
    "rolling and slipping": (WHIP, KNOCKED, "rolling", {2, -2}),
    "rolling alone": (
        Rotor(omega=0.5, zeta=0.1, delta0=1.0, friction=2.0, disc_radius=4.0),
        (0.3, 0.1, 0.2, 0.1), "rolling", set(),
    ),
    "small disc": (
        Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6),
        (0.3, 0.1, 0.2, 0.1), "bouncing", {1, -1, 2, -2, 3},
    ),
    "sliding": (
        Rotor(omega=2.0, zeta=0.07, delta0=2.0, friction=0.1, disc_radius=10.0),
        (0.3, 0.1, 0.2, 0.1), "bouncing", {1, -1},
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=RUBBING)
def cycle(request):
    rotor, start, kind, events = RUBBING[request.param]
    settled = settle_disc(rotor, start, TAYLOR)
    assert settled.kind == kind
    assert set(settled.motion.window.event_kinds.tolist()) == events
    return rotor, settled


def witness(rotor, state, duration):
    """Where another integrator ends, on the rotating axes."""
    return rotated(flown(rotor, state, duration).end[:4], -rotor.omega * duration)


def test_another_integrator_comes_back_after_the_period(cycle):
    rotor, settled = cycle
    end = witness(rotor, settled.motion.state, settled.features.period)
    np.testing.assert_allclose(end, settled.motion.state, rtol=0, atol=2e-8)


# ---- Rest, and what does not settle ----


def test_a_rotor_that_does_not_turn_comes_to_rest_within_its_clearance():
    assert of_paper(0.0, 1.0, (1.5, 0, 0, 0.3), zeta=0.3).kind == "contact_free"
    creeping = of_paper(0.0, 1.0, (1.0 + 1e-8, 0, 0, 0), zeta=1.0, longest=1000.0)
    assert creeping.kind == "unresolved"


AT_REST = {
    "hangs": Rotor(omega=0.0, zeta=0.1, delta0=1.0, shaft_stiffness=0.5, load=0.2),
    "hangs on the ring": Rotor(omega=0.0, zeta=0.1, delta0=1.0, shaft_stiffness=0.5, load=0.9),
    "lies": Rotor(omega=0.0, zeta=0.2, delta0=1.0, load=0.3),
    "lies, linear": Rotor(
        omega=0.0, zeta=0.2, delta0=1.0, load=0.3, contact_exponent=1.0, contact_damping=0.5
    ),
    "no clearance": Rotor(omega=0.0, zeta=0.2, delta0=0.0, load=0.3),
}


@pytest.mark.parametrize("name", AT_REST)
@pytest.mark.parametrize("method", ["taylor", "adams"])
def test_what_does_not_turn_comes_to_rest_where_the_closed_form_says(name, method):
    rotor = AT_REST[name]
    settled, place = followed(rotor, (0.4, 0.1, 0.3, 0.0), method), rest(rotor)
    assert settled.kind == ("synchronous" if place.indentation > 0.0 else "contact_free")
    depth = -place.y.item()
    assert settled.features.amplitude == 0.0  # a place, and no whirl
    assert settled.features.radius_min == pytest.approx(depth, rel=1e-9)
    assert settled.features.radius_max == pytest.approx(depth, rel=1e-9)
    assert settled.motion.state == pytest.approx((0.0, -depth, 0.0, 0.0), abs=1e-9)


def test_friction_holds_a_rotor_at_rest_off_the_bottom():
    """A block on an inclined ring: it stays where the slope is no steeper than the friction."""
    rotor = Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=0.3, disc_radius=5.0)
    settled = settle_disc(rotor, (-1.2, -0.4, 0.3, -0.8), TAYLOR)
    assert settled.kind == "synchronous"
    z = complex(*settled.motion.state[:2])
    slope = math.atan2(abs(z.real), -z.imag)
    assert 1e-3 < slope < math.atan(0.3)
    assert (abs(z) - 1.0) ** 1.5 == pytest.approx(0.5 * math.cos(slope), abs=1e-8)


def test_light_damping_settles_on_the_exact_whirl():
    """It takes some 30/zeta, 60,000 at the least of these, on a linear ring with a weak shaft."""
    given = {"delta0": 1.6, "shaft_stiffness": 0.01, "contact_exponent": 1.0}
    given |= {"omega": np.linspace(0.15, 0.3, 3), "zeta": [0.001, 0.0005]}
    swept = sweep(**given, method="taylor").squeeze()
    assert (swept.response == RESPONSE["synchronous"]).all()
    assert (swept.message == "").all()
    exact = synchronous_response(**given).amplitude.squeeze()
    assert float(np.abs(exact - swept.amplitude).min("branch").max()) < 1e-9
    assert 60_000.0 < float(swept.window_end.max()) < 120_000.0


@pytest.mark.parametrize(
    ("rotor", "expected"),
    [
        (Rotor(omega=1.0, zeta=0.0, delta0=1.0), 40_000.0),
        (Rotor(omega=1.0, zeta=0.07, delta0=1.0), 40_000.0),
        (Rotor(omega=1.0, zeta=1e-4, delta0=1.0), 600_000.0),
        (Rotor(omega=1.0, zeta=1e-9, delta0=1.0), 40_000.0),
        # a weak shaft: the slower rate is about kappa/(2 zeta)
        (Rotor(omega=1.0, zeta=10.0, delta0=1.0, shaft_stiffness=0.02), 60.0 * 1000.0),
    ],
)
def test_the_time_limit_follows_the_damping(rotor, expected):
    assert longest_time(rotor) == pytest.approx(expected, rel=1e-3)


UNRESOLVED = {
    "without damping nothing settles": (
        Rotor(omega=1.0, zeta=0.0, delta0=0.5), {}, r"followed for 3\d\d revolutions: "),
    "at speed 0": (
        Rotor(omega=0.0, zeta=0.01, delta0=0.2, load=1.0), {"longest": 1.0},
        r"followed for a time of 20\d\d, 20\.\d decay times: in contact, it still moves by \S+ "
        "of its "
        "size about its mean whirl, where 1e-09 is allowed"),
    "a whirl that decays": (
        Rotor(omega=0.2, zeta=5e-4, delta0=1.6, shaft_stiffness=0.01, contact_exponent=1.0),
        {"longest": 10_000.0}, r"followed for \d\d\d revolutions, \S+ decay times: in contact, "
        "it still "
        r"moves by 0\.00\d+ of its size about its mean whirl, where 1e-09 is allowed"),
    "under a load": (
        Rotor(omega=2.0, zeta=5e-4, delta0=0.1, shaft_stiffness=0.01, contact_exponent=1.0,
              load=0.5), {"longest": 10_000.0},
        "in contact, it still moves by .* of its size from revolution to revolution"),
    "a cycle": (
        Rotor(omega=2.4, zeta=0.0095, delta0=1.0, shaft_stiffness=0.25, load=0.6),
        {"longest": 200.0},
        "it approaches a motion that repeats itself, and has nearly settled: the motions still "),
    "touches": (
        Rotor(omega=2.0, zeta=5e-4, delta0=2.0), {"longest": 1000.0},
        r"it does not repeat itself, with \d+ entries and exits in the window"),
    "contact-free": (
        Rotor(omega=2.0, zeta=1e-3, delta0=1e4), {"longest": 1000.0},
        "out of contact, but it may still reach the stator"),
}  # fmt: skip


# A horizontal pump that rubs: [rpm], the kind of its motion from rest, and the revolutions of its
# period.
PUMP = [(5600.0, "quasi_periodic", 0), (5700.0, "bouncing", 24), (6000.0, "bouncing", 4)]


@pytest.mark.parametrize(("speed", "kind", "count"), PUMP)
def test_a_slow_approach_and_a_long_period_under_a_load_are_decided(speed, kind, count):
    pump = Rotor(
        omega=speed * math.pi / 30.0 / math.sqrt(1e8 / 12.0), zeta=0.006,
        delta0=8.97597901025655, shaft_stiffness=0.04, contact_exponent=1.0,
        load=0.07041942764874592, friction=0.12, disc_radius=3590.39160410262,
    )  # fmt: skip
    settled = followed(pump)
    assert settled.kind == kind
    # the states once a revolution, long after the transient, as witnesses
    flow = DiscFlow(pump)
    late = flow.observed(np.zeros(4), np.arange(6001) * flow.revolution).states[-1000:]
    differ = [np.abs(late[gap:] - late[:-gap]).max() for gap in range(1, 101)]
    if not count:
        assert min(differ) > 0.01
        return
    assert settled.features.period == pytest.approx(count * flow.revolution, rel=1e-12)
    assert int(np.argmin(differ)) + 1 in range(count, 101, count)
    assert differ[count - 1] < 1e-8
    assert min(differ[: count - 1]) > 0.1


@pytest.mark.parametrize("name", UNRESOLVED)
def test_an_unresolved_motion_tells_what_was_tried(name):
    rotor, limits, expected = UNRESOLVED[name]
    settled = followed(rotor, (0.3, 0.0, 0.0, 0.2), **limits)
    assert settled.kind == "unresolved"
    assert re.search(expected, settled.decision.message), settled.decision.message


def test_a_run_that_is_asked_to_stop_has_failed():
    with pytest.raises(SimulationError, match="interrupted"):
        of_paper(2.0, 2.0, stop=np.ones(1, np.uint8))


def test_the_docstring_of_sweep_states_the_waits_of_this_code():
    first = f"first after {DECAY_TIMES:g}/zeta ({LONGEST_FIRST_WAIT:,.0f} at most)"
    bounds = f"at least {LONGEST:,.0f}, at most {LONGEST_OF_ALL:,.0f}"
    last = f"until {LONGEST_DECAY_TIMES:g}/zeta ({bounds}"
    words = " ".join((sweep.__doc__ or "").split())
    assert first in words
    assert last in words
    assert f"``exp({CLEAR_STRETCH:g})``" in words


# ---- Where the free whirl just reaches the stator ----

GRAZING = {"omega": 0.2, "zeta": 0.05, "shaft_stiffness": 0.04}  # in resonance: A_f = 0.2/0.1
FROM = [REST, (0.3, -1.2, 0.5, 0.1), (1.9, 0.2, -1.5, 1.0)]


@pytest.mark.parametrize("beyond", [-1e-12, 1e-12])
@pytest.mark.parametrize(
    "changes",
    [
        {}, {"contact_damping": 0.3}, {"friction": 0.1, "disc_radius": 10.0},
        {"contact_exponent": 1.0}, {"load": 0.02},
    ],
    ids=["plain", "damping", "friction", "linear", "load"],
)  # fmt: skip
def test_a_whirl_that_just_reaches_the_stator_is_touching_at_once(changes, beyond):
    """Contacts without depth once took minutes, and rounding decided on the kind."""
    sag = changes.get("load", 0.0) / GRAZING["shaft_stiffness"]
    rotor = Rotor(**GRAZING, **changes, delta0=(2.0 + sag) / (1.0 + beyond))
    for start in FROM:
        settled = followed(rotor, start, method="adams")
        assert settled.kind == "touching"
        assert settled.motion.time < 20_000.0  # a linear contact slows it down
        assert settled.features.amplitude == pytest.approx(2.0, rel=1e-8)
        assert settled.features.phase_lag == pytest.approx(0.5 * math.pi, rel=1e-8)
        assert settled.features.radius_max == pytest.approx(2.0 + sag, rel=1e-8)
        assert settled.features.radius_min == pytest.approx(2.0 - sag, rel=1e-8)


@pytest.mark.parametrize(
    ("beyond", "kind"), [(-1e-7, "contact_free"), (-1e-5, "contact_free"), (1e-5, "synchronous")]
)
def test_next_to_a_graze_the_closed_form_decides(beyond, kind):
    rotor = Rotor(**GRAZING, delta0=2.0 / (1.0 + beyond))
    assert {followed(rotor, start).kind for start in FROM} == {kind}


@pytest.mark.parametrize("beyond", [-1e-8, 0.0])
def test_without_a_shaft_a_whirl_that_just_reaches_the_stator_draws_its_centre_in(beyond):
    """A_f = 0.3/0.5; its centre falls like 1/t**2 there, so that no law of 1/h is met."""
    rotor = Rotor(omega=0.3, zeta=0.2, delta0=0.6 / (1.0 + beyond), friction=0.1, disc_radius=10.0)
    settled = followed(rotor, (0.5, 0.1, 0.3, -0.2))
    assert settled.kind == "touching"
    assert settled.features.amplitude == pytest.approx(0.6, rel=1e-3)


# ---- Off an unstable whirl or cycle ----


def test_an_unstable_whirl_is_left_for_the_cycle_that_is_born_of_it():
    """Beyond the Hopf point of friction it grows by 0.0014: no rounding leaves it in time."""
    given = {"omega": 1.16, "zeta": 0.07, "delta0": 0.5, "friction": 0.1}
    whirl = synchronous_response(**given).squeeze(drop=True)
    assert int(whirl.stability) == STABILITY["unstable"]
    place = complex(whirl.amplitude * np.exp(-1j * whirl.phase_lag))
    velocity = 1.16j * place
    rotor = Rotor(**given, disc_radius=10.0)
    here = followed(rotor, (place.real, place.imag, velocity.real, velocity.imag))
    there = followed(rotor)
    assert here.kind == there.kind == "full_contact"
    for name in ("period", "radius_min", "radius_max"):
        assert getattr(here.features, name) == pytest.approx(getattr(there.features, name))


def test_an_unstable_cycle_is_left_for_that_of_twice_its_period():
    """Past the doubling at delta0 1.8034 (omega 2): see `tests/cycles/known.py`."""
    rotor = Rotor(omega=1.8, zeta=0.07, delta0=2.0)
    near = (-2.425314661360, -3.005852500038, 1.187724699715, -0.972809299419)
    cycle = limit_cycle(rotor, start=near, period=5.05425)
    assert cycle["stability"].item() == STABILITY["unstable"]
    on_it = tuple(float(cycle[name].values.flat[0]) for name in ("x", "y", "vx", "vy"))
    settled = followed(rotor, on_it)
    assert settled.kind == "bouncing"
    assert settled.features.period == pytest.approx(2.0 * float(cycle["period"]), rel=0.01)
    assert settled.motion.time < 10_000.0  # by rounding alone it takes 17,000
