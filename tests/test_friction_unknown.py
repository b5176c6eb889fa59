"""What does not know friction yet refuses it in one line: nothing is computed as if it were 0."""

from __future__ import annotations

import pytest

import rotor_ida
from rotor_ida import InputError, Rotor, simulate
from rotor_ida.results.run import rotor_of

RUBBING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)


def test_friction_is_refused_where_it_is_not_known():
    """Held by friction a rotor that does not turn may lie anywhere in a range."""
    with pytest.raises(
        InputError, match=r"^friction must be 0 for rest, which does not know it yet"
    ):
        rotor_ida.rest(RUBBING)


def test_a_run_with_friction_is_kept_verified_and_summed_up(tmp_path):
    run = simulate(RUBBING, start=(0.3, 0.1, 0.2, 0.1), duration=20.0, samples=101)
    path = tmp_path / "run.nc"
    rotor_ida.save(run, path)
    kept = rotor_ida.load(path)
    for name in run.variables:
        assert kept[name].equals(run[name]), name
    assert rotor_of(kept) == RUBBING
    assert {2, -2, 3} <= set(kept.event_kind.values.tolist())
    assert kept.event_kind.attrs["flag_meanings"] == "exit entry roll slip reverse"
    assert rotor_ida.contact_summary(kept).contact_count == kept.contact.size
