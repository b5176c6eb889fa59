"""Bifurcation diagrams of rotor systems: those of one disc, of closed forms, and of sweeps."""

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    Rotor,
    SimulationError,
    bifurcation_diagram,
    poincare_section,
    sweep,
    synchronous_response,
)
from rotor_ida.schema import STATUS
from rotor_ida.simulation.crossings import CONSTANT, MAXIMUM, MINIMUM
from rotor_ida.steady import bifurcation_diagram as diagram_module
from tests.simulation.test_system_sections import LOADED, TOUCHING, chain, response, states

REST = (0.0, 0.0, 0.0, 0.0)
ON_AXIS = (np.zeros(2), np.zeros(2))
DISC = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
JUMPING = Rotor(omega=1.5, zeta=0.07, delta0=0.5)


def extrema(found, kind, node=0):
    """Return the extrema of a kind at each point in order, of a node of a rotor system."""
    counts, first = found.extremum_count, found.extremum_row
    if "node" in counts.dims:
        counts, first = counts.isel(node=node), first.isel(node=node)
    parts = [slice(row, row + count) for row, count in
             zip(first.values.ravel(), counts.values.ravel(), strict=True)]  # fmt: skip
    return [found.extremum_radius.values[part][found.extremum_kind.values[part] == kind]
            for part in parts]  # fmt: skip


def test_one_disc_as_a_system_has_the_extrema_of_the_disc():
    """Of a bouncing cycle and a full contact, each again and again; of a whirl one radius."""
    speeds = [1.2, 1.7, 2.0]
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=0.5)
    for disc, start in ((DISC, REST), (rotor, REST)):
        one = bifurcation_diagram(disc, omega=speeds, starts=[start])
        many = bifurcation_diagram(disc.system(), speed=speeds, revolutions=20)
        np.testing.assert_array_equal(many.response.values.ravel(), one.response.values.ravel())
        for kind in (MINIMUM, MAXIMUM, CONSTANT):
            for own, other in zip(extrema(many, kind), extrema(one, kind), strict=True):
                values = [np.unique(np.round(each, 6)) for each in (own, other)]
                np.testing.assert_allclose(*values, atol=2e-6)
        for name in ("radius_min", "radius_max"):
            np.testing.assert_allclose(many[name].values.ravel(), one[name].values.ravel(),
                                       atol=1e-7)  # fmt: skip


def test_extrema_of_ellipses_are_their_half_axes():
    """``|a| + |b|`` and ``||a| - |b||`` of the forward and backward whirls at each node."""
    system, speeds = chain(stiffer=1.5), [0.7, 1.3]
    found = bifurcation_diagram(system, speed=speeds, revolutions=10)
    assert found.extremum_count.dims == ("speed", "start", "node")
    for node in (0, 1):
        low, high = (extrema(found, kind, node) for kind in (MINIMUM, MAXIMUM))
        for number, speed in enumerate(speeds):
            forward, backward = (abs(each[node]) for each in response(system, speed))
            assert len(high[number]) == pytest.approx(20, abs=1)
            np.testing.assert_allclose(high[number], forward + backward, rtol=1e-9)
            np.testing.assert_allclose(low[number], abs(forward - backward), rtol=1e-7)


def test_once_a_revolution_a_linear_response_is_one_point():
    system = chain()
    found = bifurcation_diagram(system, speed=[0.7, 1.3], at="revolution", revolutions=6, phase=0.5)
    assert found.rotating_x.dims == ("speed", "start", "crossing", "node")
    for number, speed in enumerate((0.7, 1.3)):
        point = (found.rotating_x + 1j * found.rotating_y).isel(speed=number, start=0)
        whirl = np.broadcast_to(response(system, speed)[0], (6, 2))
        np.testing.assert_allclose(point, whirl, atol=1e-9)


@pytest.mark.parametrize("phase", [0.0, 2.0])
def test_a_disc_and_the_same_as_a_system_have_one_stroboscopic_section(phase):
    """Of a whirl in contact the exact point, and of two revolutions two."""
    given = {"at": "revolution", "revolutions": 6, "phase": phase}
    disc = bifurcation_diagram(JUMPING, omega=[0.8, 1.2], starts=[REST], **given)
    system = bifurcation_diagram(JUMPING.system(), speed=[0.8, 1.2], **given)
    whirls = synchronous_response(JUMPING, omega=[0.8, 1.2]).isel(branch=0).squeeze()
    exact = (whirls.amplitude * np.exp(-1j * whirls.phase_lag)).values
    assert whirls.in_contact.values.tolist() == [1, 1]
    for found in (disc, system):
        point = (found.rotating_x + 1j * found.rotating_y).squeeze().transpose("crossing", ...)
        assert point.sizes["crossing"] == (6 if phase else 7)
        np.testing.assert_allclose(point, np.broadcast_to(exact, point.shape), atol=1e-8)
    twice = bifurcation_diagram(LOADED, starts=[REST], **given)
    again = bifurcation_diagram(LOADED.system(), speed=2.0, starts=[ON_AXIS], **given)
    points = [states(found.squeeze())[:, :] for found in (twice, again)]
    section = poincare_section(
        LOADED, start=REST, revolutions=6, skip=300, phase=phase, method="taylor"
    )
    for each in points:
        np.testing.assert_allclose(each[2:], each[:-2], atol=1e-9)
        order = np.argsort(states(section)[:2, 0])
        np.testing.assert_allclose(each[:2][np.argsort(each[:2, 0])], states(section)[:2][order],
                                   atol=1e-7)  # fmt: skip


