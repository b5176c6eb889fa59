"""The warning of contacts that are pressed in too far, for each kind of result."""

import re
from dataclasses import replace

import numpy as np

from rotor_ida import (
    Contact,
    DimensionalRotor,
    RotorSystem,
    Unbalance,
    bifurcation_diagram,
    campbell,
    poincare_section,
    run_up,
    run_ups,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.cli.describe import describe
from rotor_ida.results.depths import beyond_model

# A resonance at 100 rad/s, where the rotor would go as far as 25 mm: 10 N over 400 N s/m * rad/s.
DISC = RotorSystem(mass=np.eye(2), damping=4.0 * np.eye(2), stiffness=1e4 * np.eye(2),
                   nodes={"disc": (0, 1), "end": (0, 1)})  # fmt: skip
SOFT = Contact(node="disc", clearance=2e-4, stiffness=100.0, exponent=1.0)
WIDE = Contact(node="end", clearance=30e-3, stiffness=100.0, exponent=1.0)
AROUND = {"contacts": [WIDE, SOFT], "unbalance": [Unbalance(node="disc", moment=1e-3)]}


def results(system, **around):
    """Yield a result of each kind that knows how far the soft contact is pressed in."""
    run = simulate(system, **around, speed=100.0, duration=3.0, samples=2)
    yield run, run.peak_indentation.max()
    run = run_up(system, **around, speed=50.0, to=100.0, rate=20.0, duration=6.0, samples=2)
    yield run, run.peak_indentation.max()
    found = sweep(system, **around, speed=[100.0])
    yield found, found.radius_max.max() - SOFT.clearance
    whirls = synchronous_response(system, **around, speed=[100.0])
    yield whirls, whirls.amplitude.max() - SOFT.clearance


def test_every_result_of_a_system_tells_that_it_is_beyond_the_model():
    for found, deep in results(DISC, **AROUND):
        said = (
            f"Beyond the model: contact 1 at 'disc' is indented by up to {1e3 * float(deep):.3g} "
            "mm, more than the clearance; such a force is too large for the contact law to predict."
        )
        assert beyond_model(found) == said
        assert describe(found)[1][-1] == said


PUMP = DimensionalRotor(
    mass=12.0, contact_stiffness=1e5, contact_exponent=1.0, damping=400.0, eccentricity=2e-5,
    clearance=1.5e-4, speed=600.0, shaft_stiffness=4e6, friction=0.1, disc_radius=0.06,
)  # fmt: skip


def test_every_result_of_one_disc_tells_that_it_is_beyond_the_model():
    """A run goes as deep as the same rotor does as a system; others by their radii."""
    run = simulate(PUMP, start=(1e-3, 0.0, 0.0, 0.0), duration=0.05)
    as_system = simulate(PUMP.system(), speed=600.0, start=([1e-3, 0.0], [0.0, 0.0]), duration=0.05)
    both = [beyond_model(each) for each in (run, as_system)]
    depth = re.search(r"up to (.* um), more than the clearance", both[1])[1]
    assert both[0] == (
        f"Beyond the model: an indentation of {depth} is more than the clearance; such a force is "
        "too large for the contact law to predict."
    )
    at = replace(PUMP, speed=577.0)  # at its resonance
    found = sweep(at)
    diagram = bifurcation_diagram(at, starts=[(0.0, 0.0, 0.0, 0.0)], extrema_time=0.5)
    section = poincare_section(at, revolutions=3, skip=100)
    deep = float(found.radius_max.max()) - PUMP.clearance
    for each in (found, diagram, section):
        assert f"an indentation of {1e6 * deep:.3g} um is more than the cl" in beyond_model(each)
        assert describe(each)[1][-1] == beyond_model(each)
    assert beyond_model(simulate(PUMP, duration=0.01)) == ""


def test_the_indentation_is_that_of_the_closed_form():
    """At the resonance |400 i (d + 0.2 mm) + 100 d| = 10, a quadratic equation."""
    whirls = synchronous_response(DISC, **AROUND, speed=[100.0])
    a, b, c = 1.7e5, 2.0 * 1.6e5 * 2e-4, 1.6e5 * 4e-8 - 100.0
    deep = (-b + np.sqrt(b * b - 4.0 * a * c)) / (2.0 * a)
    assert f"by up to {1e3 * deep:.3g} mm" in beyond_model(whirls)


def test_a_stiff_contact_and_a_diagram_are_within_the_model():
    stiff = replace(SOFT, stiffness=1e6)
    whirls = synchronous_response(DISC, **AROUND | {"contacts": [WIDE, stiff]}, speed=[100.0])
    assert (whirls.in_contact == 1).any()
    assert beyond_model(whirls) == beyond_model(campbell(DISC, speed=[100.0])) == ""


def test_without_units_only_the_radius_is_a_bound():
    """As for one disc: an eccentricity says nothing about sizes."""
    system = replace(DISC, units="1")
    for radius, bound in ((None, ""), (0.2, "a tenth of the rotor's radius"), (0.3, "")):
        contacts = [replace(SOFT, radius=radius)]
        found = synchronous_response(system, **AROUND | {"contacts": contacts}, speed=[100.0])
        assert beyond_model(found).partition("more than ")[2].partition(";")[0] == bound


def test_run_ups_tell_how_far_the_passage_of_the_resonance_presses_in():
    """By the largest force: at the last speed the disc is clear of the stator again."""
    found = run_ups(replace(PUMP, speed=500.0), to=900.0, rate=[40.0])
    depth = found.largest_force.item() / PUMP.contact_stiffness
    assert found.radius_max.item() < PUMP.clearance < depth
    assert beyond_model(found).startswith(
        f"Beyond the model: an indentation of {1e6 * depth:.3g} um is more than the clearance"
    )
