"""The summary of a run-up: facts against `run_ups`, and words for each ending."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rotor_ida import (
    Bearing,
    Contact,
    DimensionalRotor,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    run_up,
    run_ups,
    simulate,
    summary,
)
from rotor_ida.schema import words_of
from rotor_ida.units import SPEED_UNITS

REST = (0.0, 0.0, 0.0, 0.0)
# Each ending, with a rotor, a ramp and a start that lead to it.
ENDINGS = {
    "contact_free": (Rotor(omega=0.3, zeta=0.1, delta0=2.0, shaft_stiffness=1.0), 2.5, 0.01, REST),
    "rub": (Rotor(omega=0.5, zeta=0.07, delta0=0.8, shaft_stiffness=1.0), 1.2, 0.02, REST),
    "whip": (Rotor(omega=0.6, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0), 0.7, 0.01,
             (5.0, 0.0, 0.0, -6.0)),
}  # fmt: skip
SAME = (
    "largest_radius", "largest_radius_speed", "largest_force", "largest_force_speed",
    "first_touch_speed", "last_exit_speed", "contact_count", "contact_time",
)  # fmt: skip


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_summary_has_the_facts_and_the_ending_of_many_run_ups(ending):
    """`run_ups` reads them from the run inside, the summary from the dataset."""
    rotor, to, rate, start = ENDINGS[ending]
    run = run_up(rotor, start=start, to=to, rate=rate)
    found = summary(run)
    many = run_ups(**rotor.given, to=to, rate=rate, starts=[start], workers=1).squeeze(drop=True)
    for name in SAME:
        assert float(found[name]) == pytest.approx(float(many[name]), rel=1e-9, nan_ok=True), name
    assert words_of(found["ending"]) == words_of(many["ending"]) == [ending]
    assert int(found["response"]) == int(many["response"])
    assert float(found["first_touch_time"]) == np.nan_to_num(run["entry_time"]).min()
    assert float(found["smallest_gap"]) == rotor.delta0 - float(found["largest_radius"])


def test_the_words_say_how_it_ends():
    said = {}
    for ending, (rotor, to, rate, start) in ENDINGS.items():
        said[ending] = summary(run_up(rotor, start=start, to=to, rate=rate)).attrs["sentence"]
    assert said["contact_free"].startswith("Rub on the way, none at the end: it first touches")
    assert said["contact_free"].endswith("Held at a speed of 2.5 it runs clear of the stator.")
    assert said["rub"].startswith("Rub: it first touches the stator at a speed of 0.")
    assert "Held at a speed of 1.2 it keeps rubbing: " in said["rub"]
    assert said["whip"].startswith("Beyond the model: an indentation of ")
    assert "Dry whip: it first touches the stator at a speed of 0.6" in said["whip"]
    assert "The disc first rolls on the stator at a speed of 0.6" in said["whip"]
    assert "it stays in dry whip: it whirls backwards, rolling on the stator" in said["whip"]


def test_at_standstill_the_rotor_rests():
    """A run-down through a rub ends at rest in the middle, or under a load below it."""
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.8, shaft_stiffness=1.0)
    run = run_up(rotor, start=REST, to=0.0, rate=-0.02)
    early = run.assign(horizon=run["horizon"] * 0.0 + 1.0)
    said = summary(early).attrs["sentence"]
    assert "At standstill it rests clear of the stator." in said
    assert said.endswith(": what follows until it rests is one of many possible ones.")
    lying = run_up(replace(rotor, load=3.0, shaft_stiffness=0.5), to=0.0, rate=-0.02)
    assert summary(lying).attrs["sentence"].endswith("At standstill it rests on the stator.")
    system = run_up(rotor.system(), speed=1.2, to=0.0, rate=-0.02)
    said = summary(system).attrs["sentence"]
    assert said.endswith(
        "followed: no settled response of a rotor system is computed at standstill."
    )


def test_a_backward_whirl_that_slips_is_told():
    """A fan that never rolls: its slipping whirl is backward, at its natural frequency."""
    rotor = Rotor(
        omega=0.09, zeta=0.0027, delta0=10.0, shaft_stiffness=0.0184, contact_exponent=1.0,
        friction=0.15, disc_radius=2500.0,
    )  # fmt: skip
    run = run_up(rotor, to=0.17, rate=2e-5, method="taylor")
    backward = int((run.whirl_direction == -1).sum())
    assert 0 < backward < run.sizes["contact"]
    told = f"whirl backward, slipping, in {backward} of its {run.sizes['contact']} contacts."
    assert (
        f"the disc never rolls on the stator. But friction makes it {told}"
        in (summary(run).attrs["sentence"])
    )


PUMP = DimensionalRotor(
    mass=12.0, contact_stiffness=1e8, damping=415.7, eccentricity=6.6e-6, clearance=1.5e-4,
    speed=0.0, shaft_stiffness=4e6, contact_exponent=1.0, friction=0.12, disc_radius=0.06,
)  # fmt: skip


def test_a_pump_of_grade_2_5_does_not_rub():
    """At resonance e/(2 zeta sqrt(1 - zeta^2)) is 110 um of 150, and less on a ramp of 20 s."""
    found = summary(run_up(PUMP, to=6000.0 * SPEED_UNITS["rpm"], ramp_time=20.0))
    assert found.attrs["sentence"].startswith("No rub: closest to the stator at 5,")
    assert "of the clearance of 150 um are left. Held at 6,000 rpm it" in found.attrs["sentence"]
    zeta = PUMP.damping_ratio
    resonance = 6.6e-6 / (2.0 * zeta * math.sqrt(1.0 - zeta**2))
    assert 0.9 * resonance < float(found.largest_radius) < resonance
    assert found.largest_radius.attrs["units"] == "m"
    assert float(found.smallest_gap) == pytest.approx(1.5e-4 - float(found.largest_radius))
    assert float(found.largest_force) == 0.0
    assert math.isnan(float(found.first_touch_speed))


def test_an_indentation_that_no_contact_law_means_is_told():
    """Dry whip of the pump: 12 kg at the speed of the rim press millimetres into the ring."""
    whip = DimensionalRotor(**PUMP.given | {"speed": 300.0, "friction": 0.3})
    start = (0.0045, 0.0, 0.0, -300.0 * 0.06)
    said = summary(run_up(whip, start=start, to=310.0, ramp_time=0.05)).attrs["sentence"]
    assert "Beyond the model: an indentation of " in said
    assert "is more than a tenth of the rotor's radius and the clearance" in said
    assert "Beyond" not in summary(
        run_up(*[ENDINGS["rub"][0]], start=REST, to=1.2, rate=0.02)
    ).attrs["sentence"]  # fmt: skip


def test_a_summary_is_of_a_run_up_that_was_sampled_at_its_end():
    rotor, to, rate, start = ENDINGS["rub"]
    with pytest.raises(InputError, match=r"run must be sampled at its end 35, got .* at 10"):
        summary(run_up(rotor, start=start, to=to, rate=rate, samples=[0.0, 10.0]))
    with pytest.raises(InputError, match="run must be a run of run_up, whose speed changes"):
        summary(simulate(rotor, start=start, duration=10.0))


def test_a_system_has_the_summary_of_its_disc():
    """The other kernel: facts, verdict and sentence of one disc as a system, on every ending."""
    for rotor, to, rate, start in (ENDINGS["rub"], ENDINGS["contact_free"]):
        disc = summary(run_up(rotor, start=start, to=to, rate=rate))
        system = rotor.system()
        run = run_up(system, speed=rotor.omega, to=to, rate=rate, start=(start[:2], start[2:]))
        found = summary(run, running_speed=0.5 * float(disc.first_touch_speed))
        same = ("first_touch_speed", "first_touch_time", "largest_radius", "largest_force")
        for name in (*same, "contact_time"):
            assert float(found[name].squeeze()) == pytest.approx(float(disc[name]), rel=1e-6), name
        assert int(found.ending) == int(disc.ending)
        said, expected = found.attrs["sentence"], disc.attrs["sentence"]
        assert ", 100 % above the running speed, after a time of " in said
        assert said.replace(", 100 % above the running speed", "").replace(
            "contact 0 at 'disc'", "the stator"
        ) == expected  # fmt: skip


def test_the_sentence_says_where_a_system_is_touched_and_what_rounding_decides():
    """Two contacts, the nearer first; the horizon is put before the end of the run."""
    rotor = ENDINGS["rub"][0]
    system = rotor.system()
    gaps = [
        replace(system.contacts[0], clearance=each) for each in (rotor.delta0 * 1.1, rotor.delta0)
    ]
    two = replace(system, contacts=gaps)
    run = run_up(two, speed=rotor.omega, to=ENDINGS["rub"][1], rate=ENDINGS["rub"][2])
    said = summary(run).attrs["sentence"]
    touch = float(run.entry_time.min())
    assert f", after a time of {touch:.3g}, and presses up to" in said
    assert said.startswith("Rub: it first touches contact 1 at 'disc' at a speed of ")
    assert "It also touches contact 0 at 'disc', first at a speed of " in said
    assert "rounding" not in said
    early = run.assign(horizon=run["horizon"] * 0.0 + 1.0)
    assert "After 1 of " in summary(early).attrs["sentence"]
    assert "how it ends, is one of many possible ones." in summary(early).attrs["sentence"]


def test_a_whirl_that_excites_itself_is_told_first_with_its_threshold():
    # (s**2 + c s + k)**2 + q**2 = 0 has s = i sqrt(k) at q = c sqrt(k)
    cross = np.array([[0.0, 1.0], [-1.0, 0.0]])
    film = Bearing(node="disc", speed=(0.0, 10.0), stiffness=[0.0 * cross, 10.0 * cross],
                   damping=[0.2 * np.eye(2)] * 2)  # fmt: skip
    system = RotorSystem(
        mass=np.eye(2), stiffness=4.0 * np.eye(2), nodes={"disc": (0, 1)}, bearings=[film],
        contacts=[Contact(node="disc", clearance=3.0, stiffness=10.0, exponent=1.0)],
        unbalance=[Unbalance(node="disc", moment=0.1)], units="1",
    )  # fmt: skip
    with pytest.warns(UserWarning, match="the linear system is unstable from 0.4 on"):
        run = run_up(system, speed=0.1, to=0.5, rate=0.1, start="settled")
    assert run.attrs["growth_begins_at"] == pytest.approx(0.4, rel=1e-5)
    said = summary(run).attrs["sentence"]
    assert said.startswith(
        "Self-excited whirl beyond the threshold of instability at a speed of 0.4"
    )
    assert "No rub on the way: closest to contact 0 at 'disc'" in said
    assert "Held at a speed of 0.5 it touches at last, and keeps rubbing" in said
    calm = summary(run_up(system, speed=0.1, to=0.3, rate=0.1, start="settled")).attrs["sentence"]
    assert calm.startswith("No rub: closest")


def test_a_system_without_contacts_is_said_to_vibrate():
    """The unbalance response at rest at the last speed: m e w**2 / |k - w**2 m + i w c|."""
    system = RotorSystem(
        mass=np.eye(2), stiffness=np.eye(2), damping=0.5 * np.eye(2), nodes={"disc": (0, 1)},
        unbalance=[Unbalance(node="disc", moment=0.1)], units="1",
    )  # fmt: skip
    run = run_up(system, speed=2.0, to=3.0, rate=0.01, start="settled")
    last = 0.1 * 9.0 / abs(1.0 - 9.0 + 1.5j)
    found = summary(run)
    assert found.attrs["sentence"].startswith("The system has no contacts. Of the samples ")
    said = found.attrs["sentence"].removesuffix(" there.").split()[-1]
    assert float(said) == pytest.approx(last, rel=5e-3)
    assert "had not settled" not in found.attrs["sentence"]
