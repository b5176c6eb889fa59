"""Reports and atlases of rotor systems: those of one disc by the other kernel; shocks that hold."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    Rotor,
    basin_fractions,
    continue_attractors,
    decode_flags,
    simulate,
    synchronous_response,
    touchdown_report,
)
from rotor_ida.basins.atlas import resilience
from rotor_ida.basins.atlas.shocks import KINDS, Effort
from rotor_ida.closed_forms import touch_fading
from rotor_ida.core.runs import NO_STOP
from rotor_ida.model.assembly import assemble
from rotor_ida.simulation.system_flow import SettlingProblem, SystemFlow
from tests.basins.lanes import WHIP
from tests.basins.test_system_basins import SPEED, SYSTEM

RUB = Rotor(omega=0.7, zeta=0.1, delta0=1.5, shaft_stiffness=0.1)
BOX = {"x": (-3.0, 3.0), "y": (-3.0, 3.0)}
NEAR = {"node": "b", "start": "settled", "x": (-0.45, -0.05), "y": (-0.3, 0.3)}
OF_ONE = (
    "largest_force", "mean_force", "contacts_per_revolution", "contact_fraction", "excursion",
    "dissipation_per_revolution", "whirl_over_spin", "whirl_sense", "side_line_over_spin",
)  # fmt: skip
RUBS = ("heat_per_revolution", "slip_distance_per_revolution", "rolling_fraction")


FEW = Effort(rounds=6, least=4, leading=2, neighbours=4, turns=8)


def as_system(rotor, **given):
    return touchdown_report(rotor.system(), speed=rotor.omega, node="disc", **given)


@pytest.fixture(scope="module")
def two_nodes():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(resilience.SystemSearch, "effort", FEW)
        return touchdown_report(SYSTEM, speed=SPEED, **NEAR, starts=8, shocks=16, workers=2)


def test_shocks_of_one_disc_are_found_as_a_system_too():
    """With 16 shocks for 4096: none is smaller, and the error that it states holds."""
    one = touchdown_report(RUB, **BOX, starts=10)
    many = as_system(RUB, **BOX, starts=10, shocks=16, workers=2)
    assert decode_flags(many.kind).values.tolist() == ["synchronous", "contact_free"]
    np.testing.assert_array_equal(many.fraction, one.fraction)
    for kind in KINDS:
        size, true = (float(each[f"{kind}_shock"][1, 0]) for each in (many, one))
        scatter = float(many[f"{kind}_shock_scatter"][1, 0])
        assert true * (1.0 - 1e-4) <= size <= true * (1.0 + max(3.0 * scatter, 0.02))
    largest = (float(each.displacement_shock_largest) for each in (many, one))
    assert next(largest) == pytest.approx(next(largest), rel=1e-9)
    assert "velocity_shock_bound" not in many  # there are no trapping regions


@pytest.mark.parametrize(
    ("rotor", "box"),
    [
        (Rotor(omega=2.0, zeta=0.07, delta0=2.0), {"x": (-4, 4), "y": (-4, 4)}),
        (Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.1), BOX),
        (WHIP, {"x": (-6, 6), "vy": (-6, 6), "vx": 0.5}),
        (Rotor(omega=1.7, zeta=0.1, delta0=1.0, shaft_stiffness=0.4, load=0.3), BOX),
    ],
)
def test_forces_losses_and_whirl_are_those_of_one_disc(rotor, box):
    one = touchdown_report(rotor, **box, starts=24, shocks=0)
    many = as_system(rotor, **box, starts=24, shocks=0, workers=2)
    kinds = decode_flags(one.kind).values.tolist()
    names = [*OF_ONE, *(RUBS if rotor.friction > 0.0 else ()),
             *(["contact_loss_per_revolution"] if rotor.contact_damping > 0.0 else ())]  # fmt: skip
    for number, kind in enumerate(decode_flags(many.kind).values.tolist()):
        own = one.isel(attractor=kinds.index(kind))
        each = many.isel(attractor=number)
        assert float(each.fraction) == float(own.fraction)
        # a motion without a period is a mean over many revolutions, from another state
        rough = 0.05 if kind == "rolling" and math.isnan(float(own.period)) else 2e-6
        if kind == "touching":  # of touches that have not quite faded
            rough = 1e-5
        for name in names:
            if name == "excursion" and kind == "contact_free":
                continue  # depends on the start
            value = each[name].values.item()
            assert value == pytest.approx(float(own[name]), rel=rough, abs=1e-9,
                                          nan_ok=True), (kind, name)  # fmt: skip


def test_touches_that_fade_are_told_by_the_law_of_one_disc():
    """The limit that each states is the whirl that just reaches the stator."""
    rotor, touching = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_damping=0.1), 5
    one = basin_fractions(rotor, **BOX, starts=24)
    many = basin_fractions(rotor.system(), speed=2.0, node="disc", **BOX, starts=24)
    assert float(one.response_count.sel(response=touching)) > 0.0
    assert many.response_count.sel(response=touching) == one.response_count.sel(response=touching)
    assert int(many.undecided_count) == 0
    limit, own = (each.isel(attractor=int(np.argmax(each.kind.values == touching)))
                  for each in (many, one))  # fmt: skip
    for name in ("radius_min", "radius_max", "amplitude"):
        assert float(limit[name][0]) == pytest.approx(float(own[name]), abs=1e-5)
    assert float(limit.largest_force[0]) == 0.0


@pytest.mark.parametrize("exponent", [1.0, 1.5])
def test_the_law_of_fading_touches_of_a_system_is_the_closed_form(exponent):
    """Of one disc, by the mobility of its free motion; a shaft leaves no free motion."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, contact_exponent=exponent)
    flow = SystemFlow.at(SettlingProblem.of(assemble(rotor.system()), 1e-10), 2.0, NO_STOP)
    amplitude = 2.0 / math.hypot(2.0, 0.14)
    assert flow.touch_fading(0, amplitude) == pytest.approx(touch_fading(rotor), rel=1e-13)
    held = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.1).system()
    flow = SystemFlow.at(SettlingProblem.of(assemble(held), 1e-10), 2.0, NO_STOP)
    assert math.isnan(flow.touch_fading(0, amplitude))


