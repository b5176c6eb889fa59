"""A rotor and what varies: axes and numbers, and one line for each mistake in whichever verb."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import InputError, Rotor
from rotor_ida.closed_forms import (
    clearance_curve,
    cusp,
    free_periods,
    impact,
    jumps,
    late_jumps,
    peaks,
    response_curve,
    sommerfeld_curve,
)
from rotor_ida.model.parameters import ALL_PARAMETERS, DEFAULTS
from rotor_ida.model.varied import Varied, varied_of
from rotor_ida.results.question import QUESTION, Question
from rotor_ida.results.question import VERBS as VERBS_ASKED

# Verbs of a rotor and what varies, each with its other arguments.
VERBS: dict[str, dict[str, Any]] = {
    "sweep": {},
    "run_ups": {"to": 1.3, "rate": 0.1},
    "bifurcation_diagram": {"starts": 1, "extrema_time": 10.0},
    "continue_attractors": {"starts": 2, "x": (-2.0, 2.0)},
    "synchronous_response": {},
    "folds": {},
    "hopf_points": {},
    "jumps": {},
    "peaks": {},
    "cusp": {},
    "late_jumps": {"rate": 1e-4},
    "response_curve": {"limits": (0.1, 2.0), "points": 5},
    "clearance_curve": {"limits": (0.1, 2.0), "points": 5},
    "sommerfeld_curve": {"limits": (0.1, 2.0), "points": 5, "inertia": 20.0},
}
OWN = {"jumps": jumps, "peaks": peaks, "cusp": cusp, "late_jumps": late_jumps,
       "response_curve": response_curve, "clearance_curve": clearance_curve,
       "sommerfeld_curve": sommerfeld_curve}  # fmt: skip
EACH_VERB = pytest.mark.parametrize("name", VERBS)
# Parameters that a verb searches or varies itself.
LEFT_OUT = {name: ["omega"] for name in VERBS if name in OWN or name in {"folds", "hopf_points"}}
LEFT_OUT |= {"clearance_curve": ["delta0"], "cusp": ["omega", "zeta"]}


def verb(name: str) -> Callable[..., xr.Dataset]:
    return OWN.get(name) or getattr(rotor_ida, name)


def varied_in(given: dict[str, Any]) -> Varied:
    return varied_of(rotor_ida.sweep, None, given)


def test_a_clearance_curve_with_friction_leaves_no_clearance_out():
    with pytest.raises(InputError) as caught:
        clearance_curve(omega=1.2, zeta=0.07, limits=(0.0, 1.0), friction=0.1)
    assert len(str(caught.value).splitlines()) == 1


def test_a_rotor_of_a_grid_has_the_values_of_its_place():
    given = {
        "omega": [1.0, 2.0, 3.0], "zeta": 0.07, "delta0": [0.5, 1.0], "load": 0.25,
        "friction": [0.1, 0.2], "disc_radius": 10.0, "contact_exponent": 1.5,
    }  # fmt: skip
    varied = varied_in(given)
    assert varied.dims == ("omega", "zeta", "delta0", "friction")
    assert varied.shape == (3, 1, 2, 2)
    assert varied.points == 12
    assert varied.rotor((2, 0, 1, 0)) == Rotor(
        omega=3.0, zeta=0.07, delta0=1.0, load=0.25, friction=0.1, disc_radius=10.0
    )
    grid = xr.Dataset(coords=varied.coordinates)
    assert dict(grid.sizes) == dict(zip(varied.dims, varied.shape, strict=True))
    assert grid["load"].item() == 0.25
    assert "contact_exponent" not in grid.coords  # the one default number


@pytest.mark.parametrize("name", ALL_PARAMETERS)
def test_each_value_is_among_the_extremes(name: str):
    """What none of them is too much for is too much for no rotor of the grid."""
    extremes = varied_in({each: [1.0] for each in ALL_PARAMETERS} | {name: [1.0, 1.5]}).extremes()
    found = {getattr(rotor, name) for rotor in extremes}
    assert found == ({1.5} if name in {"zeta", "shaft_stiffness"} else {1.0, 1.5})


def test_a_parameter_that_is_not_given_has_its_default():
    varied = varied_in({"omega": 1.0, "zeta": 0.1, "delta0": 0.5})
    defaults = {name: varied.values(name).item() for name in DEFAULTS if name != "disc_radius"}
    assert defaults == {name: value for name, value in DEFAULTS.items() if value is not None}
    assert np.isnan(varied.values("disc_radius")).all()


@EACH_VERB
def test_a_rotor_first_is_its_parameters_by_keyword(name: str):
    given = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5, "contact_damping": 0.125}
    asked = {each: value for each, value in given.items() if each not in LEFT_OUT.get(name, [])}
    by_name = verb(name)(**VERBS[name], **asked)
    rotor_first = verb(name)(Rotor(**given), **VERBS[name])
    kept = [each.attrs.pop(QUESTION, "") for each in (by_name, rotor_first)]  # as each was asked
    assert rotor_first.identical(by_name)
    for text in kept if name in VERBS_ASKED else ():
        again = Question.of_text(text).ask()
        assert again.drop_attrs().identical(by_name.drop_attrs())


@EACH_VERB
def test_keywords_override_the_rotor_and_are_axes(name: str):
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, contact_damping=0.5)
    found = verb(name)(rotor, **VERBS[name], contact_damping=0.0, shaft_stiffness=[0.0, 0.125])
    assert "contact_damping" not in found.coords
    assert found["shaft_stiffness"].dims == ("shaft_stiffness",)
    assert found["shaft_stiffness"].values.tolist() == [0.0, 0.125]
    for kept in ("omega", "zeta", "delta0"):
        if kept not in LEFT_OUT.get(name, []):
            assert found[kept].values.tolist() == [getattr(rotor, kept)]


@EACH_VERB
def test_wrong_arguments_get_one_line(name: str):
    rotor, of = Rotor(omega=1.2, zeta=0.07, delta0=0.5), VERBS[name]
    wrong: list[tuple[tuple[object, ...], dict[str, Any], str]] = [
        ((rotor,), {"frictionn": 0.1},
         f"{name} has no argument 'frictionn'; did you mean 'friction'?"),
        ((rotor,), {"qqq": 0.1}, f"{name} has no argument 'qqq'"),
        ((1.2,), {}, f"{name}(rotor"),
        ((rotor,), {"friction": [0.1, 0.2, 0.1], "disc_radius": 5.0},
         "friction must have each value once, got 0.1 twice"),
    ]  # fmt: skip
    wrong += [
        ((rotor,), {each: 0.1}, f"{each} must be left out of {name}: ")
        for each in LEFT_OUT.get(name, [])
    ]
    if name != "cusp":
        wrong.append(((), {"friction": 0.1}, f" must be given to {name}, or a rotor: {name}("))
    for first, given, message in wrong:
        with pytest.raises(InputError) as caught:
            verb(name)(*first, **of, **given)
        assert message in str(caught.value)
        assert len(str(caught.value).splitlines()) == 1


def test_a_value_given_twice_on_any_axis_is_refused():
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5)
    system = rotor.system()
    calls: list[tuple[str, Callable[[], object]]] = [
        ("rate", lambda: rotor_ida.run_ups(rotor, to=1.5, rate=[0.1, 0.2, 0.1])),
        ("phase", lambda: rotor_ida.run_ups(rotor, to=1.5, rate=0.1, phase=[0.0, 0.0])),
        ("rate", lambda: late_jumps(rotor, rate=[1e-4, 1e-4])),
        ("entry_speed", lambda: impact(entry_speed=[1.0, 1.0], contact_damping=0.1)),
        ("amplitude", lambda: free_periods(amplitude=[2.0, 2.0], delta0=0.5)),
        ("speed", lambda: rotor_ida.sweep(system, speed=[1.2, 1.2])),
        ("speed", lambda: rotor_ida.campbell(system, speed=[1.2, 1.2])),
        ("friction", lambda: rotor_ida.drop_ensemble(
            system, speed=1.2, duration=1.0, friction=[0.1, 0.1])),
    ]  # fmt: skip
    for name, call in calls:
        with pytest.raises(InputError, match=rf"^{name} must have each value once, got .* twice$"):
            call()


def test_a_misspelt_option_is_named_too():
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5)
    with pytest.raises(InputError, match="no argument 'directionn'; did you mean 'direction'"):
        rotor_ida.sweep(rotor, directionn="up")


@pytest.mark.parametrize("name", [each for each in VERBS if each in OWN or "_" in each])
def test_a_load_is_refused_where_no_whirl_is_synchronous(name: str):
    if name in {"run_ups", "bifurcation_diagram", "synchronous_response", "response_curve"}:
        return  # the first two follow it, the others are linear then
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, load=0.125)
    with pytest.raises(InputError, match=r"^load must be 0 .*, got 0\.125; load 0 leaves"):
        verb(name)(rotor, **VERBS[name])
    assert verb(name)(rotor, **VERBS[name], load=0.0).sizes


def test_rest_refuses_friction():
    """Held by friction a rotor that does not turn may lie anywhere in a range."""
    rotor = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)
    with pytest.raises(InputError, match=r"^friction must be 0 for rest"):
        rotor_ida.rest(rotor)


def test_a_cycle_of_another_rotor_is_no_start():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    cycle = rotor_ida.limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)
    other = cycle.assign_coords(load=0.125)
    message = r"^start must be of the same rotor: its load is 0.125, that of the rotor 0.0$"
    with pytest.raises(InputError, match=message):
        rotor_ida.limit_cycle(rotor, start=other)
    with pytest.raises(InputError, match=message):
        rotor_ida.continue_cycle(rotor, start=other, limits=(1.5, 2.5))


def test_a_machine_where_only_a_rotor_will_do_is_told_how_to_become_one():
    machine = rotor_ida.DimensionalRotor(
        mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=1e-5, clearance=2e-5,
        speed=314.0,
    )  # fmt: skip
    with pytest.raises(InputError, match=r"write response_curve\(machine\.rotor\(\), \.\.\.\)"):
        response_curve(machine, limits=(0.1, 1.0))
