"""Diagrams of run-ups and run-downs: extrema against samples, and the quasi-static limit."""

import numpy as np
import pytest

from rotor_ida import Rotor, SimulationError, bifurcation_diagram, run_up
from rotor_ida.closed_forms import late_jumps
from rotor_ida.plot import plot_extrema
from rotor_ida.schema import RESPONSE, STATUS
from rotor_ida.steady import bifurcation_diagram as diagram_module
from rotor_ida.steady.ramp_extrema import ramp_extrema

GO_ON = np.zeros(1, np.uint8)
REST = (0.0, 0.0, 0.0, 0.0)
JUMPS = {"zeta": 0.07, "delta0": 0.5}
FRICTION = {"zeta": 0.1, "delta0": 1.0, "friction": 0.2, "disc_radius": 10.0}


@pytest.mark.parametrize(
    ("machine", "start", "speeds", "rate"),
    [
        ({"zeta": 0.07, "delta0": 2.0}, (4.0, 0.0, 0.0, 0.0), [2.0, 2.1, 2.3], 0.01),
        ({"zeta": 0.07, "delta0": 2.0}, (4.0, 0.0, 0.0, 0.0), [2.3, 2.1, 2.0], 0.01),
        (FRICTION, (5.0, 0.0, 0.0, -6.3), [0.63, 0.7, 0.8], 0.01),
        (
            {"zeta": 0.05, "delta0": 1.0, "shaft_stiffness": 0.25, "load": 0.5},
            REST,
            [1.5, 1.9],
            0.02,
        ),
    ],
)
def test_extrema_are_those_of_a_sampled_run_up(machine, start, speeds, rate):
    speeds, rotor = np.array(speeds), Rotor(omega=speeds[0], **machine)
    passages = ramp_extrema(rotor, start, speeds, rate, 1e-11, GO_ON)
    run = run_up(
        rotor, start=start, to=speeds[-1], rate=np.sign(speeds[-1] - speeds[0]) * rate,
        samples=20_001, method="taylor",
    )  # fmt: skip
    radius, motion = np.hypot(run.x.values, run.y.values), run.speed.values
    rising = run.x.values * run.vx.values + run.y.values * run.vy.values
    turns = np.flatnonzero(np.diff(np.sign(rising[1:]))) + 2  # it begins with none
    met, radii = (
        np.concatenate([each.events[f"extremum_{name}"] for each in passages])
        for name in ("speed", "radius")
    )
    assert met.size == turns.size > 10
    step = np.abs(np.diff(motion)).max()
    assert np.abs(met - motion[turns]).max() <= 1.01 * step
    np.testing.assert_allclose(radii, radius[turns], atol=2e-3)
    assert min(each.figures["radius_min"] for each in passages) == pytest.approx(
        radius.min(), abs=1e-4
    )
    assert max(each.figures["radius_max"] for each in passages) == pytest.approx(
        radius.max(), abs=1e-5
    )


def test_as_the_rate_falls_a_run_up_becomes_quasi_static():
    """What is off falls in proportion to the rate."""
    speeds = [0.8, 1.0, 1.2]
    given = {"omega": speeds, **JUMPS, "starts": [REST], "direction": "up", "method": "taylor"}
    slow = bifurcation_diagram(**given)
    assert slow.extremum_count.values.ravel().tolist() == [1, 1, 1]
    off = []
    for rate in (1e-3, 1e-4, 1e-5):
        found = bifurcation_diagram(**given, rate=rate)
        assert found.extremum_count.dims == slow.extremum_count.dims
        assert found.response.equals(slow.response)
        assert found.extremum_speed.values.tolist() == speeds
        off.append(np.abs(found.extremum_radius.values - slow.extremum_radius.values)[1:].max())
    assert off[1] / off[2] == pytest.approx(10.0, rel=0.05)
    assert off[0] > off[1] > off[2]


