"""Folds and doublings over two parameters: against branches, which know nothing of the curve."""

import numpy as np
import pytest

import rotor_ida
from rotor_ida import InputError, Rotor, bifurcation_curve, continue_cycle
from rotor_ida.schema import SPECIAL
from tests.cycles.known import BOUNCING, FULL, SPECIAL_POINTS
from tests.witness import flown

NAMES = ("omega", "delta0")
AROUND = {"omega": (2.2, 3.1), "delta0": (0.45, 0.55)}
# The trace of M at a bifurcation, with q = exp(-2 zeta T).
TRACE = {"fold": lambda q: 2.0 * (1.0 + q), "period_doubling": lambda q: 0.0}


def bifurcations(branch, kind):
    return branch["special_value"].values[branch["special_kind"].values == SPECIAL[kind]]


@pytest.fixture(scope="module")
def fold():
    return bifurcation_curve(FULL.rotor, start=FULL.state, kind="fold", limits=AROUND)


@pytest.fixture(scope="module")
def doubling():
    """That of the bouncing cycle, from 1.80339: over omega and delta0 it closes on itself."""
    branch = continue_cycle(BOUNCING.rotor, start=BOUNCING.state, limits=(1.7, 2.1))
    place = int(np.flatnonzero(branch["special_kind"] == SPECIAL["period_doubling"])[0])
    wide = {"omega": (0.1, 6.0), "delta0": (0.02, 6.0)}
    return bifurcation_curve(
        BOUNCING.rotor, start=branch.isel(special=place), kind="period_doubling", limits=wide
    )


@pytest.mark.parametrize("part", [0.1, 0.9])
def test_a_branch_folds_where_the_curve_says(fold, part):
    """From the fold a little aside on the stable side, over omega, at that clearance."""
    point = fold.isel(point=int(part * fold.sizes["point"]))
    rotor = Rotor(omega=point["omega"].item(), zeta=0.07, delta0=point["delta0"].item())
    limits = (rotor.omega - 0.05, rotor.omega + 0.05)
    branch = continue_cycle(rotor, start=point, limits=limits)
    found = bifurcations(branch, "fold")
    assert np.abs(found - rotor.omega).min() < 1e-9


def test_a_branch_doubles_where_the_curve_says(doubling):
    for part in (0.2, 0.45, 0.7):
        point = doubling.isel(point=int(part * doubling.sizes["point"]))
        rotor = Rotor(omega=point["omega"].item(), zeta=0.07, delta0=point["delta0"].item())
        limits = (0.99 * rotor.delta0, 1.01 * rotor.delta0)
        branch = continue_cycle(rotor, start=point, parameter="delta0", limits=limits)
        found = bifurcations(branch, "period_doubling")
        assert np.abs(found - rotor.delta0).min() < 1e-9


@pytest.mark.parametrize("which", ["fold", "doubling"])
def test_the_condition_holds_on_the_matrix_of_dop853(which, request):
    """Another integrator's trace, at points spread over the curve."""
    curve = request.getfixturevalue(which)
    kind = curve.attrs["kind"]
    for place in np.linspace(0, curve.sizes["point"] - 1, 5).astype(int):
        point = curve.isel(point=place)
        rotor = Rotor(omega=point["omega"].item(), zeta=0.07, delta0=point["delta0"].item())
        period = point["period"].item()
        state = np.array([point[name].item() for name in ("x", "y", "vx", "vy")])
        end = flown(rotor, state, period)
        np.testing.assert_allclose(end.end, state, rtol=0.0, atol=1e-9)
        expected = TRACE[kind](np.exp(-2.0 * 0.07 * period))
        assert np.trace(end.monodromy) == pytest.approx(expected, abs=1e-6)


def test_the_curve_of_doublings_closes_and_joins_both_ends_of_the_unstable_part(doubling):
    """At delta0 2 it passes the two doublings that AUTO and DOP853 find."""
    assert doubling.attrs["closed"] == 1
    omega, delta0 = doubling["omega"].values, doubling["delta0"].values
    passes = np.flatnonzero((delta0[1:] - 2.0) * (delta0[:-1] - 2.0) <= 0.0)
    for known in (SPECIAL_POINTS[3], SPECIAL_POINTS[4]):
        assert np.abs(omega[passes] - known.rotor.omega).min() < 0.1


