"""Sweeps: every point where it belongs, hysteresis, failures that stop nothing."""

from itertools import product

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, Rotor, SimulationError, compare, sweep, synchronous_response
from rotor_ida.checks import COMPONENTS
from rotor_ida.parallel import FailedJob
from rotor_ida.schema import EXACT, RESPONSE, flags_of, words_of
from rotor_ida.steady import grid as grid_module
from tests.rotors import KNOCKED

REST = (0.0, 0.0, 0.0, 0.0)


def test_up_and_down_show_the_hysteresis_of_the_jump():
    """Between the folds at 1.598 and 1.933 the rotor stays on the branch it came from."""
    both = sweep(omega=np.linspace(1.4, 2.1, 8), zeta=0.07, delta0=0.0, direction="both").squeeze()
    up, down = both.sel(direction=1).amplitude, both.sel(direction=-1).amplitude
    inside = (both.omega > 1.598) & (both.omega < 1.932)
    assert (up > 2.0 * down).where(inside, True).all()
    assert np.abs(up - down).where(~inside, 0.0).max() < 1e-7
    assert both.amplitude.sel(direction=1, omega=1.7).item() == pytest.approx(9.4872069457)
    assert both.amplitude.sel(direction=-1, omega=1.7).item() == pytest.approx(1.8796312367)


def test_a_ramp_over_friction_is_a_chain_of_sweeps_of_one_point():
    """The large whirl lasts up to a friction beyond 0.04; from above only the small one is met.

    A second axis varies with it.
    """
    rotor = Rotor(omega=1.6, zeta=0.07, delta0=0.5, friction=0.0, disc_radius=10.0)
    frictions, start = [0.0, 0.02, 0.05], (6.0, 0.0, 0.0, 6.0)
    both = sweep(
        rotor, friction=frictions, zeta=[0.07, 0.075], starts=[REST, start], direction="both",
        along="friction", method="taylor",
    )  # fmt: skip
    assert both.attrs["along"] == "friction"
    assert both.amplitude.dims == ("omega", "zeta", "delta0", "friction", "start", "direction")
    up, down = (both.amplitude.sel(direction=way, friction=0.02, start=1) for way in (1, -1))
    assert (up > 5.0 * down).all()
    for zeta, way in product(both.zeta.values, (1, -1)):
        state = start
        for friction in frictions[::way]:
            one = sweep(rotor, friction=friction, zeta=zeta, starts=[state], method="taylor")
            here = both.sel(friction=friction, zeta=zeta, start=1, direction=way).squeeze()
            for name in ("response", "amplitude", "radius_max", "end_x", "end_vy"):
                assert here[name].item() == one[name].item(), (zeta, friction, name)
            state = tuple(one[f"end_{name}"].item() for name in COMPONENTS)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"direction": "up"}, "omega must be two values or more in a sweep up or down, got 1.2"),
        ({"along": "omega"}, "along must be left out without a direction, got 'omega'"),
        (
            {"direction": "up", "delta0": [0.5, 1.0], "zeta": [0.1, 0.2]},
            "along must be given with a direction, as zeta and delta0 vary",
        ),
        (
            {"direction": "up", "delta0": [1.0, 0.5]},
            "delta0 must increase in a sweep up or down, got 0.5 after 1.0",
        ),
        (
            {"direction": "up", "delta0": [0.5, 1.0], "along": "delta"},
            "along must be one of 'omega', 'zeta', 'delta0', got 'delta'; did you mean 'delta0'?",
        ),
        (
            {"direction": "up", "delta0": [0.5, 1.0], "along": "zeta"},
            "zeta must be two values or more in a sweep up or down, got 0.1",
        ),
    ],
)
def test_a_direction_leads_along_one_axis_that_varies(changes, message):
    with pytest.raises(InputError) as caught:
        sweep(Rotor(omega=1.2, zeta=0.1, delta0=0.5), **changes)
    assert str(caught.value) == message


def test_dimensions_labels_and_events():
    starts = [(0, 0, 0, 0), (3.0, 0, 0, 1.0)]
    given = {"omega": [1.0, 2.0], "zeta": [0.3, 0.5], "delta0": [0.2, 0.6, 1.0], "starts": starts}
    responses = sweep(**given, events=True)
    assert responses.response.dims == ("omega", "zeta", "delta0", "start", "direction")
    assert responses.response.shape == (2, 2, 3, 2, 1)
    assert responses.start_vy.values.tolist() == [0.0, 1.0]
    assert set(flags_of(responses.response)) == set(RESPONSE)
    assert int(responses.event_count.sum()) == responses.sizes["event"]
    ends = responses.event_count.values.cumsum()
    place = np.ravel_multi_index((1, 1, 2, 1, 0), responses.event_count.shape)
    times = responses.event_time[ends[place - 1] : ends[place]]
    alone = sweep(omega=2.0, zeta=0.5, delta0=1.0, starts=[starts[1]], events=True)
    assert times.values.tolist() == alone.event_time.values.tolist()
    assert alone.event_kind.values[0] == -1
    without = sweep(**given)
    xr.testing.assert_equal(without, responses.drop_dims("event").drop_vars("event_row"))
    assert len(without.to_dataframe()) == 24