def test_up_and_down_jumps_appear_where_those_of_the_sweep_do():
    system, speeds = JUMPING.system(), [1.0, 1.4, 1.8, 2.2]
    found = bifurcation_diagram(system, speed=speeds, direction="both", revolutions=4)
    swept = sweep(system, speed=speeds, direction="both")
    assert found.response.dims == ("speed", "start", "direction")
    np.testing.assert_array_equal(found.response, swept.response)
    np.testing.assert_array_equal(found.radius_max, swept.radius_max)
    steady = found.extremum_count == 1
    radius = found.extremum_radius.values[found.extremum_row.values[steady.values]]
    np.testing.assert_allclose(radius, swept.radius_max.values[steady.values[..., 0]].ravel(),
                               rtol=1e-8)  # fmt: skip
    up, down = found.radius_max.isel(contact=0, start=0).values.T
    assert np.abs(up - down).max() > 1.0  # a fold lies between


@pytest.mark.parametrize(("name", "values"), [("friction", [0.0, 0.2]), ("clearance", [2.0, 3.0])])
def test_any_parameter_of_a_system_may_vary(name, values):
    """Each point is what it is alone."""
    given = {"speed": 1.1, "at": "revolution", "revolutions": 3}
    both = bifurcation_diagram(TOUCHING, **given, **{name: values}, direction="up")
    assert both.attrs["along"] == name
    assert both.rotating_x.dims == ("speed", name, "start", "direction", "crossing", "node")
    alone = bifurcation_diagram(TOUCHING, **given, **{name: values[0]})
    np.testing.assert_array_equal(both.rotating_x.isel({name: 0, "direction": 0}),
                                  alone.rotating_x)  # fmt: skip
    assert alone[name].item() == values[0]
    assert "long_name" in both[name].attrs


@pytest.mark.parametrize("name", ["distance_extrema", "crossings_of"])
def test_a_point_that_cannot_be_followed_on_has_failed(monkeypatch, name):
    real = getattr(diagram_module, name)

    def stuck(flow, *given):
        if flow.speed == 1.1:
            raise SimulationError("stuck", time=0.5, state=(0.0, 0.0, 0.0, 0.0))
        return real(flow, *given)

    monkeypatch.setattr(diagram_module, name, stuck)
    at = "revolution" if name == "crossings_of" else "extrema"
    found = bifurcation_diagram(TOUCHING, speed=[1.0, 1.1], at=at, revolutions=3)
    assert found.status.values.ravel().tolist() == [STATUS["done"], STATUS["failed"]]
    assert found.message.values.ravel()[1].startswith("stuck")
    shown = found.rotating_x.notnull() if at == "revolution" else found.extremum_count > 0
    assert shown.all(["start", *shown.dims[2:]]).values.tolist() == [True, False]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"speed": None}, "speed must be given for a diagram of a rotor system, got None"),
        ({"speed": [1.0, 0.0]}, "speed must not be 0 in a diagram of a rotor system, got 0.0"),
        ({"x": (0.0, 1.0)}, r"x must be left out with a rotor system, got \(0.0, 1.0\)"),
        ({"rate": 0.1, "direction": "up"}, "rate must be left out with a rotor system, got 0.1"),
        ({"extrema_time": 9.0}, "extrema_time must be left out with a rotor system, got 9.0"),
        ({"seed": 3}, "seed must be left out with a rotor system, got 3"),
        ({"starts": 8}, r"starts must be a list of \(q, velocity\), .* got 8"),
        ({"phase": 1.0}, "phase must be left out with at='extrema', got 1.0"),
        ({"at": "entry"}, "at must be one of 'extrema', 'revolution', got 'entry'"),
        ({"revolutions": 0}, "revolutions must be at least 1, got 0"),
        ({"method": "bdf"}, "method must be taylor for a diagram of a rotor system, got 'bdf'"),
        ({"atol": 1e-9}, "atol must be left out with a rotor system, got 1e-09"),
    ],
)
def test_what_a_system_does_not_have_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        bifurcation_diagram(TOUCHING, **{"speed": [1.0, 1.1], **wrong})
    with pytest.raises(TypeError, match="got an unexpected keyword argument 'omega'"):
        bifurcation_diagram(TOUCHING, speed=1.0, omega=1.0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"revolutions": 3}, "revolutions must be left out with at='extrema', got 3"),
        ({"phase": 1.0}, "phase must be left out with at='extrema', got 1.0"),
        ({"at": "revolution", "extrema_time": 3.0},
         "extrema_time must be left out with at='revolution', got 3.0"),
        ({"at": "revolution", "rate": 0.1, "direction": "up"},
         "rate must be left out with at='revolution', got 0.1"),
        ({"at": "revolution", "phase": 7.0}, "phase must be below 2 pi, got 7.0"),
        ({"at": "revolution", "omega": [0.0, 1.0]}, "omega must be positive for a section, got 0"),
        ({"at": "revolution", "revolutions": 10**7}, "must be|at most"),
        ({"modes": 3}, "modes must be left out with one disc, got 3"),
        ({"contacts": []}, r"contacts must be left out with one disc, got \[\]"),
        ({"speed": 2.0}, "speed must be left out with one disc, got 2.0"),
    ],
)  # fmt: skip
def test_what_one_disc_does_not_have_is_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        bifurcation_diagram(DISC, **{"omega": [1.2, 2.0], "starts": [REST], **wrong})