def test_both_doublings_lie_on_one_curve(doubling):
    """From the other end the same curve, with the same grazes.

    A graze is met tangentially from the side of more contacts, where M has a kink: it is located to
    about 1e-6 there.
    """
    start = SPECIAL_POINTS[3]
    branch = continue_cycle(
        start.rotor, start=rotor_ida.limit_cycle(start.rotor, start=start.state,
                                                 period=start.period), limits=(0.39, 0.41)
    )  # fmt: skip
    place = int(np.flatnonzero(branch["special_kind"] == SPECIAL["period_doubling"])[0])
    wide = {"omega": (0.1, 6.0), "delta0": (0.02, 6.0)}
    other = bifurcation_curve(
        start.rotor, start=branch.isel(special=place), kind="period_doubling", limits=wide
    )
    assert other.attrs["closed"] == 1
    for name in ("special_value", "special_second_value"):
        np.testing.assert_allclose(np.sort(other[name]), np.sort(doubling[name]), atol=5e-6)


def test_one_parameter_after_the_other_is_the_same_curve(fold):
    """Swapped, and given as pairs: the same ends, at the limits of the clearance."""
    swapped = bifurcation_curve(
        Rotor(omega=fold["omega"][3].item(), zeta=0.07, delta0=fold["delta0"][3].item()),
        start=fold.isel(point=3), kind="fold",
        parameters=("delta0", "omega"), limits=((0.45, 0.55), (2.2, 3.1)),
    )  # fmt: skip
    ends = np.sort(fold["omega"].values[[0, -1]])
    np.testing.assert_allclose(np.sort(swapped["omega"].values[[0, -1]]), ends, atol=1e-9)
    np.testing.assert_allclose(np.sort(swapped["delta0"].values[[0, -1]]), (0.45, 0.55), atol=1e-12)


def test_over_omega_and_zeta_a_fold_goes_on_to_the_fold_at_another_damping(fold):
    curve = bifurcation_curve(FULL.rotor, start=FULL.state, kind="fold",
                              parameters=("omega", "zeta"),
                              limits={"omega": (2.2, 3.1), "zeta": (0.065, 0.075)})  # fmt: skip
    point = curve.isel(point=-1)
    rotor = Rotor(omega=point["omega"].item(), zeta=point["zeta"].item(), delta0=0.5)
    assert rotor.zeta in (0.065, 0.075)
    limits = (rotor.omega - 0.05, rotor.omega + 0.05)
    found = bifurcations(continue_cycle(rotor, start=point, limits=limits), "fold")
    assert np.abs(found - rotor.omega).min() < 1e-9


def test_an_archive_gives_it_back(fold, tmp_path):
    loaded = rotor_ida.load(rotor_ida.save(fold, tmp_path / "curve.nc"))
    assert loaded.drop_attrs(deep=False).identical(fold.drop_attrs(deep=False))
    assert loaded.attrs["kind"] == "fold"


def test_progress_comes_to_its_end():
    seen = []
    bifurcation_curve(FULL.rotor, start=FULL.state, kind="fold", limits=AROUND, points=20,
                      progress=lambda *numbers: seen.append(numbers))  # fmt: skip
    assert seen[-1] == (38, 38)  # behind the first point, each way
    assert [done for done, _ in seen] == sorted(done for done, _ in seen)


@pytest.mark.parametrize(("arguments", "says"), [
    ({"kind": "pitchfork"}, "kind must be"),
    ({"parameters": ("omega", "omega")}, "parameters must be two of omega, zeta, "),
    ({"parameters": ("omega",)}, "parameters must be two of omega, zeta, "),
    ({"limits": {"omega": (2.2, 3.2)}}, "limits must be of omega and delta0, got"),
    ({"limits": ((2.2, 3.2),)}, "limits must be two pairs of numbers"),
    ({"limits": ((0.0, 3.2), (0.4, 0.6))}, "limits of omega must be above 0"),
    ({"limits": ((2.2, 3.2), (0.6, 0.7))}, "limits must hold the delta0 of the start, 0.5"),
    ({"limits": ((2.9, 3.1), (0.4, 0.6))},
     "limits must hold a fold of the branch through the start, got none there"),
    ({"rotor": Rotor(omega=1.0, zeta=0.0, delta0=0.5), "limits": ((0.5, 2.0), (0.4, 0.6))},
     "zeta must be above 0 for a limit cycle"),
    ({"points": 1}, "points must be at least 2, got 1"),
])  # fmt: skip
def test_what_cannot_be_followed_is_refused(arguments, says):
    given = {"rotor": FULL.rotor, "start": FULL.state, "kind": "fold",
             "limits": ((2.2, 3.2), (0.4, 0.6))} | arguments  # fmt: skip
    with pytest.raises(InputError, match=says):
        bifurcation_curve(given.pop("rotor"), **given)