def test_a_point_that_fails_is_labelled_and_stops_nothing(monkeypatch):
    from rotor_ida.simulation import flow

    true_run = flow.run

    def fails_at_two(rotor, *rest, **options):
        if rotor.omega == 2.0:
            raise SimulationError("corrector failed", time=1.0, state=(0.0, 0.0, 0.0, 0.0))
        return true_run(rotor, *rest, **options)

    monkeypatch.setattr(flow, "run", fails_at_two)
    responses = sweep(omega=[1.0, 2.0, 3.0], zeta=0.5, delta0=0.5, direction="up").squeeze()
    assert responses.status.values.tolist() == [0, 1, 0]
    assert responses.response.values[1] == RESPONSE["failed"]
    assert "corrector failed (at t = 1" in responses.message.values[1]
    assert np.isnan(responses.amplitude.values[1])
    assert np.isfinite(responses.amplitude.values[2])


def test_a_chain_that_is_lost_with_its_worker_is_labelled(monkeypatch):
    def loses_the_second(work, jobs, **_):
        for number, job in enumerate(jobs):
            yield (
                number,
                FailedJob("its worker died") if number == 1 else work(job, np.zeros(1, np.uint8)),
            )

    monkeypatch.setattr(grid_module, "run_all", loses_the_second)
    found = sweep(omega=[1.0, 2.0], zeta=0.5, delta0=0.5, direction="both").squeeze()
    assert found.status.values.tolist() == [[0, 1], [0, 1]]
    assert found.message.values[:, 1].tolist() == ["its worker died"] * 2
    assert found.event_count.values[:, 1].tolist() == [0, 0]


def test_axes_are_dimensions_numbers_coordinates_and_each_point_is_what_it_is_alone():
    plain = {"omega": [1.2, 2.4], "zeta": 0.05, "delta0": 1.0, "method": "taylor"}
    axes = {"shaft_stiffness": [0.25, 0.3], "load": [0.0, 0.6]}
    both = sweep(**plain, **axes, contact_exponent=1.0, contact_damping=0.0)
    assert both.amplitude.dims == (
        "omega", "zeta", "delta0", "shaft_stiffness", "load", "start", "direction",
    )  # fmt: skip
    assert both.contact_exponent.item() == 1.0
    assert "contact_damping" not in both.coords
    # of a Dataset `load` is a method
    assert both["load"].attrs["units"] == "1"
    assert both["load"].attrs["long_name"]
    for load in axes["load"]:
        alone = sweep(**plain, shaft_stiffness=0.3, load=load, contact_exponent=1.0)
        part = both.sel(shaft_stiffness=0.3, load=load)
        assert ("load" in alone.coords) == (load > 0.0)
        assert alone.shaft_stiffness.item() == 0.3
        for name in ("response", "amplitude", "period", "event_count", "end_vx"):
            np.testing.assert_array_equal(part[name].values, alone[name].values)


def test_dry_whip_starts_from_a_knock_and_rubs_are_those_of_the_closed_form():
    """Whip is born at omega 0.3148 without unbalance (DESIGN section 3); from rest it is not
    reached."""
    found = sweep(
        omega=[0.3, 0.5, 0.6], zeta=0.1, delta0=1.0, friction=[0.0, 0.2], disc_radius=10.0,
        starts=[REST, KNOCKED], method="taylor",
    )  # fmt: skip
    rolling = found.response == RESPONSE["rolling"]
    assert not rolling.sel(friction=0.0).any()
    assert not rolling.sel(start=0).any()
    whips = found.sel(friction=0.2).isel(start=1).squeeze()
    kinds = ("contact_free", "rolling", "rolling")
    assert whips.response.values.tolist() == [RESPONSE[kind] for kind in kinds]
    assert found.disc_radius.item() == 10.0
    compared = compare(found)
    # with unbalance whip is a cycle on the turning axes
    repeats = rolling & found.period.notnull()
    assert repeats.any()
    assert (compared.lies_on.where(repeats, EXACT["cycle"]) == EXACT["cycle"]).all()
    assert float(compared.digits.where(repeats).min()) > 6.0
    rubs = compared.response == RESPONSE["synchronous"]
    assert rubs.sel(friction=0.2).any()
    assert (compared.lies_on.where(rubs, EXACT["whirl"]) == EXACT["whirl"]).all()
    assert float(compared.digits.where(rubs).min()) > 9.0