@pytest.mark.parametrize("kind", KINDS)
def test_a_shock_leads_from_one_motion_to_the_other_and_a_smaller_one_does_not(two_nodes, kind):
    """By runs from the states that the report gives: the rub is reached, or the seal is left."""
    assert decode_flags(two_nodes.kind).values.tolist() == ["synchronous", "contact_free"]
    before, after = (two_nodes[f"{kind}_shock_{when}"].values[1, 0] for when in ("before", "after"))
    assert np.isfinite(after).all()
    size = float(two_nodes[f"{kind}_shock"][1, 0])
    moved = (after - before).reshape(2, 4)[KINDS[kind] // 2, 2:]  # of node b
    assert np.hypot(*moved) == pytest.approx(size, rel=1e-9)
    for part, touches in ((1.0, True), (0.9, False)):
        state = (before + part * (after - before)).reshape(2, 4)
        run = simulate(SYSTEM, speed=SPEED, start=(state[0], state[1]), duration=400.0)
        assert bool((run.normal_force[-50:] > 0.0).any()) == touches


def test_an_atlas_of_one_disc_is_that_of_the_system():
    """The same starts, by the other kernel."""
    given = {**BOX, "starts": 6, "seed": 1}
    one = continue_attractors(RUB, omega=[0.7, 0.8, 0.9], **given).squeeze()
    asked = {**given, "speed": [0.7, 0.8, 0.9], "node": "disc", "workers": 2}
    many = continue_attractors(RUB.system(), **asked)
    np.testing.assert_array_equal(many["count"], one["count"])
    np.testing.assert_array_equal(many.kind, one.kind)
    for name in ("amplitude", "phase_lag"):
        np.testing.assert_allclose(many[name].isel(contact=0), one[name], rtol=1e-7)


def test_an_attractor_that_no_start_hits_is_found_from_its_neighbour():
    """With more damping no start ends on the rub, which exists there: it is the exact whirl."""
    found = continue_attractors(
        SYSTEM, speed=SPEED, damping=[1.0, 1.3], **NEAR, starts=6, seed=2, workers=2
    ).squeeze()
    assert found.fraction.dims == ("damping", "attractor")
    assert found["count"].values.tolist() == [[3, 3], [6, 0]]
    assert decode_flags(found.kind).values.tolist() == [["contact_free", "synchronous"]] * 2
    exact = synchronous_response(replace(SYSTEM, damping=1.3 * SYSTEM.damping), speed=SPEED)
    rubs = exact.amplitude.values[(exact.in_contact == 1) & (exact.stability == 1)]
    np.testing.assert_allclose(found.amplitude[1, 1], rubs, rtol=1e-8)
    assert found.damping.attrs["long_name"].startswith("factor of the damping")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"node": "c"}, "node must be one of 'a', 'b', got 'c'"),
        ({"speed": 0.0}, "speed must not be 0 for a basin of a rotor system"),
        ({"shocks": -1}, "shocks must be at least 0"),
        ({"contacts": []}, "contacts must be at least one for a basin"),
        ({"x": 0.0, "y": 0.0}, "must be a range, got numbers for 8 starts"),
    ],
)
def test_what_cannot_be_asked_is_refused_in_one_line(changes, words):
    for verb in (touchdown_report, continue_attractors):
        given = {"speed": SPEED, **NEAR, "starts": 8, "shocks": 0, **changes}
        with pytest.raises(InputError, match=words):
            verb(SYSTEM, **given)
    with pytest.raises(InputError, match="node must be left out with one disc"):
        touchdown_report(RUB, **BOX, node="disc")
