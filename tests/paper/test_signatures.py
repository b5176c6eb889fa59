"""What the scenario `signatures` says of each rub: that it is one, its lines, and its signs."""

import math
from fractions import Fraction

import numpy as np
import pytest

from rotor_ida import continue_cycle, hopf_points, rub_signs, run_up, signals_of, sweep
from rotor_ida.paper.whip import FIRST_OF_WHIP, end_of
from rotor_ida.schema import RESPONSE, SPECIAL
from tests.scenarios import scenario

CLOSED = ["annular", "partial", "whip", "once", "half"]  # cycles
UPRIGHT = ["synchronous", "annular", "partial", "whip"]


@pytest.fixture(scope="module")
def signatures():
    return scenario("signatures")


@pytest.fixture(scope="module")
def exact(signatures):
    return {name: signatures.exact_of(name) for name in signatures.MOTIONS}


@pytest.fixture(scope="module")
def records(signatures, exact):
    return {name: signatures.record_of(name, exact[name]) for name in exact}


@pytest.fixture(scope="module")
def signs(signatures, exact, records):
    return signatures.signs_of_all(exact, records)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("free", "Nothing stands out"), ("synchronous", "Nothing stands out"),
        ("annular", "An annular or partial rub has such a line"),
        ("partial", "An annular or partial rub has such a line"),
        ("whip", "The rotor whirls backwards, at 1.07 times its speed"),
        ("once", "A rub once a revolution under a load has multiples"),
        ("half", "a rub under a load that repeats after 2 revolutions"),
        ("chaos", "chaos has such a floor"),
    ],
)  # fmt: skip
def test_words_tell_what_a_record_is_of(records, name, words):
    """Each record has the words of its motion and no others."""
    said = rub_signs(signals_of(records[name])).attrs["sentence"]
    assert words in said
    others = ("Nothing", "annular", "backwards, at", "once a revolution", "repeats after", "chaos")
    assert sum(each in said for each in others) == 1


@pytest.fixture(scope="module")
def branch(signatures):
    return signatures.branch_to_whip()


def share(signs, name, motions):
    """Return a sign over 1X forward, by motion."""
    return {each: float(signs[name].sel(motion=each) / signs.forward.sel(motion=each))
            for each in motions}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        ("free", "contact_free"), ("synchronous", "synchronous"), ("partial", "bouncing"),
        ("whip", "rolling"), ("once", "bouncing"), ("half", "bouncing"), ("chaos", "chaotic"),
    ],
)  # fmt: skip
def test_a_sweep_settles_on_each_motion_from_afar(signatures, signs, name, kind):
    motion = signatures.MOTIONS[name]
    given = motion.rotor(motion.omega).given
    # between two stable whirls the slow run-up stays on that in contact
    start = (2.5, 0.0, 0.0, 1.2) if name == "synchronous" else motion.start
    found = sweep(starts=[start], method="taylor", **given)
    assert int(found.response.squeeze()) == RESPONSE[kind]
    assert int(signs.response.sel(motion=name)) == RESPONSE[kind]


def test_each_motion_attracts(signs):
    decaying = signs.drop_sel(motion="chaos")
    assert float(decaying.growth.max()) < -1e-4
    chaos = signs.sel(motion="chaos")
    assert 0.05 < float(chaos.growth) < 0.09
    assert float(chaos.growth) > 10.0 * float(chaos.growth_error)


def test_full_annular_rub_is_born_at_the_hopf_point_and_becomes_partial_at_a_graze(
    signatures, exact, branch
):
    motion = signatures.MOTIONS["partial"]
    given = {name: value for name, value in motion.rotor(1.0).given.items()
             if name not in ("omega", "disc_radius")}  # fmt: skip
    born = hopf_points(**given).isel(hopf=0).squeeze()
    hopf, graze, fold = (signatures.special(branch, kind) for kind in ("hopf", "graze", "fold"))
    assert hopf == pytest.approx(born.hopf_omega.item(), rel=1e-8)
    assert graze == pytest.approx(0.66079806, abs=2e-7)
    assert fold == pytest.approx(0.84047246, abs=2e-7)
    clearance = signatures.MACHINE["delta0"]
    assert hopf < exact["annular"].omega.item() < graze < exact["partial"].omega.item() < fold
    assert exact["annular"].radius_min.item() > clearance > exact["partial"].radius_min.item()
    # the backward line begins as the mode that the whirl loses its stability to
    first = signatures.cycles_along("annular", [hopf + 1e-4])[0]
    beside = first.frequency.values[np.argsort(-first.whirl_amplitude.values)[1]]
    assert beside == pytest.approx((born.hopf_omega - born.hopf_frequency).item(), rel=1e-3)


def test_beyond_the_fold_a_run_up_goes_over_into_whip(signatures, branch):
    motion = signatures.MOTIONS["partial"]
    fold = signatures.special(branch, "fold")
    for to, whips in ((fold - 0.01, False), (fold + 0.06, True)):
        start = signatures.state_of(signatures.cycles_along("partial", [0.82])[0])
        run = run_up(
            motion.rotor(0.82), start=start, to=to, rate=5e-5, samples=4001, method="taylor"
        )  # fmt: skip
        assert (end_of(run, late=0.95) >= FIRST_OF_WHIP) == whips


def test_lines_of_the_signals_are_those_of_the_exact_cycles(signs):
    cycles = signs.sel(motion=CLOSED)
    np.testing.assert_allclose(cycles.order, cycles.exact_order, rtol=0.0, atol=1e-4)
    np.testing.assert_allclose(cycles.amplitude, cycles.exact_amplitude, rtol=1e-3)
    np.testing.assert_allclose(
        cycles.exact_order, [-1.35480711, -1.13804454, -1.06517128, 2.0, 0.5], rtol=1e-7
    )
    np.testing.assert_allclose(
        list(share(signs, "exact_amplitude", CLOSED).values()),
        [0.28016, 0.78172, 5.4302, 0.155637, 0.264092], rtol=1e-3,
    )  # fmt: skip


