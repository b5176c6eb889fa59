"""Speed maps of rotor systems: responses at their amplitudes, exact whirls beneath."""

import numpy as np
import pytest

from rotor_ida import (
    Contact,
    InputError,
    RotorSystem,
    Unbalance,
    decode_flags,
    plot,
    sweep,
    synchronous_response,
)
from rotor_ida.plot.figures import figure_of
from tests.plot.pictures import lines_of, words_of

SPEEDS = np.array([0.9, 1.1, 1.5])


def two_discs(stiffer=1.0):
    stiffness = np.kron([[2.0, -1.0], [-1.0, 2.0]], np.diag([1.0, stiffer]))
    system = RotorSystem(
        mass=np.eye(4), stiffness=stiffness, damping=0.1 * stiffness,
        nodes={"one": (0, 1), "two": (2, 3)}, units="1",
    )  # fmt: skip
    contacts = [Contact(node=name, clearance=clearance, stiffness=3.0, exponent=1.0)
                for name, clearance in (("one", 3.0), ("two", 0.8))]  # fmt: skip
    around = {"contacts": contacts, "unbalance": [Unbalance(node="one", moment=0.4)]}
    return system, around


@pytest.fixture(scope="module")
def swept():
    system, around = two_discs()
    found = sweep(system, **around, speed=SPEEDS, direction="up")
    words = decode_flags(found.response).values.ravel().tolist()
    assert words == ["contact_free", "synchronous", "bouncing"]
    return found


def test_steady_responses_are_marks_and_others_bars_over_their_range(swept):
    ax = plot.plot_amplitude(None, simulated=swept, contact=1)
    assert ax.get_title() == "contact 1 at two"
    assert ax.get_xlabel() == r"spin speed $\omega$"
    seen = np.concatenate([line.get_xydata() for line in ax.lines if line.get_marker() == "^"])
    amplitude = swept.amplitude.isel(contact=1).values.ravel()
    for number in (0, 1):
        assert [SPEEDS[number], amplitude[number]] in seen.tolist()
    (bar,) = ax.collections[0].get_segments()
    low, high = (swept[name].isel(contact=1).values.ravel()[2] for name in
                 ("radius_min", "radius_max"))  # fmt: skip
    assert bar.tolist() == [[1.5, low], [1.5, high]]
    assert "bouncing: range of $|z|$" in words_of(ax)
    with pytest.raises(InputError, match="contact must be one of 0 to 1, got 2"):
        plot.plot_amplitude(None, simulated=swept, contact=2)


def test_the_exact_whirls_beneath_are_those_of_the_system(swept):
    first, second = figure_of(swept).axes
    assert first.get_title() == "contact 0 at one"
    lines = lines_of(second)
    stable = lines["stable whirl"].get_xydata()
    system, around = two_discs()
    exact = synchronous_response(system, **around, speed=stable[:4, 0])
    np.testing.assert_allclose(stable[:4, 1], exact.amplitude[:, 0, 1], rtol=1e-12)
    assert "unstable whirl" in lines


def test_without_axial_symmetry_there_is_nothing_beneath():
    system, around = two_discs(stiffer=1.2)
    found = sweep(system, **around, speed=[0.8, 0.9])
    assert not any("whirl" in label for label in lines_of(figure_of(found).axes[0]))


def test_under_weight_all_responses_are_ranges_of_the_distance_from_the_centre():
    mass, damping, stiffness, moment, weight = 2.0, 0.3, 4.0, 0.4, 2.0
    system = RotorSystem(
        mass=mass * np.eye(2), stiffness=stiffness * np.eye(2), damping=damping * np.eye(2),
        nodes={"disc": (0, 1)}, contacts=[Contact(node="disc", clearance=2.0, stiffness=3.0)],
        unbalance=[Unbalance(node="disc", moment=moment)], gravity=(0.0, -weight), units="1",
    )  # fmt: skip
    found = sweep(system, speed=[0.5, 1.5])
    assert decode_flags(found.response).values.ravel().tolist() == ["contact_free", "bouncing"]
    ax = plot.plot_amplitude(None, simulated=found)
    assert ax.get_ylabel() == "radius $|z|$"
    (free,), (rub,) = (bars.get_segments() for bars in ax.collections)
    sag = mass * weight / stiffness
    whirl = abs(moment * 0.5**2 / (stiffness - mass * 0.5**2 + 0.5j * damping))
    np.testing.assert_allclose(free[:, 1], [sag - whirl, sag + whirl], rtol=1e-6)
    assert rub[1, 1] > 2.0 > free[1, 1]
    assert {word for word in words_of(ax) if "range" in word} == {
        "contact-free response: range of $|z|$", "bouncing: range of $|z|$"
    }  # fmt: skip
