"""The dataset of a run is kept with all that it says of its rotor."""

import pytest

import rotor_ida
from rotor_ida import Rotor, simulate
from rotor_ida.results.checked_run import rotor_of

PLAIN = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}
ROTORS = [
    Rotor(**PLAIN),
    Rotor(**PLAIN, shaft_stiffness=0.25, contact_exponent=1.0, contact_damping=0.5, load=0.125),
    Rotor(**PLAIN, friction=0.3, disc_radius=0.6),
]


@pytest.mark.parametrize("rotor", ROTORS, ids=str)
def test_a_run_that_is_kept_has_its_rotor_and_its_events(rotor, tmp_path):
    run = simulate(rotor, start=(0.3, 0.1, 0.2, 0.1), duration=20.0, samples=101)
    kept = rotor_ida.load(rotor_ida.save(run, tmp_path / "run.nc"))
    for name in run.variables:
        assert kept[name].equals(run[name]), name
    assert rotor_of(kept) == rotor
    assert rotor_ida.contact_summary(kept).contact_count == kept.contact.size
    if rotor.friction:
        assert {2, -2, 3} <= set(kept.event_kind.values.tolist())
        assert kept.event_kind.attrs["flag_meanings"] == "exit entry roll slip reverse"
