"""Branches of limit cycles over any parameter: special points, both ways, studies, archives."""

from dataclasses import replace

import numpy as np
import pytest

import rotor_ida
from rotor_ida import InputError, Rotor, continue_cycle, limit_cycle
from rotor_ida.cycles.branch_course import stable_ranges
from rotor_ida.schema import RESPONSE, SPECIAL, STABILITY, words_of
from tests.cycles.known import (
    BOUNCING,
    CYCLES,
    FULL,
    LYING,
    REST,
    SLIVER,
    SPECIAL_POINTS,
    once_round,
    revolutions,
    state_of,
)
from tests.cycles.known import specials as specials_of

WIDE = (0.1, 5.0)
START = {2.0: (BOUNCING.rotor, BOUNCING.state), 0.5: (FULL.rotor, FULL.state)}


@pytest.fixture(scope="module")
def isolas():
    """The closed branches of the two known cycles over omega."""
    return {delta0: continue_cycle(rotor, start=limit_cycle(rotor, start=state), limits=WIDE)
            for delta0, (rotor, state) in START.items()}  # fmt: skip


@pytest.fixture(scope="module")
def doubled(isolas):
    """The branch of doubled cycles that leaves the bouncing ones in the sliver."""
    isola = isolas[2.0]
    place = specials(isola, "period_doubling")[np.argmin(
        isola["special_value"].values[specials(isola, "period_doubling")])]  # fmt: skip
    return continue_cycle(BOUNCING.rotor, start=isola.isel(special=place), limits=WIDE)


def specials(branch, kind):
    return np.flatnonzero(branch["special_kind"] == SPECIAL[kind])


def table(branch):
    """Special points by value and period, in an order that does not hang on the start."""
    columns = [branch[f"special_{name}"].values for name in ("kind", "value", "period")]
    rows = np.column_stack(columns)
    return rows[np.lexsort(rows.T[::-1].round(6))]


@pytest.mark.parametrize("delta0", START)
def test_isolas_close(isolas, delta0):
    """DESIGN 9: at delta0 0.5 and 2 the branch comes back to itself, with no end."""
    isola = isolas[delta0]
    ends = (isola.attrs["closed"], isola.attrs["first_end"], isola.attrs["last_end"])
    assert ends == (1, "closed", "closed")
    for name in ("omega", "period", "x", "vy"):
        assert isola[name][-1].item() == isola[name][0].item()
    for kind in SPECIAL:
        assert len(specials(isola, kind)) % 2 == 0, kind


@pytest.mark.parametrize("known", SPECIAL_POINTS)
def test_folds_and_doublings_are_those_of_auto_and_dop853(isolas, known):
    """Six points found by programs that share nothing with this one, to 1e-9 in omega."""
    isola = isolas[known.rotor.delta0]
    places = specials(isola, known.kind)
    nearest = places[np.argmin(np.abs(isola["special_value"].values[places] - known.rotor.omega))]
    # the witness is good to 2e-10
    assert isola["special_value"][nearest].item() == pytest.approx(known.rotor.omega, abs=1e-9)
    assert isola["special_period"][nearest].item() == pytest.approx(known.period, abs=1e-8)


@pytest.mark.parametrize("delta0", START)
def test_there_are_no_others(isolas, delta0):
    for kind in ("fold", "period_doubling"):
        expected = [each for each in SPECIAL_POINTS
                    if each.kind == kind and each.rotor.delta0 == delta0]  # fmt: skip
        assert len(specials(isolas[delta0], kind)) == len(expected)


@pytest.mark.parametrize("delta0", START)
def test_stability_changes_at_folds_and_doublings_alone(isolas, delta0):
    """And by the eigenvalues' own sign: the largest of the others leaves the unit circle there."""
    isola = isolas[delta0]
    unstable = (isola["stability"] == STABILITY["unstable"]).values
    changes = set(np.flatnonzero(unstable[1:] != unstable[:-1]).tolist())
    places = np.concatenate([specials(isola, "fold"), specials(isola, "period_doubling")])
    assert changes == set(isola["special_point"].values[places].tolist())
    size = np.hypot(isola["multiplier_real"], isola["multiplier_imag"]).values
    assert ((size > 1.0 + 1e-12).any(axis=1) == unstable).all()


