"""The response curve, what is settled on and its branch are those of the library."""

from __future__ import annotations

import functools

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida.closed_forms.response_curve import response_curve
from rotor_ida.cycles.branches import branches_through
from rotor_ida.explorer import responses
from rotor_ida.explorer.messages import Question
from rotor_ida.schema import EXACT, RESPONSE, SPECIAL
from tests.explorer.asking import (
    BEYOND,
    MACHINE,
    ROTOR,
    RUB,
    SLOW,
    WHIP,
    WHIPPED,
    Message,
    answer_to,
    first_part,
    question,
)

BOUNCING = question("responses", start=[2.6, 0.75, 0.66, -1.65])
WHIRL = question("responses", machine={"omega": 1.7, "zeta": 0.07, "delta0": 0.5})
CHAOS = question("responses", machine=SLOW, start=[1.5, -0.25, 0.0, 0.0])
FREE = question("responses", machine={"omega": 0.5, "zeta": 0.07, "delta0": 3.0})
# Machines: a cycle with contact damping, the contact-free whirl that a shaft holds, a load.
DAMPED = question("responses", machine=ROTOR | BEYOND | {"contact_damping": 0.5, "load": 0.0})
HELD = question("responses", machine=ROTOR | {"shaft_stiffness": 0.25, "delta0": 6.0})
UNSTEADY = question(
    "responses", machine={"omega": 1.2, "zeta": 0.07, "delta0": 0.5, "contact_damping": 0.5}
)
LOADED = question("responses", machine=ROTOR | BEYOND)
ALL = {"bouncing": BOUNCING, "whirl": WHIRL, "chaos": CHAOS, "contact-free": FREE,
       "damped": DAMPED, "held": HELD}  # fmt: skip


@pytest.fixture(autouse=True)
def no_branches_yet() -> None:
    responses.branches_of.cache_clear()


@pytest.fixture(scope="module", params=ALL)
def asking(request: pytest.FixtureRequest) -> Question:
    return ALL[request.param]


@functools.cache
def first_answer(name: str) -> list[Message]:
    """Return the parts of one of these answers, of which no branch was known."""
    responses.branches_of.cache_clear()
    return answer_to(ALL[name])


@pytest.fixture
def parts(asking: Question) -> dict[str, Message]:
    (name,) = (each for each in ALL if ALL[each] is asking)
    return {message.part: message for message in first_answer(name)}


def swept(asking: Question) -> xr.Dataset:
    return rotor_ida.sweep(asking.rotor, starts=[asking.start], method="taylor", executor="serial")


def test_what_is_settled_on_is_what_sweep_and_compare_say(
    asking: Question, parts: dict[str, Message]
):
    facts, sweep = parts["settled"].facts, swept(asking)
    compared = rotor_ida.compare(sweep)
    sweep, compared = (each.squeeze(("omega", "zeta", "delta0", "start", "direction"))
                       for each in (sweep, compared))  # fmt: skip
    assert RESPONSE[facts["response"]] == int(sweep["response"])
    assert EXACT[facts["lies_on"]] == int(compared["lies_on"])
    names = ("amplitude", "phase_lag", "radius_min", "radius_max", "period", "lyapunov_exponent")
    for name in names:
        value = float(sweep[name])
        assert facts[name] == (None if np.isnan(value) else value)
    digits = float(compared["digits"])
    assert facts["digits"] == (None if np.isnan(digits) else digits)
    assert facts["end"] == [float(sweep[f"end_{name}"]) for name in ("x", "y", "vx", "vy")]


def test_the_section_is_that_of_the_library_bit_for_bit(
    asking: Question, parts: dict[str, Message]
):
    facts, arrays = parts["settled"].facts, parts["section"].arrays
    found = rotor_ida.poincare_section(
        asking.rotor, start=facts["end"], method="taylor",
        revolutions=4096 if facts["response"] == "chaotic" else 256,
    )  # fmt: skip
    np.testing.assert_array_equal(arrays["section_x"], found["rotating_x"].values)
    np.testing.assert_array_equal(arrays["section_y"], found["rotating_y"].values)


def test_each_kind_of_response_is_met():
    last = {name: first_answer(name)[-1].part for name in ALL}
    assert {name for name, part in last.items() if part == "branch"} == {"bouncing", "damped"}