def test_a_synchronous_rub_has_no_line_but_1x(signs):
    for name in ("free", "synchronous"):
        here = signs.sel(motion=name)
        assert math.isnan(here.order)
        assert float(here.backward + here.twice) < 1e-12 * float(here.forward)
        assert float(here.phase_spread) < 1e-12


def test_fractions_of_the_speed_are_a_sign_of_a_load_and_not_of_a_rub(signs):
    """Upright no line lies near a fraction with a denominator up to 6, nor below 1X."""
    assert float(signs.exact_order.sel(motion="half")) == pytest.approx(0.5, abs=1e-12)
    for name in UPRIGHT[1:]:
        order = float(signs.exact_order.sel(motion=name))
        assert order < -1.0
        assert abs(order - Fraction(order).limit_denominator(6)) > 1e-3


def test_the_sense_of_whirl_tells_whip_alone(signs):
    ratio = signs.whirl_over_spin
    assert float(ratio.sel(motion="whip")) == pytest.approx(-1.068, abs=0.01)
    forward = ["free", "synchronous", "annular", "partial", "once", "half"]
    np.testing.assert_allclose(ratio.sel(motion=forward), 1.0, atol=0.01)
    # though the backward line is a quarter and three quarters of 1X
    shares = share(signs, "amplitude", ["annular", "partial"])
    assert shares["annular"] > 0.25
    assert shares["partial"] > 0.75


def test_the_wave_is_clipped_in_the_rub_once_a_revolution_alone(signs):
    flat = signs.flatness
    assert float(flat.sel(motion="once")) == pytest.approx(0.785, abs=0.005)
    assert float(flat.drop_sel(motion="once").min()) > 0.99


def test_2x_is_strong_in_the_rub_once_a_revolution_without_any_coupling(signs):
    shares = share(signs, "twice", ["annular", "partial", "whip", "once", "half"])
    assert shares.pop("once") == pytest.approx(0.266, abs=0.005)
    assert max(shares.values()) < 0.02


def test_the_half_is_a_vibration_along_a_line_and_lines_upright_are_circles(signs):
    both = signs.counterpart / signs.amplitude
    assert float(both.sel(motion="half")) == pytest.approx(0.930, abs=0.005)
    assert float(both.sel(motion=UPRIGHT[1:]).max()) < 1e-4


def test_the_ring_lifts_the_shaft_under_a_load_alone(signatures, signs):
    sag = signatures.LOAD / signatures.MACHINE["shaft_stiffness"]
    under_load = signs.offset.sel(motion=["once", "half", "chaos"])
    assert float(under_load.max()) < 0.5 * sag
    np.testing.assert_allclose(under_load[:2], [0.228, 0.600], atol=0.002)
    upright = signs.offset.sel(motion=UPRIGHT) / signs.largest_radius.sel(motion=UPRIGHT)
    assert float(upright.max()) < 2e-3


def test_chaos_fills_what_lies_between_the_lines(signs):
    floor = signs.floor
    assert float(floor.sel(motion="chaos")) > 0.03
    assert float(floor.drop_sel(motion="chaos").max()) < 1e-4
    assert float(signs.phase_spread.sel(motion="chaos")) > 0.1


def test_the_line_of_whip_hardly_moves_and_passes_minus_1x(signatures):
    """It lies below the natural frequency of shaft and ring, sqrt(1 + kappa)."""
    speeds = np.array([0.85, 0.95, 0.97, 1.3])
    lines = []
    for cycle in signatures.cycles_along("whip", speeds):
        lines.append(float(cycle.frequency.values[cycle.whirl_amplitude.values.argmax()]))
    assert max(lines) - min(lines) < 0.03
    natural = math.sqrt(1.0 + signatures.MACHINE["shaft_stiffness"])
    assert 0.93 * natural < -max(lines) < -min(lines) < 0.97 * natural
    ratios = np.array(lines) / speeds
    assert ratios[1] < -1.0 < ratios[2]


def test_the_phase_turns_less_in_a_rub_than_without_contact(signatures):
    turned = {}
    for name in ("free", "synchronous"):
        ramp = signatures.ramp_of(name)
        off, turned[name] = signatures.beside_the_curve(signatures.MOTIONS[name], ramp)
        assert off < 0.025
        touches = np.hypot(ramp.x, ramp.y).max() > ramp.delta0
        assert bool(touches) == (name == "synchronous")
    assert turned["free"] == pytest.approx(164.0, abs=3.0)
    assert turned["synchronous"] == pytest.approx(54.0, abs=3.0)


def test_the_cycle_within_chaos_is_unstable_and_that_of_the_half(signatures, exact):
    cycle = exact["chaos"]
    revolution = 2.0 * math.pi / signatures.MOTIONS["chaos"].omega
    assert cycle.period.item() == pytest.approx(2.0 * revolution, rel=1e-12)
    assert cycle.stability.item() == 0


def test_the_half_loses_its_stability_at_a_torus_bifurcation(signatures, exact):
    motion = signatures.MOTIONS["half"]
    along = continue_cycle(
        motion.rotor(motion.omega), start=signatures.state_of(exact["half"]), parameter="omega",
        limits=(0.75, 0.9),
    )  # fmt: skip
    torus = along.special_value.values[along.special_kind.values == SPECIAL["torus"]]
    assert torus[:1] == pytest.approx([0.847953], abs=2e-6)