@pytest.mark.parametrize("delta0", START)
def test_omega_turns_back_at_folds_alone(isolas, delta0):
    isola = isolas[delta0]
    omega = isola["omega"].values
    # twice, or more often where the branch begins
    turns = np.flatnonzero(np.diff(omega)[1:] * np.diff(omega)[:-1] < 0.0)
    folds = isola["special_point"].values[specials(isola, "fold")]
    assert all(np.abs(turns + 0.5 - fold).min() <= 1.5 for fold in folds)
    assert len(turns) == len(folds)
    assert (np.sign(isola["slope"][:-1].values[np.diff(omega) > 0.02]) > 0.0).all()


@pytest.mark.parametrize("delta0", START)
def test_points_follow_one_another_without_a_jump(isolas, delta0):
    """No step leads to another branch: extremes and period change little from point to point."""
    isola = isolas[delta0]
    for name, size in (("radius_max", "radius_max"), ("radius_min", "radius_max"),
                       ("period", "period")):  # fmt: skip
        values = isola[name].values
        assert np.abs(np.diff(values)).max() < 0.06 * isola[size].max(), name
    assert isola["residual"].max() < 1e-11
    assert isola["trivial_defect"].max() < 1e-10


@pytest.mark.parametrize("delta0", START)
def test_contacts_change_at_grazes_alone(isolas, delta0):
    isola = isolas[delta0]
    changes = np.flatnonzero(np.diff(isola["contact_count"].values))
    grazes = specials(isola, "graze")
    assert changes.tolist() == isola["special_point"].values[grazes].tolist()
    kinds = isola["response"].values
    assert ((kinds == RESPONSE["full_contact"]) == (isola["contact_count"] == 0)).all()


def test_at_a_graze_the_radius_touches_the_ring(isolas):
    """By the extremes of a run from the state found there: one of its turns is on the ring."""
    isola = isolas[2.0]
    for place in specials(isola, "graze"):
        start = tuple(float(isola[f"special_{name}"][place]) for name in ("x", "y", "vx", "vy"))
        rotor = Rotor(omega=isola["special_value"][place].item(), zeta=0.07, delta0=2.0)
        period = isola["special_period"][place].item()
        run = rotor_ida.simulate(rotor, start=start, duration=period, samples=40_001)
        radius = np.hypot(run["x"], run["y"]).values
        inner = radius[1:-1]
        turns = inner[(inner - radius[:-2]) * (radius[2:] - inner) <= 0.0]
        # between samples 1e-4 apart
        assert np.abs(turns - 2.0).min() < 1e-6


def test_the_sliver_is_stable_between_its_fold_and_its_doubling(isolas):
    """Less than 0.003 wide, and on the isola: known cycles lie on it."""
    isola = isolas[2.0]
    fold, doubling = SPECIAL_POINTS[2].rotor.omega, SPECIAL_POINTS[3].rotor.omega
    inside = (isola["omega"] > fold) & (isola["omega"] < doubling) & (isola["period"] > 20.0)
    sliver = isola.isel(point=np.flatnonzero(inside & (isola["stability"] == STABILITY["stable"])))
    assert sliver.sizes["point"] >= 2
    for known in SLIVER:
        branch = continue_cycle(known.rotor, start=known.state, limits=(0.39, 0.41))
        there = np.sort(branch["special_value"].values[specials(branch, "period_doubling")])
        assert there == pytest.approx([doubling], abs=1e-9)
        there = branch["special_value"].values[specials(branch, "fold")]
        assert there == pytest.approx([fold], abs=1e-9)


def test_the_doubled_branch_leaves_one_doubling_and_ends_at_the_other(doubled):
    """From 0.4006 its period is twice the other's; it comes back to halves at 1.80339."""
    assert doubled.attrs["last_end"] == "halved"
    assert doubled.attrs["start_special"] == "period_doubling"
    assert doubled["omega"][-1].item() == pytest.approx(1.803392470017, abs=1e-9)
    assert doubled["period"][0].item() == pytest.approx(2.0 * 21.98437687706, rel=1e-3)
    assert doubled["omega"][0].item() == pytest.approx(0.400606983928, abs=1e-3)
    assert doubled["period"][-1].item() == pytest.approx(5.05425053056, abs=1e-8)
    last = doubled.isel(special=-1)
    assert last["special_kind"].item() == SPECIAL["period_doubling"]
    assert last["special_value"].item() == doubled["omega"][-1].item()