def test_run_ups_and_run_downs_jump_beyond_the_folds_and_late():
    speeds, rate = np.linspace(1.0, 2.4, 71), 1e-3
    found = bifurcation_diagram(
        omega=speeds, **JUMPS, starts=[REST], direction="both", rate=rate, method="taylor"
    )
    law = late_jumps(rate=rate, **JUMPS).squeeze()
    for place, fold in ((0, 3), (1, 2)):
        radius = found.radius_max.isel(direction=place).values.ravel()
        jump = speeds[radius > 3.0].max()  # the whirls at the folds are 2.0 and 13.1
        late = abs(jump - law.fold_omega.values[fold])
        expected = abs(law.jump_omega - law.fold_omega).values[fold]
        # what the law leaves, some tens of the rate, and the step between speeds
        assert abs(late - expected) < 0.05
        assert late > 0.3 * expected


def test_a_diagram_has_every_axis_start_and_direction():
    axes = {"omega": [1.0, 1.5, 2.0], "zeta": [0.07, 0.2], "delta0": 0.5, "friction": [0.0, 0.1]}
    how = {"rate": 0.02, "disc_radius": 5.0, "method": "taylor", "direction": "both"}
    starts = [REST, (4.0, 0.0, 0.0, 4.0)]
    both = bifurcation_diagram(**axes, **how, starts=starts)
    assert both.radius_max.dims == ("omega", "zeta", "delta0", "friction", "start", "direction")
    assert both.radius_max.shape == (3, 2, 1, 2, 2, 2)
    assert both.extremum_count.sum() == both.sizes["extremum"]
    assert both.attrs["rate"] == 0.02
    place = {"zeta": 1, "delta0": 0, "friction": 1, "start": 1, "direction": 1}
    alone = bifurcation_diagram(
        omega=axes["omega"], zeta=0.2, delta0=0.5, friction=0.1, starts=starts[1:],
        **(how | {"direction": "down"}),
    )  # fmt: skip
    np.testing.assert_array_equal(alone.radius_max.values.ravel(), both.radius_max.isel(place))
    ends = np.cumsum(both.extremum_count.values.ravel()).reshape(both.extremum_count.shape)
    for omega in range(3):
        at = tuple({"omega": omega, **place}[name] for name in both.radius_max.dims)
        rows = slice(ends[at] - both.extremum_count.values[at], ends[at])
        counts = np.cumsum(alone.extremum_count.values.ravel())
        own = slice(counts[omega] - alone.extremum_count.values.ravel()[omega], counts[omega])
        for name in ("extremum_radius", "extremum_speed", "extremum_kind"):
            np.testing.assert_array_equal(both[name].values[rows], alone[name].values[own])


def test_what_the_rotor_does_near_a_speed_is_told_by_its_radius():
    found = bifurcation_diagram(
        omega=[1.6, 1.8, 2.0, 2.2], zeta=0.07, delta0=2.0, starts=[REST, (4.0, 0.0, 0.0, 0.0)],
        direction="down", rate=1e-3, method="taylor",
    )  # fmt: skip
    words = found.response.isel(zeta=0, delta0=0, direction=0).values
    assert (words[:, 0] == RESPONSE["contact_free"]).all()
    assert words[-1, 1] == RESPONSE["bouncing"]
    ax = plot_extrema(found)
    drawn = np.concatenate([line.get_xdata() for line in ax.lines if line.get_rasterized()])
    assert set(np.round(found.extremum_speed.values, 9)) == set(np.round(drawn, 9))


def test_a_run_that_cannot_be_followed_has_failed(monkeypatch):
    def stuck(rotor, start, **_):
        raise SimulationError("stuck", time=0.5, state=start)

    monkeypatch.setattr(diagram_module, "ramp_extrema", stuck)
    found = bifurcation_diagram(
        omega=[1.0, 1.2], zeta=0.5, delta0=0.0, starts=[REST], direction="up", rate=0.1
    )
    assert (found.status == STATUS["failed"]).all()
    assert found.message.values.ravel()[0].startswith("stuck (at t = 0.5")
    assert found.sizes["extremum"] == 0
    assert found.radius_max.isnull().all()
