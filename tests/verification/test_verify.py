"""A result can be made again from its own attributes, also after it has been in an archive."""

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    basin,
    basin_fractions,
    bifurcation_diagram,
    contact_summary,
    continue_attractors,
    continue_cycle,
    dimensional,
    limit_cycle,
    load,
    run_up,
    run_ups,
    save,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.testing import assert_events_close
from rotor_ida.verification.verify import differences, rerun

ROTOR = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


@pytest.mark.parametrize(
    ("method", "flight"), [("adams", "exact"), ("bdf", "cvode"), ("taylor", "exact")]
)
def test_a_run_is_made_again_to_the_bit(tmp_path, method, flight):
    run = simulate(
        ROTOR, start=(0.1, 0, 0, 0), duration=30.0, samples=7, method=method, flight=flight
    )
    again = rerun(load(save(run, tmp_path / "run.nc")))
    assert (again.event_time.values == run.event_time.values).all()
    assert (again.x.values == run.x.values).all()
    assert_events_close(again, run)


@pytest.mark.parametrize("flight", ["exact", "cvode"])
def test_another_method_is_a_witness_of_a_run(flight):
    run = simulate(ROTOR, start=(0.1, 0, 0, 0), duration=30.0, flight=flight)
    again = rerun(run, method="taylor")
    assert again.attrs["method"] == "taylor"
    assert (again.event_time.values != run.event_time.values).any()
    assert_events_close(again, run)
    assert differences(again, run)["agrees"] is True


def test_another_method_comes_to_the_same_responses():
    archived = RESULTS["sweep"]()
    assert differences(rerun(archived, method="taylor"), archived)["agrees"] is True


def test_a_basin_knows_no_method():
    with pytest.raises(
        InputError, match="method must be left out for the kind basin, got 'taylor'"
    ):
        rerun(RESULTS["basin"](), method="taylor")