def test_any_point_leads_to_the_same_special_points(isolas):
    """Going on from a point of an archived branch, not from where it began."""
    isola = isolas[2.0]
    point = isola.isel(point=int(0.77 * isola.sizes["point"]))
    again = continue_cycle(BOUNCING.rotor, start=point, limits=WIDE)
    assert again.attrs["closed"] == 1
    np.testing.assert_allclose(table(again), table(isola), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("direction", ["forward", "backward"])
def test_one_way_is_one_side(direction):
    """Forward and backward from one start make the branch both ways."""
    both = continue_cycle(BOUNCING.rotor, start=REST, limits=(1.7, 2.3))
    one = continue_cycle(BOUNCING.rotor, start=REST, limits=(1.7, 2.3), direction=direction)
    here = int(np.argmin(np.abs(both["omega"].values - 2.0)))
    side = slice(here, None) if direction == "forward" else slice(None, here + 1)
    np.testing.assert_array_equal(one["omega"].values, both["omega"].values[side])
    end = {"forward": 2.3, "backward": 1.7}[direction]
    assert one["omega"][{"forward": -1, "backward": 0}[direction]].item() == end
    assert one.attrs["closed"] == 0
    assert {one.attrs["first_end"], one.attrs["last_end"]} == {"limits", "start"}


RUB = Rotor(omega=3.0, zeta=0.07, delta0=0.5, friction=0.02, disc_radius=10.0)
# Over any parameter: with a shaft and contact damping from the paper's rotor on, and with friction
# down to the rotor without.
OVER = [
    (BOUNCING.rotor, "zeta", (0.0651, 0.0742)),
    (BOUNCING.rotor, "delta0", (1.86, 2.12)),
    (BOUNCING.rotor, "shaft_stiffness", (0.0, 0.5)),
    (BOUNCING.rotor, "contact_damping", (0.0, 0.5)),
    (RUB, "friction", (0.0, 0.05)),
    *((LYING, name, limits) for name, limits in {
        "omega": (1.1, 1.3), "zeta": (0.06, 0.09), "delta0": (0.4, 0.6),
        "shaft_stiffness": (0.0, 0.2), "contact_damping": (0.0, 0.3), "load": (0.8, 1.2),
    }.items()),
]  # fmt: skip


@pytest.mark.parametrize(("rotor", "parameter", "limits"), OVER)
def test_a_branch_over_any_parameter_is_of_the_cycles_that_are_there(rotor, parameter, limits):
    """At its ends and inside by the rotor's own iteration, and by DOP853, which knows no rub."""
    branch = continue_cycle(
        rotor, start=(3.0, 1.0, 0.0, 0.0) if rotor is RUB else REST, parameter=parameter,
        limits=limits,
    )  # fmt: skip
    assert branch.attrs["first_end"] == branch.attrs["last_end"] == "limits"
    assert branch.residual.values.max() < 1e-12
    for place in (0, branch.sizes["point"] // 2, -1):
        point = branch.isel(point=place)
        there = replace(rotor, **{parameter: float(point[parameter])})
        period = point.period.item()
        cycle = limit_cycle(there, start=state_of(point), period=period)
        for name in ("period", "radius_min", "radius_max"):
            assert point[name].item() == pytest.approx(cycle[name].item(), rel=1e-11)
        if not there.friction:
            end = once_round(there, state_of(point), period).end
            np.testing.assert_allclose(end, state_of(point), rtol=0.0, atol=1e-9)
        if there.load:
            assert revolutions(there, period) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("name", "parameter", "limits", "kind", "value"), [
    ("bouncing", "shaft_stiffness", (0.0, 0.5), "fold", 1.0),
    ("load", "omega", (1.1, 1.9), "fold", 1.0),
    ("load", "omega", (1.1, 1.9), "period_doubling", -1.0),
])  # fmt: skip
def test_at_a_special_point_dop853_has_that_multiplier(name, parameter, limits, kind, value):
    rotor, start = CYCLES[name]
    branch = continue_cycle(rotor, start=start, parameter=parameter, limits=limits, points=400)
    special = specials_of(branch, kind).isel(special=0)
    there = replace(rotor, **{parameter: float(special.special_value)})
    other = once_round(there, state_of(special, "special_"), float(special.special_period))
    apart = np.sort(np.abs(np.linalg.eigvals(other.monodromy) - value))
    if there.load or kind != "fold":
        assert apart[0] < 1e-6
    else:  # two of them are 1, and only the root of rounding tells them apart
        assert apart[1] < 1e-4


def test_doubled_cycles_under_a_load_take_twice_the_revolutions():
    branch = continue_cycle(LYING, start=REST, limits=(1.1, 1.9), points=400)
    start = specials_of(branch, "period_doubling").isel(special=0)
    doubled = continue_cycle(LYING, start=start, limits=(1.1, 1.9), points=12)
    last = doubled.isel(point=-1)
    rotor, period = replace(LYING, omega=float(last.omega)), float(last.period)
    assert revolutions(rotor, period) == pytest.approx(2.0, abs=1e-12)
    end = once_round(rotor, state_of(last), period).end
    np.testing.assert_allclose(end, state_of(last), rtol=0.0, atol=1e-8)
    half = once_round(rotor, state_of(last), 0.5 * period).end
    assert np.abs(half - end).max() > 1e-3


def test_a_closed_branch_under_a_load_is_known_as_closed():
    """Over contact damping its period does not change."""
    rotor = Rotor(omega=1.5, zeta=0.08, delta0=1.0, load=0.1, contact_damping=0.8)
    branch = continue_cycle(
        rotor, start=(0, -1, 0, 0), parameter="contact_damping", limits=(0.0, 3.0)
    )
    assert branch.attrs["closed"] == 1
    assert specials_of(branch, "fold").sizes["special"] == 2


def test_a_branch_goes_round_the_corner_where_the_slip_comes_to_nothing():
    """Before it the disc slides forwards all along, behind it it rolls or slides back once.

    Multipliers jump there, so it is no fold; the cycles themselves meet.
    """
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)
    branch = continue_cycle(
        rotor, start=(3.0, 1.0, 0.0, 0.0), parameter="friction", limits=(0.0, 0.3)
    )
    assert (branch.attrs["first_end"], branch.attrs["last_end"]) == ("hopf", "limits")
    assert float(branch.residual.max()) < 1e-12
    after = int(specials_of(branch, "sliding").special_point[0]) + 1
    near = branch.isel(point=[after - 1, after])
    before, behind = (
        rotor_ida.simulate(
            replace(rotor, friction=float(here.friction)), start=state_of(here),
            duration=float(here.period), samples=2001, method="taylor",
        )
        for here in (near.isel(point=0), near.isel(point=1))
    )  # fmt: skip
    assert before.event_kind.size == 0
    assert 0.0 <= before.slip_speed.min() < 1e-4
    assert behind.event_kind.size > 0
    for name in ("friction", "period", "radius_max"):
        one, other = near[name].values
        assert other == pytest.approx(one, abs=1e-5)
    assert abs(np.diff(near["slope"].values)[0]) > 1e-2