MACHINE = {"zeta": 0.05, "delta0": 1.0, "shaft_stiffness": 0.25, "method": "taylor"}


def test_a_run_up_under_a_load_goes_on_where_the_last_speed_ended():
    """At whole revolutions the turning axes point as they did: an end is a start."""
    up = sweep(omega=[2.0, 2.3, 2.5], load=0.6, direction="up", **MACHINE).squeeze()
    ends = ("end_x", "end_y", "end_vx", "end_vy")
    for place, speed in enumerate((2.3, 2.5)):
        start = [up[name].values[place] for name in ends]
        alone = sweep(omega=speed, load=0.6, starts=[start], **MACHINE).squeeze()
        for name in ("response", "amplitude", "radius_min", "radius_max", "period", *ends):
            assert up[name].values[place + 1] == alone[name].item(), name
    revolutions = up.period * up.omega / (2.0 * np.pi)
    np.testing.assert_allclose(revolutions, [2.0, 2.0, 1.0], rtol=1e-14)
    # from rest it comes to another cycle at the last speed
    rest = sweep(omega=2.5, load=0.6, **MACHINE).squeeze()
    assert rest.period.item() * 2.5 / (2.0 * np.pi) == pytest.approx(3.0, rel=1e-14)


def test_taylor_series_are_the_default_and_label_as_cvode_does():
    """From rest: a start near the border of two basins is labelled by chance."""
    given = {"omega": np.linspace(0.4, 3.2, 8), "zeta": [0.05, 0.1, 0.3], "delta0": [0.0, 0.5, 2.0]}
    swept, by_cvode = sweep(**given), sweep(**given, method="adams")
    assert swept.attrs["method"] == "taylor"
    assert set(words_of(swept.response)) == {
        "synchronous", "contact_free", "full_contact", "bouncing", "touching"
    }  # fmt: skip
    np.testing.assert_array_equal(swept.response, by_cvode.response)
    np.testing.assert_allclose(swept.amplitude, by_cvode.amplitude, rtol=0.0, atol=1e-6)


@pytest.mark.parametrize(
    ("given", "method"),
    [({}, "taylor"), ({"flight": "cvode"}, "adams"), ({"backend": "python"}, "adams"),
     ({"rtol": 5e-4}, "adams"), ({"method": "bdf"}, "bdf")],
)  # fmt: skip
def test_the_method_of_a_study_is_one_that_can_be_used_and_is_recorded(given, method):
    found = sweep(omega=0.5, zeta=0.5, delta0=2.0, **given)
    assert found.attrs["method"] == method
    assert words_of(found.response) == ["contact_free"]


def test_kinds_of_events_are_among_their_flags():
    """Friction and contact damping of any rotor of the grid have kinds of their own."""
    rubs = sweep(
        omega=1.2, zeta=0.07, delta0=0.5, friction=[0.0, 0.3], disc_radius=0.6,
        starts=[(0.3, 0.1, 0.2, 0.1)], events=True,
    )  # fmt: skip
    assert {"roll", "slip", "reverse"} <= set(words_of(rubs.event_kind))
    plain = sweep(omega=2.0, zeta=0.07, delta0=2.0, events=True)
    assert set(words_of(plain.event_kind)) == {"exit", "entry"}


def test_the_linear_response_under_a_load_is_where_a_sweep_settles():
    """Sag and whirl together are the largest radius, up to the touch and no farther."""
    shaft = {"zeta": 0.2, "delta0": 1.0, "shaft_stiffness": 0.5, "load": 0.2}
    omega = np.array([0.2, 0.4, 0.5, 2.0, 3.0])
    exact = synchronous_response(omega=omega, **shaft).squeeze()
    clear = np.abs(omega**2 / (0.5 - omega**2 + 0.4j * omega)) + 0.4 <= 1.0
    np.testing.assert_array_equal(exact.amplitude.notnull(), clear)
    assert 0 < clear.sum() < clear.size
    assert "limit_cycle" in exact.attrs["not_exact"]
    swept = sweep(omega=omega[clear], **shaft).squeeze()
    np.testing.assert_allclose(swept.radius_max, exact.amplitude[clear] + 0.4, rtol=1e-6)
    system = Rotor(omega=1.0, **shaft).system()  # the other kernel
    radii = synchronous_response(system, speed=omega[clear]).unbalance_radius.squeeze()
    np.testing.assert_allclose(radii, exact.amplitude[clear] + 0.4, rtol=1e-12)
    lying = synchronous_response(omega=0.4, **shaft | {"load": 0.6})
    assert lying.attrs["not_exact"].endswith("the sag alone lays the rotor on the stator")
    assert not lying.amplitude.notnull().any()
