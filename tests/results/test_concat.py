"""Results joined along a parameter are the results over both."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    basin,
    bifurcation_diagram,
    concat,
    load,
    save,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.results.si_units import dimensionless
from rotor_ida.verification.verify import differences, rerun

OTHERS = {"zeta": 0.07, "delta0": [2.0, 1.0]}
swept = partial(sweep, events=True)


def assert_joined(joined, whole):
    """Assert that a joined result is the whole one, but for the question that each part answers."""
    both = [each.copy() for each in (joined, whole)]
    for each in both:
        each.attrs.pop("question", None)
    xr.testing.assert_identical(*both)


@pytest.mark.parametrize(
    ("compute", "given"),
    [(swept, OTHERS), (synchronous_response, OTHERS | {"delta0": 0.5}),
     (bifurcation_diagram, OTHERS | {"starts": 2})],
)  # fmt: skip
def test_two_ranges_of_speed_become_the_result_over_both(compute, given):
    parts = [compute(omega=omega, **given) for omega in ([1.0, 1.5], [2.0])]
    whole = compute(omega=[1.0, 1.5, 2.0], **given)
    assert_joined(concat(parts, "omega"), whole)


def test_a_table_of_events_follows_its_runs_along_an_inner_dimension():
    parts = [swept(omega=[1.0, 2.0], zeta=zeta, delta0=2.0) for zeta in ([0.07, 0.1], [0.2])]
    whole = swept(omega=[1.0, 2.0], zeta=[0.07, 0.1, 0.2], delta0=2.0)
    assert_joined(concat(parts, "zeta"), whole)


def test_a_joined_sweep_verifies():
    joined = concat([swept(omega=[omega], zeta=0.3, delta0=0.5) for omega in (1.0, 1.5)], "omega")
    assert differences(rerun(joined, workers=1), joined)["agrees"] is True


def test_what_depends_on_the_whole_has_no_question_once_it_is_joined():
    ramps = [swept(omega=[w, w + 0.2], zeta=0.3, delta0=0.5, direction="up") for w in (1.0, 1.5)]
    basins = [basin(Rotor(omega=1.7, zeta=0.3, delta0=0.5), x=[x], y=[0.0]) for x in (1.0, 2.0)]
    for joined in (concat(ramps, "omega"), concat(basins, "x")):
        with pytest.raises(InputError, match="it lacks its question"):
            rerun(joined)


def test_xarray_joins_sweeps_without_their_events():
    parts = [sweep(omega=omega, **OTHERS) for omega in ([1.0, 1.5], [2.0])]
    whole = sweep(omega=[1.0, 1.5, 2.0], **OTHERS)
    assert_joined(xr.concat(parts, dim="omega"), whole)


@pytest.mark.parametrize("compute", [swept, bifurcation_diagram])
def test_parts_of_a_result_keep_the_rows_of_their_own_runs(compute, tmp_path):
    given = {"zeta": [0.07, 0.1], "delta0": [2.0, 1.0]}
    whole, expected = (compute(omega=omega, **given) for omega in ([1.0, 1.5, 2.0], [1.0, 2.0]))
    parts = [whole.isel(omega=[place]) for place in (0, 2)]
    assert_joined(concat(parts, "omega"), expected)
    selected = whole.isel(omega=[2, 0])
    again = load(save(selected, tmp_path / "part.nc")).isel(omega=[1, 0])
    xr.testing.assert_equal(concat([again], "omega"), expected)
    alone = load(save(whole.sel(omega=2.0, zeta=0.1, delta0=2.0), tmp_path / "one.nc"))
    table = "event" if compute is swept else "extremum"
    assert alone.sizes[table] == alone[f"{table}_count"].sum()


def test_cut_tables_are_refused():
    found = swept(omega=[1.0, 1.5], **OTHERS)
    with pytest.raises(InputError, match="select runs, not rows"):
        concat([found.isel(event=slice(0, 5))], "omega")
    with pytest.raises(InputError, match="must have event_row: without it is unknown which rows"):
        concat([found.drop_vars("event_row")], "omega")
    with pytest.raises(InputError, match="must be of one kind"):
        concat([found, sweep(omega=[2.0], **OTHERS)], "omega")


def test_runs_become_one_dataset_over_a_parameter():
    runs = [
        simulate(Rotor(omega=omega, zeta=0.07, delta0=0.5), duration=20.0, samples=101)
        for omega in (1.7, 1.9)
    ]
    events = [run.sizes["event"] for run in runs]
    joined = concat(runs, "omega")
    assert dict(joined.sizes) == {"omega": 2, "t": 101, "event": max(events), "contact": 3}
    for run in runs:
        own = joined.sel(omega=run.omega)
        np.testing.assert_array_equal(own.x, run.x)
        np.testing.assert_array_equal(own.event_time.dropna("event"), run.event_time)
    assert "omega" not in joined.attrs
    assert joined.attrs["duration"] == 20.0


def test_what_does_not_fit_together_is_refused():
    one = swept(omega=1.0, zeta=0.07, delta0=2.0)
    with pytest.raises(InputError, match="dim must be in all datasets, got 'speed'"):
        concat([one, one], "speed")
    with pytest.raises(InputError, match="datasets must contain at least one, got none"):
        concat([], "omega")
    other = swept(omega=1.5, zeta=0.1, delta0=2.0)
    with pytest.raises(InputError, match="must have the same coordinates besides omega"):
        concat([one, other], "omega")


def test_runs_of_a_machine_of_differing_length_are_joined():
    machine = DimensionalRotor(
        mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6,
        speed=600.0,
    )  # fmt: skip
    runs = [simulate(replace(machine, speed=speed), duration=duration, samples=3)
            for speed, duration in ((600.0, 0.01), (650.0, 0.011))]  # fmt: skip
    joined = concat([run[["x"]].assign_coords(t=[0, 1, 2]) for run in runs], "omega")
    assert joined.sizes["omega"] == 2
    np.testing.assert_allclose(dimensionless(joined).omega, [1.2, 1.3])