def test_a_corner_at_which_a_multiplier_jumps_past_one_is_no_fold():
    """The parameter turns back there. Beside it no multiplier comes near 1 but the trivial one."""
    rotor = Rotor(
        omega=1.16, zeta=0.0893, delta0=0.425, contact_exponent=1.0, friction=0.21, disc_radius=4.8
    )
    branch = continue_cycle(
        rotor, start=(2.127, 0.864, 0.0, 0.0), parameter="zeta", limits=(0.045, 0.134)
    )
    corner = specials_of(branch, "discontinuous")
    assert corner.sizes["special"] == 1
    sliding = specials_of(branch, "sliding").special_value.values
    assert np.abs(sliding - corner.special_value.item()).min() < 1e-9
    after = int(corner.special_point[0]) + 1
    near = branch.isel(point=[after - 1, after])
    first, second = near["slope"].values
    assert first * second < 0.0
    assert words_of(near["stability"]) == ["stable", "unstable"]
    away = np.sort(np.abs(near.multiplier_real.values + 1j * near.multiplier_imag.values - 1.0))
    assert away[:, 0].max() < 1e-8
    assert away[:, 1].min() > 1e-2
    ranges = stable_ranges(branch)
    assert any(high == corner.special_value.item() for _, high in ranges)


def test_two_grazes_in_one_step_are_seen():
    """The extremum of the radius dips below the ring and comes back within a hundredth of delta0.

    The coarse steps of the rest of the branch would pass over both.
    """
    rotor = Rotor(omega=1.3850668555561103, zeta=0.07, delta0=1.0)
    start = (-0.624493313840432, 0.4765683392859543, 1.6091633273020345, -0.5633522915863312)
    branch = continue_cycle(rotor, start=start, parameter="delta0", limits=(0.02, 8.0))
    assert branch.attrs["closed"] == 1
    grazes = branch["special_value"].values[specials(branch, "graze")]
    for expected in (0.9622163, 0.9822761):
        assert np.abs(grazes - expected).min() < 1e-6


