"""Responses with friction: rubs that slide, dry whip that rolls, and a rest that friction holds."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    compare,
    lyapunov_exponent,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms.contact_free import touch_fading
from rotor_ida.model.equations import rotated
from rotor_ida.schema import EXACT, RESPONSE
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import follow_to_steady_state
from rotor_ida.steady.periods import slowest_multiplier
from rotor_ida.steady.response import Window, rolls_backwards
from tests.witness import rubbed

TAYLOR = Options(method="taylor")
WHIP = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
KNOCK = (5.0, 0.0, 0.0, -6.3)
REST = (0.0, 0.0, 0.0, 0.0)
# Cycles: one that rolls and slips, one that only rolls, one that slides backwards too, and one that
# only slides forwards.
CYCLES = {
    "rolling and slipping": (WHIP, KNOCK, "rolling", {2, -2}),
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


@pytest.fixture(scope="module", params=CYCLES)
def cycle(request):
    rotor, start, kind, events = CYCLES[request.param]
    settled = follow_to_steady_state(rotor, start, TAYLOR)
    assert settled.response == kind
    late = settled.event_kinds[settled.event_times > settled.window_start]
    assert set(late.tolist()) == events
    return rotor, settled


def witness(rotor, state, duration):
    """Where another integrator ends, on the rotating axes."""
    _, end = rubbed(rotor, state, duration)
    return rotated(np.asarray(end), -rotor.omega * duration)


def test_another_integrator_comes_back_after_the_period(cycle):
    rotor, settled = cycle
    end = witness(rotor, settled.end, settled.features.period)
    np.testing.assert_allclose(end, settled.end, rtol=0, atol=2e-8)


def test_the_multiplier_is_that_of_neighbours_of_another_integrator(cycle):
    """Where the disc rolls no tangents are there: it is by neighbours too."""
    rotor, settled = cycle
    aside, rows = 1e-5, []
    for direction in aside * np.eye(4):
        ends = [
            witness(rotor, tuple(settled.end + way * direction), settled.features.period)
            for way in (1.0, -1.0)
        ]
        rows.append((ends[0] - ends[1]) / (2.0 * aside))
    multipliers = np.linalg.eigvals(np.array(rows))
    trivial = np.argmin(np.abs(multipliers - 1.0))
    assert abs(multipliers[trivial] - 1.0) < 1e-4
    slowest = np.abs(np.delete(multipliers, trivial)).max()
    stop = np.zeros(1, np.uint8)
    found = slowest_multiplier(rotor, settled.end, settled.features.period, stop)
    assert abs(found) == pytest.approx(slowest, abs=1e-4)


def test_a_rub_that_pulsates_has_the_multiplier_that_was_derived():
    """DESIGN section 6: 1, 0.978 and a complex pair of modulus 0.722."""
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)
    settled = follow_to_steady_state(rotor, (0.3, 0.1, 0.2, 0.1), TAYLOR)
    assert settled.response == "full_contact"
    stop = np.zeros(1, np.uint8)
    found = slowest_multiplier(rotor, settled.end, settled.features.period, stop)
    assert found == pytest.approx(0.978, abs=5e-4)


def test_dry_whip_starts_from_a_knock_and_rubs_are_those_of_the_closed_form():
    """Whip is born at omega 0.3148 without unbalance (DESIGN section 3); from rest it is not
    reached."""
    found = sweep(
        omega=[0.3, 0.5, 0.6], zeta=0.1, delta0=1.0, friction=[0.0, 0.2], disc_radius=10.0,
        starts=[REST, KNOCK], method="taylor",
    )  # fmt: skip
    rolling = found.response == RESPONSE["rolling"]
    assert not rolling.sel(friction=0.0).any()
    assert not rolling.sel(start=0).any()
    whips = found.sel(friction=0.2).isel(start=1).squeeze()
    kinds = ("contact_free", "rolling", "rolling")
    assert whips.response.values.tolist() == [RESPONSE[kind] for kind in kinds]
    assert found.disc_radius.item() == 10.0
    compared = compare(found)
    # with unbalance whip is a cycle on the turning axes
    repeats = rolling & found.period.notnull()
    assert repeats.any()
    assert (compared.lies_on.where(repeats, EXACT["cycle"]) == EXACT["cycle"]).all()
    assert float(compared.digits.where(repeats).min()) > 6.0
    rubs = compared.response == RESPONSE["synchronous"]
    assert rubs.sel(friction=0.2).any()
    assert (compared.lies_on.where(rubs, EXACT["whirl"]) == EXACT["whirl"]).all()
    assert float(compared.digits.where(rubs).min()) > 9.0


def test_friction_pulls_back_the_whirl_that_rubs():
    """Amplitude and lag of the closed form, with a shaft, linear contact and contact damping."""
    machine = {
        "shaft_stiffness": 0.3, "contact_exponent": 1.0, "contact_damping": 2.0, "friction": 0.15,
    }  # fmt: skip
    found = sweep(omega=0.6, zeta=0.2, delta0=0.4, disc_radius=3.0, **machine).squeeze()
    assert found.response == RESPONSE["synchronous"]
    exact = synchronous_response(omega=0.6, zeta=0.2, delta0=0.4, **machine).squeeze()
    apart = np.abs(exact.amplitude - found.amplitude)
    assert apart.min() < 1e-9
    lag = np.atleast_1d(exact.phase_lag)[np.argmin(np.atleast_1d(apart))]
    assert found.phase_lag.item() == pytest.approx(float(lag), abs=1e-9)


def test_whip_stays_while_the_speed_goes_down_and_is_not_reached_going_up():
    given = {"zeta": 0.1, "delta0": 1.0, "friction": 0.2, "disc_radius": 10.0, "method": "taylor"}
    speeds = [0.3, 0.5, 0.6]
    up = sweep(omega=speeds, direction="up", **given).response.values.ravel()
    down = sweep(omega=speeds, direction="down", starts=[KNOCK], **given).response.values.ravel()
    assert RESPONSE["rolling"] not in up
    assert down.tolist() == [RESPONSE[k] for k in ("contact_free", "rolling", "rolling")]


def window(rolling, *, whirl=-1.0, touches=0):
    """Three revolutions at constant radius, rolling for the stretches given."""
    times = np.linspace(0.0, 6.0 * math.pi, 193)
    z = 2.0 * np.exp(1j * (whirl - 1.0) * times)
    states = np.column_stack([z.real, z.imag, (1j * whirl * z).real, (1j * whirl * z).imag])
    rotor = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=2.0)
    table = np.array(rolling, dtype=float).reshape(-1, 2)
    return Window(rotor, times, states, np.empty((0, 9)), touches, True, 1e-9, table)


EACH = [(1.0, 1.5), (7.0, 8.0), (13.0, 18.0)]


@pytest.mark.parametrize(
    ("seen", "period", "whips"),
    [
        (window(EACH), None, True),
        (window([(0.0, 6.0 * math.pi)]), 1.3, True),
        (window(EACH, whirl=0.5), None, False),
        (window(EACH, touches=2), None, False),
        (window(EACH[:2]), None, False),
        (window(EACH), math.pi, False),
        (window([]), None, False),
    ],
)
def test_it_is_whip_only_if_it_rolls_backwards_in_every_period(seen, period, whips):
    assert rolls_backwards(seen, period) is whips


def test_friction_holds_a_rotor_at_rest_off_the_bottom():
    """A block on an inclined ring: it stays where the slope is no steeper than the friction."""
    rotor = Rotor(omega=0.0, zeta=0.05, delta0=1.0, load=0.5, friction=0.3, disc_radius=5.0)
    settled = follow_to_steady_state(rotor, (-1.2, -0.4, 0.3, -0.8), TAYLOR)
    assert settled.response == "synchronous"
    z = complex(*settled.end[:2])
    slope = math.atan2(abs(z.real), -z.imag)
    assert 1e-3 < slope < math.atan(0.3)
    assert (abs(z) - 1.0) ** 1.5 == pytest.approx(0.5 * math.cos(slope), abs=1e-8)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"delta0": 1.0, "friction": 0.2}, "disc_radius must be given with friction"),
        ({"delta0": [0.0, 1.0], "friction": [0.0, 0.2], "disc_radius": 1.0}, "without clearance"),
        ({"delta0": 1.0, "friction": -0.2, "disc_radius": 1.0}, "zero or positive"),
        ({"delta0": 1.0, "friction": 0.2, "disc_radius": [1.0, math.nan]}, "disc_radius"),
    ],
)
def test_friction_that_cannot_be_is_refused_in_one_line(given, words):
    with pytest.raises(ValueError, match=words) as refused:
        sweep(omega=1.0, zeta=0.1, **given)
    assert "\n" not in str(refused.value)


def test_touches_fade_by_the_law_that_friction_leaves_as_it_is():
    """Friction carries the centre along the ring: 1/h grows as without, ever more closely."""
    rotor = Rotor(omega=1.6, zeta=0.2, delta0=1.4, friction=0.35, disc_radius=1.0)
    settled = follow_to_steady_state(rotor, (3.4, -0.3, -0.4, -0.4), TAYLOR)
    assert settled.response == "touching"
    run = simulate(rotor, start=(3.4, -0.3, -0.4, -0.4), duration=4000.0, method="taylor")
    growth = np.diff(1.0 / run.peak_indentation.values)
    off = np.abs(growth / touch_fading(rotor) - 1.0)
    assert off[-20:].max() < 0.01
    assert off[-20:].max() < 0.5 * off[20:40].max()


def test_friction_makes_tori_without_a_load():
    """Where a pair of multipliers has crossed the unit circle the motion never repeats itself.

    Two exponents are zero, and the others below.
    """
    rotor = Rotor(
        omega=2.37, zeta=0.02, delta0=1.0, contact_exponent=1.0, friction=0.05, disc_radius=5.0
    )
    near = np.array([0.157, 1.116, 0.906, -4.344])
    found = sweep(
        omega=2.37, zeta=0.02, delta0=1.0, contact_exponent=1.0, friction=0.05, disc_radius=5.0,
        starts=[near], method="taylor",
    ).squeeze()  # fmt: skip
    assert found.response == RESPONSE["quasi_periodic"]
    assert np.isnan(found.period)
    exponents = lyapunov_exponent(rotor, start=near, transient=2000.0, duration=3000.0)
    first, second, third, _ = exponents.lyapunov_exponent.values
    assert abs(first) < 1e-4
    assert abs(second) < 1e-4
    assert third < -2e-3