def test_the_branch_is_the_library_s_bit_for_bit():
    arrays = first_answer("bouncing")[-1].arrays
    compared = rotor_ida.compare(swept(BOUNCING))
    (branch,) = branches_through(compared, limits=(0.05, 3.0), points=2000)
    for name in ("omega", "radius_min", "radius_max", "stability"):
        np.testing.assert_array_equal(arrays[name], branch[name].values, err_msg=name)
    for name, each in {"special_omega": "special_value", "special_kind": "special_kind",
                       "special_point": "special_point"}.items():  # fmt: skip
        np.testing.assert_array_equal(arrays[name], branch[each].values, err_msg=name)
    assert arrays["omega"].min() < 2.0 < arrays["omega"].max()


def test_the_branch_bifurcates_where_that_of_continue_cycle_does():
    arrays = first_answer("bouncing")[-1].arrays
    followed = rotor_ida.continue_cycle(BOUNCING.rotor, start=BOUNCING.start, limits=(0.05, 3.0))
    np.testing.assert_array_equal(arrays["special_kind"], followed["special_kind"].values)
    # Newton's method finds them to a residual of some 1e-13 from whatever points it comes
    np.testing.assert_allclose(arrays["special_omega"], followed["special_value"].values, rtol=1e-9)


def test_a_branch_that_is_known_comes_before_the_simulation_and_once():
    first = [each.part for each in answer_to(BOUNCING)]
    again = [each.part for each in answer_to(BOUNCING)]
    assert first == ["curve", "settled", "section", "branch"]
    assert again == ["curve", "branch", "settled", "section"]


def test_a_machine_has_the_answer_of_its_rotor():
    plain, in_si = (
        answer_to(question("responses", machine=machine)) for machine in (ROTOR, MACHINE)
    )
    plain, in_si = ({each.part: each for each in some} for some in (plain, in_si))
    assert plain.keys() == in_si.keys()
    for part, message in plain.items():
        for name, values in message.arrays.items():
            np.testing.assert_array_equal(in_si[part].arrays[name], values, err_msg=name)
    told = plain["settled"].facts
    for name in told.keys() - {"scales", "words", "sheets", "verdict"}:
        assert in_si["settled"].facts[name] == told[name]
    (sheet,) = in_si["settled"].facts["sheets"]
    assert ["largest radius", f"{told['radius_max']:.4g}", "µm"] in sheet["rows"]


CURVES = ALL | {"unsteady": UNSTEADY}


@pytest.mark.parametrize("name", CURVES)
def test_curve_folds_and_hopf_points_are_the_closed_forms(name: str):
    asking = CURVES[name]
    curve = first_part(asking)
    given = {name: value for name, value in asking.rotor.given.items() if name != "omega"}
    exact = response_curve(**given, limits=(0.05, 3.0), points=responses.POINTS_OF_CURVE)
    for each in ("omega", "amplitude", "phase_lag", "piece", "stability", "in_contact"):
        np.testing.assert_array_equal(curve.arrays[each], exact[each].values.ravel(), err_msg=each)
    folds, hopf = rotor_ida.folds(**given), rotor_ida.hopf_points(**given)
    for each in responses.FOLD:
        turns = folds[each].values.ravel()
        np.testing.assert_array_equal(curve.arrays[each], turns[np.isfinite(turns)], err_msg=each)
    for each in responses.HOPF:
        shown = hopf[each].values[hopf["hopf_omega"] <= 3.0]
        np.testing.assert_array_equal(curve.arrays[each], shown, err_msg=each)
    assert curve.arrays["hopf_omega"].size == (1 if asking is UNSTEADY else 0)
    assert "why" not in curve.facts


def test_a_contact_that_never_ends_loses_what_the_unbalance_gives_beyond_damping():
    """Over whole periods of the cycle the energy comes again."""
    asking = question(
        "responses", start=[3.0, 1.0, 0.0, 0.0],
        machine={"omega": 3.0, "zeta": 0.07, "delta0": 0.5, "contact_damping": 0.1},
    )  # fmt: skip
    answers = responses.show_responses(asking)
    told = next(each for each in answers if each.part == "settled").facts
    assert told["response"] == "full_contact"
    rotor, end = asking.rotor, told["end"]
    cycle = rotor_ida.limit_cycle(rotor, start=end)
    run = rotor_ida.simulate(
        rotor, start=end, duration=8.0 * cycle.period.item(), samples=3201, method="taylor"
    )
    pulled = np.cos(rotor.omega * run.t) * run.vx + np.sin(rotor.omega * run.t) * run.vy
    power = rotor.omega**2 * pulled - 2.0 * rotor.zeta * (run.vx**2 + run.vy**2)
    lost = power.integrate("t").item() / run.t[-1].item() * 2.0 * np.pi / rotor.omega
    assert told["loss_per_revolution"] == pytest.approx(lost, rel=1e-9)
    assert ["loss of contacts a revolution", "0.8402", ""] in told["sheets"][0]["rows"]


