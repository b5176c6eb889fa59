import numpy as np
import pytest

from rotor_ida import DimensionalRotor, InputError, dimensional, simulate
from rotor_ida.plot import plot_machine

MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                           clearance=2e-6, speed=1000.0)  # fmt: skip


@pytest.fixture(scope="module")
def machine():
    run = simulate(MACHINE.rotor(), start=(0, 0, 0, 0), duration=40.0, samples=2001)
    return dimensional(run, MACHINE)


def test_axes_are_in_the_units_of_the_workshop(machine):
    orbit, history, force = plot_machine(machine).axes
    assert orbit.get_xlabel() == "displacement $X$ [µm]"
    assert history.get_ylabel() == "radius $|Z|$ [µm]"
    assert force.get_xlabel() == "time $T$ [ms]"
    assert force.get_ylabel() == "contact force $F$ [N]"
    assert history.lines[0].get_xdata()[-1] == pytest.approx(1e3 * 40.0 * MACHINE.time_scale)


def test_force_is_k_times_the_indentation_to_the_three_halves(machine):
    line, peaks = plot_machine(machine).axes[2].lines
    radius = np.hypot(machine.x.values, machine.y.values)
    newtons = MACHINE.contact_stiffness * np.maximum(radius - MACHINE.clearance, 0.0) ** 1.5
    assert np.isclose(line.get_ydata().max(), newtons.max(), rtol=1e-9)
    # peaks are found between the samples and so never lie below them
    assert peaks.get_ydata().max() >= newtons.max() * (1.0 - 1e-12)
    assert peaks.get_ydata().max() == pytest.approx(newtons.max(), rel=1e-3)


def test_dimensionless_run_is_refused(run):
    with pytest.raises(InputError, match="run must be in SI units"):
        plot_machine(run)