RESULTS = {
    "sweep": lambda: sweep(omega=[1.2, 1.7, 2.2], zeta=0.3, delta0=[0.5, 1.0],
                           starts=[(0, 0, 0, 0), (3, 0, 0, 1)]),
    "up and down": lambda: sweep(omega=[1.2, 1.7], zeta=0.3, delta0=0.5, direction="both"),
    "up and down in clearance": lambda: sweep(ROTOR, zeta=[0.3, 0.5], delta0=[0.5, 1.0],
                                              direction="both", along="delta0"),
    "machines": lambda: sweep(
        events=True, omega=[1.2, 2.0], zeta=0.1, delta0=[0.5, 2.0], shaft_stiffness=[0.0, 0.3],
        contact_exponent=1.0, contact_damping=[0.2], starts=[(0, 0, 0, 0), (3, 0, 0, 1)],
    ),
    "basin": lambda: basin(Rotor(omega=1.7, zeta=0.3, delta0=0.5), x=1.0, y=[-2.0, 0.0, 3.0],
                           vx=[0.0, 5.0]),
    "basin_fractions": lambda: basin_fractions(ROTOR, x=(-8, 8), y=(-8, 8), vx=1.0, starts=600,
                                               seed=4),
    "atlas": lambda: continue_attractors(omega=1.7, zeta=0.07, delta0=0.0, x=(-15, 15), starts=20,
                                         seed=4, shocks=8),
    "basin of a machine": lambda: basin(
        Rotor(omega=1.7, zeta=0.3, delta0=0.5, shaft_stiffness=0.3, contact_damping=0.1),
        x=[1.0, 2.0], y=[-2.0, 0.0, 3.0],
    ),
    "atlas of machines": lambda: continue_attractors(
        omega=1.7, zeta=0.1, delta0=0.5, shaft_stiffness=[0.1, 0.3], contact_damping=0.1,
        x=(-5, 5), starts=40, seed=4,
    ),
    "atlas of given starts": lambda: continue_attractors(
        omega=2.0, zeta=[0.07, 0.1], delta0=2.0, starts=[(0, 0, 0, 0), (3, 1, 0, 0)]
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", RESULTS)
def test_a_result_of_many_points_is_made_again_to_the_bit(tmp_path, kind):
    archived = load(save(RESULTS[kind](), tmp_path / "result.nc"))
    again = rerun(archived, workers=1)
    for name, variable in again.variables.items():
        np.testing.assert_array_equal(variable.values, archived[name].values)
    found = differences(again, archived)
    assert (found["agrees"], found["differing"], found["largest_difference"]) == (True, 0, 0.0)


def test_another_kind_of_dataset_cannot_be_verified():
    summary = contact_summary(simulate(ROTOR, start=(0, 0, 0, 0), duration=5.0))
    with pytest.raises(
        InputError,
        match=r"^a result of the kind 'contact_summary' cannot be verified: compute it again, and",
    ):
        rerun(summary)
    with pytest.raises(InputError, match=r"compute it again, and compare: rotor-ida forces 1$"):
        rerun(summary.assign_attrs(command="rotor-ida forces 1"))
    run = simulate(ROTOR, start=(0, 0, 0, 0), duration=5.0)
    cut = run.drop_vars("x")
    del cut.attrs["rtol"]
    with pytest.raises(InputError, match="this run cannot be verified: it lacks rtol, x"):
        differences(run, cut)


@pytest.mark.parametrize(
    ("kind", "damage", "message"),
    [
        ("sweep", lambda of: of.drop_vars("start_y"), "it lacks start_y along start"),
        ("sweep", lambda of: of.assign(amplitude=of.amplitude.astype(str)),
         "amplitude of this sweep must be real nu"),
        ("basin", lambda of: of.assign_attrs(question=0),
         "this basin cannot be verified: it lacks its question"),
        ("basin_fractions", lambda of: of.assign_attrs(
            question=of.question.replace('"starts":600', '"starts":"many"')),
         "starts must be a whole number, got"),
        ("up and down", lambda of: of.isel(omega=[1]),
         "a part of a sweep up or down cannot be verified: each point begins"),
        ("basin", lambda of: of.isel(y=[1]), "a part of this basin cannot be verified"),
        ("atlas of given starts", lambda of: of.isel(zeta=[1]), "a part of this atlas cannot be"),
    ],
)  # fmt: skip
def test_a_result_that_lacks_what_it_takes_is_refused(kind, damage, message):
    with pytest.raises(InputError, match=message):
        rerun(damage(RESULTS[kind]()))


WHIRLS = {"omega": [1.2, 1.7], "zeta": [0.3, 0.4], "delta0": 0.5}


@pytest.mark.parametrize(
    ("whole", "places"),
    [
        (RESULTS["sweep"], {"omega": [2, 0], "delta0": [1]}),
        (lambda: sweep(**WHIRLS, events=True, direction="up"), {"zeta": [0]}),
        (lambda: sweep(**WHIRLS, events=True), {"omega": [1, 0]}),
        (lambda: bifurcation_diagram(**WHIRLS, starts=[(0, 0, 0, 0)]), {"omega": [1]}),
        (lambda: synchronous_response(**WHIRLS), {"zeta": 0, "omega": [1, 0]}),
    ],
)
def test_a_part_of_a_result_is_made_again(whole, places):
    part = whole().isel(places)
    again = rerun(part)
    assert (again.omega.values == part.omega).all()
    found = differences(again, part)
    assert (found["agrees"], found["differing"]) == (True, 0)


@pytest.mark.parametrize(
    ("whole", "places"),
    [
        (RESULTS["sweep"], {"start": [0]}),
        (RESULTS["sweep"], {"start": [1, 0]}),
        (RESULTS["up and down"], {"direction": [0]}),
        (lambda: simulate(ROTOR, start=(0, 0, 0, 0), duration=20.0), {"event": slice(3)}),
    ],
)
def test_a_part_along_no_argument_is_refused(whole, places):
    part = whole().isel(places)
    with pytest.raises(InputError, match=f"a part of a result along {next(iter(places))} cannot"):
        differences(rerun(part), part)


def test_a_cycle_from_a_result_is_made_again_from_its_guess():
    cycle = limit_cycle(ROTOR, start=(0, 0, 0, 0))
    branch = continue_cycle(ROTOR, start=cycle, limits=(1.98, 2.02))
    run = simulate(ROTOR, start=(0, 0, 0, 0), duration=20.0)
    for given in ({"start": cycle}, {"start": branch.isel(point=3)}, {"start": run, "period": 4.5}):
        found = limit_cycle(ROTOR, **given)
        assert len(found.attrs["question"]) < 2000
        assert differences(rerun(found), found)["agrees"] is True


def test_very_many_samples_are_not_in_the_question():
    run = simulate(ROTOR, start=(0, 0, 0, 0), duration=1.0, samples=np.linspace(0, 1, 1_000_001))
    assert len(run.attrs["question"]) < 1000
    assert differences(rerun(run), run)["agrees"] is True


def test_a_forged_run_does_not_choose_how_it_is_compared():
    run = simulate(ROTOR, start=(0, 0, 0, 0), duration=20.0)
    again = rerun(run)
    for rtol in (1.0, "large"):
        forged = run.assign(x=run.x * 1.01).assign_attrs(rtol=rtol)
        assert differences(again, forged)["agrees"] is False
    with pytest.raises(InputError, match="event_time must be numbers, got object"):
        differences(again, run.assign(event_time=run.event_time.astype(object)))
    whirls = synchronous_response(**WHIRLS).assign_attrs(question=run.question)
    with pytest.raises(InputError, match="this whirls cannot be verified: it lacks t"):
        rerun(whirls)


IN_SI = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                         clearance=2e-6, speed=1000.0)  # fmt: skip
THIRDS = np.linspace(-3.0, 3.0, 4) / 3.1  # none of which comes back from metres by a division
STORED_IN_SI = {
    "run": lambda rotor: simulate(rotor, start=(0.1, 0.0, 0.0, 1 / 3), duration=30.0),
    "run_up": lambda rotor: run_up(rotor, start=(0, 0, 0, 0), to=2.5, rate=1 / 97),
    "sweep": lambda rotor: sweep(omega=[0.7, rotor.omega], zeta=rotor.zeta, delta0=rotor.delta0,
                                 starts=[(value, 0.0, 0.0, 0.0) for value in THIRDS]),
    "run_ups": lambda rotor: run_ups(omega=0.3, to=1.6, rate=[1 / 7, 1 / 3], zeta=rotor.zeta,
                                     delta0=rotor.delta0, shaft_stiffness=1.0),
    "basin": lambda rotor: basin(rotor, x=THIRDS, y=THIRDS),
    "fractions": lambda rotor: basin_fractions(rotor, x=(-3, 3), y=(-3, 3), starts=40),
    "atlas": lambda rotor: continue_attractors(omega=rotor.omega, zeta=rotor.zeta,
                                               delta0=rotor.delta0, x=(-3, 3), starts=20),
    "cycle": lambda rotor: limit_cycle(rotor, start=(0, 0, 0, 0)),
}  # fmt: skip


@pytest.mark.parametrize("kind", STORED_IN_SI)
def test_a_result_in_si_units_is_made_again_without_dimensions(tmp_path, kind):
    """What it was computed from comes back to the last bit, whatever the prefix of its units."""
    plain = STORED_IN_SI[kind](IN_SI.rotor())
    in_si = load(save(dimensional(plain, IN_SI, units={"length": "um"}), tmp_path / "si.nc"))
    again = rerun(in_si)
    for name in plain.coords:
        if name in again and name not in ("t", "frequency", "unit"):
            assert (again[name].values == plain[name].values).all(), name
    found = differences(again, in_si)
    assert found["agrees"] is True, found
    shifted = in_si.copy()
    for name in ("event_time", "amplitude", "radius_max"):
        if name in shifted:
            shifted[name] = shifted[name] * 1.01
    assert differences(again, shifted)["agrees"] is False


def test_two_multipliers_that_nearly_coincide_differ_by_the_root_of_rounding():
    """By mu + q/mu = tr M - 1 - q they are one where the trace is 1 + q + 2 sqrt(q)."""
    branch = continue_cycle(ROTOR, start=(0, 0, 0, 0), limits=(1.95, 2.05))
    q = float(np.exp(-2.0 * branch.zeta * branch.period[0]))

    def with_trace(change):
        half = 0.5 * (1.0 + change) * 2.0 * np.sqrt(q)
        apart = np.sqrt(complex(half**2 - q))
        pair = np.array([half + apart, half - apart])
        values = branch.multiplier_real.values + 1j * branch.multiplier_imag.values
        values[0] = [1.0, *pair, q]
        dims = branch.multiplier_real.dims
        return branch.assign(
            multiplier_real=(dims, values.real), multiplier_imag=(dims, values.imag)
        )

    one, other = with_trace(0.0), with_trace(2e-15)
    assert abs(one.multiplier_real - other.multiplier_real).max() > 1.5e-8
    assert differences(other, one)["agrees"] is True
    assert "multiplier_real differs" in differences(with_trace(1e-12), one)["trouble"]


def test_states_of_a_stroboscopic_diagram_are_compared_in_any_order():
    """A motion that repeats after n revolutions is known by n states, whichever comes first."""
    made = bifurcation_diagram(
        omega=[1.7, 2.0, 3.0], zeta=0.07, delta0=[0.5, 2.0], starts=[(0, 0, 0, 0)], at="revolution"
    )
    assert {1, 3} <= {*made.response.values.ravel().tolist()}
    again = made.roll(crossing=1)
    assert differences(again, made)["agrees"] is True
    for response in (1, 3):
        at = np.argwhere(
            made.rotating_x.notnull().values & (made.response == response).values[..., None]
        )[0]
        forged = made.copy(deep=True)
        forged.rotating_x.values[tuple(at)] += 0.5 * abs(made.rotating_x).max()
        assert "rotating_x differs" in differences(again, forged)["trouble"]