def test_under_a_load_the_curve_ends_at_the_touch_and_the_motion_repeats_after_revolutions():
    parts = {message.part: message for message in answer_to(LOADED)}
    curve, facts = parts["curve"], parts["settled"].facts
    assert curve.facts["why"].startswith("Under a load no whirl in contact is synchronous: ")
    assert "limit_cycle" in curve.facts["why"]
    rotor, radius = LOADED.rotor, curve.arrays["amplitude"]
    lies = rotor.load >= rotor.shaft_stiffness * rotor.delta0
    assert lies == (radius.size == 0)
    assert lies or np.nanmax(radius) == pytest.approx(rotor.delta0, rel=1e-12)
    turns = facts["period"] * LOADED.rotor.omega / (2.0 * np.pi)
    assert turns == pytest.approx(round(turns), abs=1e-9)
    x = parts["section"].arrays["section_x"]
    np.testing.assert_allclose(x[round(turns) :], x[: -round(turns)], atol=1e-6)


def test_where_no_curve_can_be_drawn_the_reason_is_in_its_place():
    machine = ROTOR | {"zeta": 0.0, "contact_exponent": 1.0}
    (curve,) = answer_to(question("responses", machine=machine))
    assert curve.facts["why"].startswith("No exact curve: zeta must be positive for the curve of a")
    assert not curve.arrays["omega"].size


@pytest.mark.parametrize("omega", [0.0, 2.0])
def test_without_damping_nothing_settles_and_there_is_the_curve_alone(omega: float):
    machine = {"omega": omega, "zeta": 0.0, "delta0": 2.0}
    (curve,) = answer_to(question("responses", machine=machine))
    assert curve.part == "curve"


def test_without_spin_the_rotor_comes_to_rest():
    asking = question(
        "responses", machine={"omega": 0.0, "zeta": 0.07, "delta0": 2.0}, start=[5, 0, 1, 0]
    )
    _, settled = answer_to(asking)
    resting = float(swept(asking)["radius_max"].item())
    assert settled.facts["radius_min"] == settled.facts["radius_max"] == resting
    assert settled.facts["words"] == ["It comes to rest inside the clearance."]
    assert settled.facts["verdict"].startswith(f"No contact: radius {resting:.4g}, gap ")


def test_a_run_that_ends_before_the_rotor_has_settled_is_told_to():
    slow = question(
        "responses", machine={"omega": 3.0, "zeta": 0.001, "delta0": 2.0}, start=[2.5, 0, 0, 3]
    )
    (facts,) = (each.facts for each in answer_to(slow) if each.part == "settled")
    settled = float(swept(slow)["window_start"].item())
    assert settled > 10_000.0
    assert f"had settled at t = {settled:.0f}" in facts["words"][-1]
    assert "ends at t = 125.7 (60 revolutions)" in facts["words"][-1]


def test_a_run_that_fails_is_told_of_and_not_looked_at_further(monkeypatch: pytest.MonkeyPatch):
    def fail(rotor: rotor_ida.Rotor, **given: object) -> object:
        found = rotor_ida.sweep(rotor, **given)
        lost = {name: found[name] * np.nan for name in found if str(name).startswith("end_")}
        said = found["message"].copy(data=np.full(found["message"].shape, "too much work"))
        return found.assign(
            **lost, response=found["response"] * 0 + RESPONSE["failed"], message=said
        )

    monkeypatch.setattr(responses, "sweep", fail)
    parts = answer_to(question("responses"))
    assert [each.part for each in parts if each.part != "branch"] == ["curve", "settled"]
    assert "too much work" in " ".join(parts[-1].facts["words"])


@pytest.mark.parametrize("omega", [1e-6, 1e6])
def test_a_speed_at_which_nothing_can_settle_is_said_in_one_line(omega: float):
    curve, trouble = answer_to(question("responses", machine=ROTOR | {"omega": omega}))
    assert (curve.part, trouble.part) == ("curve", "trouble")
    assert "omega must be 0 or from 0.001 to 1000 to settle" in trouble.facts["message"]