@pytest.mark.parametrize(("limits", "direction"), [(WIDE, "both"), ((1.9, 2.1), "backward")])
def test_progress_comes_to_its_end(limits, direction):
    """Also where the branch ends early, closes, or goes but one way."""
    seen = []
    continue_cycle(BOUNCING.rotor, start=REST, limits=limits, direction=direction, points=600,
                   progress=lambda *numbers: seen.append(numbers))  # fmt: skip
    done = [each for each, _ in seen]
    assert done == sorted(done)
    assert {total for _, total in seen} == {599 if direction == "backward" else 1198}
    assert seen[-1][0] == seen[-1][1]


def test_points_end_a_branch():
    branch = continue_cycle(BOUNCING.rotor, start=REST, limits=WIDE, points=5)
    assert branch.sizes["point"] == 9
    assert (branch.attrs["first_end"], branch.attrs["last_end"]) == ("points", "points")


@pytest.mark.parametrize(("arguments", "says"), [
    ({"limits": (2.1, 3.0)}, "limits of omega must contain that of the start, 2.0, got"),
    ({"limits": (3.0, 1.0)}, "limits of omega must be two increasing numbers from 0 on, got"),
    ({"limits": (2.0,)}, "limits of omega must be two increasing numbers from 0 on, got"),
    ({"limits": (-1.0, 3.0)}, "limits of omega must be two increasing numbers from 0 on, got"),
    ({"limits": (0.0, 3.0)}, "limits of omega must be above 0, got"),
    ({"limits": (1.0, np.nan)}, "limits must"),
    ({"parameter": "phase"}, "parameter must be"),
    ({"direction": "up"}, "direction must be"),
    ({"points": 1}, "points must be at least 2, got 1"),
    ({"progress": 3}, "progress must be"),
    ({"rotor": Rotor(omega=2.0, zeta=0.0, delta0=2.0)}, "zeta must be above 0 for a limit cycle"),
    ({"rotor": Rotor(omega=1.7, zeta=0.07, delta0=0.0)},
     "start must lead to a limit cycle, got one from which the response is synchronous"),
    ({"rotor": Rotor(omega=1.7, zeta=0.07, delta0=9.0)},
     "start must lead to a limit cycle, got one from which the response is contact_free"),
    ({"rotor": Rotor(omega=2.0, zeta=0.07, delta0=0.0), "parameter": "delta0",
      "limits": (0.0, 3.0)},
     "delta0 must be above 0 to be continued, got 0.0"),
    ({"parameter": "friction"}, "disc_radius must be given"),
    ({"parameter": "disc_radius"}, "disc_radius must be given"),
    ({"rotor": replace(RUB, friction=0.0), "parameter": "disc_radius", "limits": (0.0, 12.0)},
     "friction must be above 0 for disc_radius"),
    ({"rotor": LYING, "parameter": "load", "limits": (0.0, 2.0)},
     "limits of load must be above 0"),
    ({"rotor": replace(LYING, load=0.0), "parameter": "load", "limits": (0.0, 2.0)},
     "limits of load must be above 0"),
    ({"rotor": replace(LYING, load=0.0), "parameter": "load"},
     "load must be above 0 to be continued, got 0.0"),
])  # fmt: skip
def test_what_cannot_be_continued_is_refused(arguments, says):
    given = {"rotor": BOUNCING.rotor, "start": REST, "limits": (0.5, 3.0)} | arguments
    with pytest.raises(InputError, match=says):
        continue_cycle(given.pop("rotor"), **given)