@pytest.mark.parametrize("second", ["zeta", "delta0"])
def test_a_curve_of_folds_goes_on_through_a_graze(second):
    """There the trace has a kink; the curve passes it and comes to the limits, not to a stop."""
    known = SPECIAL_POINTS[2]
    branch = continue_cycle(BOUNCING.rotor, start=BOUNCING.state, limits=(0.39, 5.0))
    folds = np.flatnonzero(branch["special_kind"] == SPECIAL["fold"])
    place = folds[np.argmin(branch["special_value"].values[folds])]
    assert branch["special_value"][place].item() == pytest.approx(known.rotor.omega, abs=1e-9)
    names = {"zeta": ("zeta", "delta0"), "delta0": ("omega", "delta0")}[second]
    limits = {"zeta": (0.03, 0.075), "omega": (0.3, 0.7), "delta0": (1.5, 4.0)}
    curve = bifurcation_curve(
        known.rotor,
        start=branch.isel(special=place),
        kind="fold",
        parameters=names,
        limits={name: limits[name] for name in names},
    )
    assert (curve.attrs["first_end"], curve.attrs["last_end"]) == ("limits", "limits")
    assert (curve["special_kind"] == SPECIAL["graze"]).sum() == 1
    assert curve["residual"].max() < 1e-11


def test_at_a_cusp_two_folds_meet_by_the_power_three_halves():
    """By branches over omega at fixed damping, which know nothing of the curve."""
    rotor = Rotor(omega=2.0778537615907418, zeta=0.01, delta0=0.5)
    start = (1.3359443508310456, 2.8700392188796327, -0.650809977005204, 1.1746181110346243)
    branch = continue_cycle(rotor, start=start, limits=(1.5, 2.4))
    folds = np.flatnonzero(branch["special_kind"] == SPECIAL["fold"])
    place = folds[np.argmin(np.abs(branch["special_value"].values[folds] - 1.62249752))]
    curve = bifurcation_curve(rotor, start=branch.isel(special=place), kind="fold",
                              parameters=("omega", "zeta"),
                              limits={"omega": (1.5, 1.7), "zeta": (0.003, 0.011)})  # fmt: skip
    cusps = np.flatnonzero(curve["special_kind"] == SPECIAL["cusp"])
    assert len(cusps) == 2
    place = cusps[np.argmax(curve["special_second_value"].values[cusps])]
    omega, zeta = (curve[f"special_{name}"][place].item() for name in ("value", "second_value"))
    aside, apart = [], []
    # nearer to the cusp both folds lie within one step; farther off there is another cusp
    within = (zeta - curve["zeta"] > 8e-5) & (zeta - curve["zeta"] < 2.5e-4)
    before = np.arange(curve.sizes["point"]) <= curve["special_point"][place].item()
    for point in np.flatnonzero(within & before):
        there = curve.isel(point=point)
        rotor = Rotor(omega=there["omega"].item(), zeta=there["zeta"].item(), delta0=0.5)
        near = continue_cycle(rotor, start=there, limits=(omega - 2e-3, omega + 2e-3))
        found = bifurcations(near, "fold")
        # the fold from which it began, and the other one
        found = found[np.argsort(np.abs(found - rotor.omega))[:2]]
        assert found[0] == pytest.approx(rotor.omega, abs=1e-10)
        aside.append(zeta - rotor.zeta)
        apart.append(abs(found[1] - found[0]))
    assert len(aside) >= 3
    power = np.polyfit(np.log(aside), np.log(apart), 1)[0]
    assert power == pytest.approx(1.5, abs=0.05)
