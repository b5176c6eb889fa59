"""A run says which rotor it is of: the paper's, or one with more, and is read as that one."""

import pytest
import xarray as xr

from rotor_ida import InputError, Rotor, rotating, simulate
from rotor_ida.model.parameters import FRICTIONLESS
from rotor_ida.results.checked_run import check_run, rotor_of
from rotor_ida.schema import DAMPED_EVENT_KIND, EVENT_KIND, QUANTITIES, flags_of

REST = (0.0, 0.0, 0.0, 0.0)
PLAIN = Rotor(omega=1.2, zeta=0.07, delta0=0.5)
WHOLE = Rotor(omega=1.2, zeta=0.07, delta0=0.5, shaft_stiffness=0.25, contact_exponent=1.0,
              contact_damping=0.5, load=0.125)  # fmt: skip


def run_of(rotor: Rotor) -> xr.Dataset:
    return simulate(rotor, start=REST, duration=10.0, samples=41)


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    return run_of(WHOLE)


def test_a_run_of_the_papers_rotor_has_no_more_than_its_three_parameters():
    run = run_of(PLAIN)
    assert set(run.coords) == {"omega", "zeta", "delta0", "t"}
    assert not set(FRICTIONLESS) & (set(run.variables) | set(run.attrs))
    assert flags_of(run["event_kind"]) == EVENT_KIND == {"exit": -1, "entry": 1}
    assert run["event_time"].attrs["long_name"] == "time of contact entry or exit"


def test_what_is_beyond_the_papers_rotor_is_told(whole: xr.Dataset):
    for name, value in WHOLE.beyond.items():
        assert whole.coords[name].ndim == 0
        assert whole[name].item() == whole.attrs[name] == value
        assert whole[name].attrs == QUANTITIES[name].attributes()
    assert rotor_of(whole) == WHOLE


def test_with_contact_damping_the_force_may_end_and_begin_inside_the_ring(whole: xr.Dataset):
    assert flags_of(whole["event_kind"]) == DAMPED_EVENT_KIND
    assert DAMPED_EVENT_KIND == {"exit": -1, "entry": 1, "press": 4, "release": -4}
    assert whole["event_time"].attrs == {
        "long_name": "time of the contact event", "units": "1"
    }  # fmt: skip


def test_a_run_has_one_value_of_each_parameter(whole: xr.Dataset):
    several = whole.drop_vars("load").expand_dims(load=[0.0, 0.125])
    with pytest.raises(InputError, match=r"^run must be one run; its load must be a scalar$"):
        check_run(several, ("t",))


def test_what_only_reads_the_motion_passes_the_rotor_on(whole: xr.Dataset):
    assert rotor_of(rotating(whole)) == WHOLE
