"""A run can be made again from its own attributes, also after it has been in an archive."""

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    dimensional,
    load,
    save,
    simulate,
    sweep,
)
from rotor_ida.testing import assert_events_close
from rotor_ida.verification import rerun

ROTOR = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.mark.parametrize(("method", "flight"), [("adams", "exact"), ("bdf", "cvode")])
def test_a_run_is_made_again_to_the_bit(tmp_path, method, flight):
    run = simulate(
        ROTOR, start=(0.1, 0, 0, 0), duration=30.0, samples=7, method=method, flight=flight
    )
    again = rerun(load(save(run, tmp_path / "run.nc")))
    assert (again.event_time.values == run.event_time.values).all()
    assert (again.x.values == run.x.values).all()
    assert_events_close(again, run)


def test_an_archive_that_was_tampered_with_does_not_verify():
    run = simulate(ROTOR, start=(0, 0, 0, 0), duration=30.0)
    forged = run.assign(event_time=run.event_time + np.where(run.event_time > 10.0, 1e-6, 0.0))
    with pytest.raises(AssertionError, match="First difference: event 5, exit"):
        assert_events_close(rerun(forged), forged)


def test_only_runs_can_be_verified():
    with pytest.raises(InputError, match="only a simulated run can be verified; it lacks omega"):
        rerun(sweep(omega=1.0, zeta=0.5, delta0=0.5))


def test_run_in_si_units_is_refused():
    machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                               clearance=2e-6, speed=600.0)  # fmt: skip
    run = simulate(machine.rotor(), start=(0, 0, 0, 0), duration=5.0)
    with pytest.raises(InputError, match="a run in SI units cannot be verified"):
        rerun(dimensional(run, machine))
