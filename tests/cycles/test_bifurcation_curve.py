"""Folds and doublings over two parameters: against branches, which know nothing of the curve."""

from dataclasses import replace

import numpy as np
import pytest

import rotor_ida
from rotor_ida import InputError, Rotor, bifurcation_curve, continue_cycle
from rotor_ida.schema import SPECIAL
from tests.cycles.known import (
    BOUNCING,
    FULL,
    LYING,
    REST,
    SPECIAL_POINTS,
    multipliers,
    once_round,
    specials,
    state_of,
)

AROUND = {"omega": (2.2, 3.1), "delta0": (0.45, 0.55)}
RUB = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)


def bifurcations(branch, kind):
    return specials(branch, kind)["special_value"].values


def rotor_of(point, rotor=BOUNCING.rotor):
    """The rotor at a point of a curve."""
    names = point.attrs["parameters"].split()
    return replace(rotor, **{name: float(point[name]) for name in names})


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


@pytest.fixture(scope="module")
def curves(fold, doubling):
    """A curve of each kind, with the rotor that it is of."""
    over = {"parameters": ("omega", "load"), "limits": ((1.1, 1.9), (0.8, 1.2)), "start": REST}
    return {
        "fold": (FULL.rotor, fold),
        "fold, zeta": (FULL.rotor, bifurcation_curve(
            FULL.rotor, start=FULL.state, kind="fold", parameters=("omega", "zeta"),
            limits={"omega": (2.2, 3.1), "zeta": (0.065, 0.075)},
        )),
        "doubling": (BOUNCING.rotor, doubling),
        "fold, load": (LYING, bifurcation_curve(LYING, kind="fold", **over)),
        "doubling, load": (LYING, bifurcation_curve(LYING, kind="period_doubling", **over)),
        "fold, friction": (RUB, bifurcation_curve(
            RUB, start=(3.0, 1.0, 0.0, 0.0), kind="fold", parameters=("omega", "friction"),
            limits=((1.2, 1.45), (0.09, 0.11)), points=8,
        )),
    }  # fmt: skip


@pytest.mark.parametrize(("name", "parameter", "parts"), [
    ("fold", "omega", (0.9,)), ("fold, zeta", "omega", (0.999,)),
    ("fold, load", "omega", (0.5,)), ("fold, friction", "omega", (0.99,)),
    ("doubling", "delta0", (0.2, 0.7)), ("doubling, load", "omega", (0.5,)),
])  # fmt: skip
def test_a_branch_bifurcates_where_the_curve_says(curves, name, parameter, parts):
    """From a point of the curve, over one parameter, with the other as it is there."""
    rotor, curve = curves[name]
    for part in parts:
        point = curve.isel(point=int(part * curve.sizes["point"]))
        there = rotor_of(point, rotor)
        value = getattr(there, parameter)
        branch = continue_cycle(
            there, start=point, parameter=parameter, limits=(0.98 * value, 1.02 * value)
        )
        apart = np.abs(bifurcations(branch, curve.attrs["kind"]) - value)
        assert apart.min() < 1e-9


@pytest.mark.parametrize("name", ["fold", "doubling", "fold, load", "doubling, load"])
def test_the_condition_holds_on_the_matrix_of_dop853(curves, name):
    """Another integrator's matrix, at points spread over the curve."""
    rotor, curve = curves[name]
    for place in np.linspace(0, curve.sizes["point"] - 1, 5).astype(int):
        point = curve.isel(point=place)
        there, period = rotor_of(point, rotor), point["period"].item()
        other = once_round(there, state_of(point), period)
        np.testing.assert_allclose(other.end, state_of(point), rtol=0.0, atol=1e-9)
        trace, q = np.trace(other.monodromy), np.exp(-2.0 * there.zeta * period)
        if there.load:
            value = 1.0 if curve.attrs["kind"] == "fold" else -1.0
            assert np.linalg.det(other.monodromy - value * np.eye(4)) == pytest.approx(0, abs=1e-6)
        else:
            expected = 2.0 * (1.0 + q) if curve.attrs["kind"] == "fold" else 0.0
            assert trace == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("name", "value"), [("fold, load", 1.0), ("doubling, load", -1.0)])
def test_a_curve_over_speed_and_load_comes_to_the_limits(curves, name, value):
    _, curve = curves[name]
    assert (curve["load"].values.min(), curve["load"].values.max()) == (0.8, 1.2)
    assert np.abs(multipliers(curve) - value).min(axis=1).max() < 1e-9


@pytest.mark.parametrize("parameter", ["shaft_stiffness", "contact_damping"])
def test_a_curve_of_doublings_comes_to_that_of_the_paper_s_rotor(parameter):
    rotor = Rotor(omega=1.85, zeta=0.07, delta0=2.0, **{parameter: 0.05})
    curve = bifurcation_curve(
        rotor, start=REST, kind="period_doubling",
        parameters=("omega", parameter), limits=((1.2, 3.0), (0.0, 0.2)),
    )  # fmt: skip
    end = curve.isel(point=int(np.argmin(curve[parameter].values)))
    assert end[parameter] == 0.0
    assert end.omega == pytest.approx(SPECIAL_POINTS[4].rotor.omega, abs=1e-9)
    assert np.abs(multipliers(curve) + 1.0).min(axis=1).max() < 1e-9


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
    assert other.attrs["closed"] == doubling.attrs["closed"] == 1
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


@pytest.mark.parametrize(("arguments", "says"), [
    ({"kind": "pitchfork"}, "kind must be"),
    ({"parameters": ("omega", "omega")}, "parameters must be two of 'omega', 'zeta', "),
    ({"parameters": ("omega",)}, "parameters must be two of 'omega', 'zeta', "),
    ({"limits": {"omega": (2.2, 3.2)}}, "limits must be of omega and delta0, got"),
    ({"limits": ((2.2, 3.2),)}, "limits must be two pairs of numbers"),
    ({"limits": ((0.0, 3.2), (0.4, 0.6))}, "limits of omega must be above 0"),
    ({"limits": ((2.2, 3.2), (0.6, 0.7))}, "limits of delta0 must contain that of the start, 0.5"),
    ({"limits": ((2.9, 3.1), (0.4, 0.6))},
     "limits must contain a fold of the branch through the start, got none"),
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


def test_limits_of_a_billion_numbers_are_refused_before_they_are_read():
    billion = np.broadcast_to(0.5, 1_000_000_000)
    for limits in (billion, np.broadcast_to(0.5, (2, 1_000_000_000)), range(1_000_000_000)):
        with pytest.raises(InputError, match="limits must be two pairs of numbers, got"):
            bifurcation_curve(FULL.rotor, start=FULL.state, kind="fold", limits=limits)
    named = {"omega": billion, "delta0": (0.4, 0.6)}
    with pytest.raises(InputError, match="limits must contain at most 10000000 numbers, got"):
        bifurcation_curve(FULL.rotor, start=FULL.state, kind="fold", limits=named)