@pytest.mark.parametrize("delta0", [0.0, 1e-6, 1e6])
@pytest.mark.parametrize("speeds", [[0.0, 1e6], [0.0, 1e-6], [1e-6, 1e-3], [1.0, 1.0000001]])
def test_every_range_of_speeds_has_a_curve(delta0: float, speeds: list[float]):
    machine = {"omega": 0.0, "zeta": 0.07, "delta0": delta0}
    curve, settled = answer_to(question("responses", machine=machine, speeds=speeds))
    assert (curve.part, settled.part) == ("curve", "settled")
    assert np.isfinite(curve.arrays["omega"]).any()


WHIPS = question("responses", machine=WHIP, start=WHIPPED)
RUBS = question("responses", machine={"omega": 1.2, "zeta": 0.07, "delta0": 0.5, **RUB})


def test_with_friction_the_curve_comes_first_and_its_hopf_points_later():
    parts = answer_to(RUBS, 4)
    assert [each.part for each in parts] == ["curve", "settled", "curve", "section"]
    first, whole = (each.arrays for each in parts if each.part == "curve")
    of_whirls = {"zeta": 0.07, "delta0": 0.5, "friction": RUB["friction"]}
    curve = response_curve(**of_whirls, limits=(0.05, 3.0), points=responses.POINTS_OF_CURVE)
    for name in ("omega", "amplitude", "piece", "stability", "in_contact"):
        np.testing.assert_array_equal(first[name], curve[name].values.ravel(), err_msg=name)
        np.testing.assert_array_equal(whole[name], first[name])
    exact = rotor_ida.hopf_points(**of_whirls)
    assert not first["hopf_omega"].size
    for name in ("hopf_omega", "hopf_amplitude"):
        np.testing.assert_array_equal(whole[name], exact[name].values.ravel())


@pytest.mark.parametrize("speeds", [(0.05, 0.2), (0.05, 3.0)])
def test_the_backward_whirls_are_drawn_from_their_birth_on(speeds: tuple[float, float]):
    asking = question("responses", machine=WHIP, start=WHIPPED, speeds=list(speeds))
    arrays = first_part(asking).arrays
    omega, birth = arrays["whip_omega"], 0.314789904
    if speeds[1] < birth:
        assert omega.size == arrays["whip_radius"].size == arrays["saddle_radius"].size == 0
        return
    assert omega[0] == pytest.approx(max(speeds[0], birth), rel=1e-8)
    assert omega[-1] == speeds[1]
    # r f + kappa r**2 = (rho omega)**2, and f/r = Omega**2 with Omega = -2 zeta/mu
    whip, saddle = arrays["whip_radius"], arrays["saddle_radius"]
    rim = WHIP["disc_radius"] * omega
    np.testing.assert_allclose(whip * (whip - WHIP["delta0"]) ** 1.5, rim**2, rtol=1e-9)
    np.testing.assert_allclose((saddle - WHIP["delta0"]) ** 1.5 / saddle, 1.0, rtol=1e-9)


def test_dry_whip_is_settled_on_and_told_of():
    parts = {each.part: each for each in answer_to(WHIPS)}
    facts = parts["settled"].facts
    assert (facts["response"], facts["lies_on"]) == ("rolling", "cycle")
    branch = parts["branch"].arrays
    assert np.isin(branch["special_kind"], list(SPECIAL.values())).all()
    place = np.abs(branch["omega"] - WHIPS.rotor.omega).argmin()
    assert abs(branch["radius_max"][place] - facts["radius_max"]) < 0.1
    assert facts["words"][0].startswith("It settles on dry whip")
    assert 0.6 < facts["rolling_fraction"] < 0.7
    assert "a radius of 4.984, and a backward whirl beyond 3.148" in facts["words"][-1]
    x = parts["section"].arrays["section_x"]
    assert x.size == responses.CROSSINGS + 1
    radius = np.hypot(x, parts["section"].arrays["section_y"])
    assert facts["radius_min"] - 1e-6 < radius.min() < radius.max() < facts["radius_max"] + 1e-6


def test_under_a_load_there_is_no_whip_of_a_known_radius():
    parts = responses.show_responses(question("responses", machine=ROTOR | BEYOND | RUB))
    curve, settled = next(parts), next(parts)
    assert "whip_omega" not in curve.arrays
    assert not any("dry whip" in each for each in settled.facts["words"])
