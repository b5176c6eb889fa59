"""The numbers of the page of errata are those of the physics, each computed anew."""

import cmath
from pathlib import Path

import numpy as np
import pytest

from rotor_ida import DimensionalRotor, Rotor, simulate, sweep, synchronous_response
from rotor_ida.closed_forms import (
    amplitude_from_speed,
    circular_period,
    cusp,
    eigenvalues,
    peaks,
    planar_period,
    restoring_field,
)
from rotor_ida.model.equations import energy, rotating_jacobian
from rotor_ida.paper.printed import (
    amplitudes_18,
    amplitudes_29,
    general_solution,
    hamiltonian,
    phase_23,
    phase_31,
    transfer_21,
)
from rotor_ida.schema import RESPONSE
from tests.scenarios import scenario

PAGE = Path(__file__).parents[2] / "docs" / "errata.md"
OF_WHIRLS = {"omega": 1.7, "zeta": 0.07}
WITH_CLEARANCE = {"omega": 1.2, "zeta": 0.07, "delta0": 0.5}


def run_of(start, omega=1.7, zeta=0.07, delta0=0.0, **how):
    return simulate(Rotor(omega=omega, zeta=zeta, delta0=delta0), start=start, **how)


def states_of(run):
    return np.stack([run[name].values for name in ("x", "y", "vx", "vy")], axis=-1)


def whirls():
    return synchronous_response(**OF_WHIRLS, delta0=0.0).squeeze(drop=True)


def dissipation():
    run = run_of((2.0, 0.0, 0.0, 0.5), omega=0.0, duration=20.0, samples=20001)
    before, *_, after = energy(states_of(run), 0.0)
    taken = 2.0 * 0.07 * float((run.vx**2 + run.vy**2).integrate("t"))
    return [f"{(before - after) / taken:.6f}"]


def scaling():
    machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6,
                               clearance=2e-6, speed=600.0)  # fmt: skip
    module = scenario("dimensional_example")
    right, printed = module.deviations(module.check_scaling(machine, duration=20.0)).values()
    assert right < 5e-12
    assert printed > 1.0
    return ["5e-12"]


def force():
    field = restoring_field(x=[1.0], y=[0.0, 2.0], delta0=0.5).restoring_x.values.ravel()
    line = np.linspace(-3.0, 3.0, 121)
    rise = restoring_field(x=line, y=line, delta0=[0.0, 0.5]).restoring_x.diff("x")
    assert rise.min() >= 0.0
    return [f"{each:.4f}" for each in field]


def curvature():
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.5)
    return [
        f"{each:.4f}"
        for each in np.linalg.eigvalsh(-rotating_jacobian((1.5, 0, 0, 0), rotor)[2:, :2])
    ]


def conserved():
    run = run_of((2.0, 0.0, 0.3, 0.25), 0.0, 0.0, 0.5, duration=40.0, samples=801)
    right, printed = (of(states_of(run), 0.5) for of in (energy, hamiltonian))
    assert abs(right / right[0] - 1.0).max() < 1e-8
    return ["1e-08", f"{printed.min():.3f}", f"{printed.max():.2f}"]


def portraits():
    longer = 100.0 * (planar_period(1.0) / circular_period(1.0) - 1.0)
    return [f"{longer:.3f}", f"{amplitude_from_speed(8.0):.5f}"]


def phases():
    small = whirls().isel(branch=0)
    A = small.amplitude.item()
    H = transfer_21(A, **OF_WHIRLS)
    assert abs(H) == pytest.approx(A, rel=1e-12)
    numbers = (cmath.phase(H), phase_23(A, **OF_WHIRLS), small.phase_lag.item(), abs(H))
    return [f"{each:.5f}" for each in numbers]


def transient():
    start, found = (10.0, 0.0, 0.0, 0.0), []
    run = run_of(start, duration=5.0, samples=501)
    A = float(whirls().amplitude[2])
    for mended in (False, True):
        printed = general_solution(run.t, start=start, **OF_WHIRLS, amplitude=A, mended=mended)
        error = abs(run.x.values + 1j * run.y.values - printed)
        found += [f"{error[-1]:.2f}", f"{run.t.values[np.argmax(error > 1.0)]:.2f}"]
    return found


def with_clearance_29():
    A = synchronous_response(Rotor(**WITH_CLEARANCE)).amplitude.item()
    return [f"{each:.5f}" for each in (*amplitudes_29(**WITH_CLEARANCE), A)]


def with_clearance_31():
    whirl = synchronous_response(Rotor(**WITH_CLEARANCE))
    lags = (phase_31(whirl.amplitude.item(), **WITH_CLEARANCE), whirl.phase_lag.item())
    return [f"{lag:.5f}" for lag in lags]


def unstable():
    A = float(whirls().amplitude[1])
    rates = eigenvalues(A, **OF_WHIRLS, delta0=0.0)
    return [f"{A:.5f}", f"{rates.real.max():.5f}"]


def cusps():
    anywhere = cusp()
    return [f"{cusp(delta0=0.0).cusp_zeta.item():.9f}", f"{anywhere.cusp_zeta.item():.6f}",
            f"{anywhere.delta0.item():.4f}"]  # fmt: skip


def reached(x, y, duration=300.0):
    end = run_of((x, y, 0.0, 0.0), duration=duration, samples=2).isel(t=-1)
    return float(np.hypot(end.x, end.y))


def basin_cuts():
    line = np.linspace(-12.0, 12.0, 17)
    across = np.array([reached(x, 0.0, 120.0) < 5.0 for x in line])
    up = np.array([reached(0.0, y, 120.0) < 5.0 for y in line])
    assert np.diff(across).sum() == np.diff(up).sum() == 2
    return [f"{each:.1f}" for cut in (across, up) for each in (line[cut].min(), line[cut].max())]


def clearance():
    last = peaks(zeta=0.07, delta0=[0.0, 2.0]).peak_amplitude.values.ravel()
    slow = synchronous_response(omega=1.2, zeta=0.07, delta0=[0.0, 0.5, 1.0, 2.0])
    return [f"{each:.2f}" for each in last] + [
        f"{each:.3f}" for each in slow.amplitude.max("branch").values.ravel()
    ]


def agreement():
    found = sweep(omega=[0.75, 1.0, 1.25, 1.5, 2.0], zeta=0.07, delta0=2.0).squeeze()
    exact = synchronous_response(omega=found.omega.values, zeta=0.07, delta0=2.0)
    there = int((exact.in_contact == 1).any("branch").sum())
    last = found.isel(omega=-1)
    assert last.response == RESPONSE["bouncing"]
    synchronous = int((found.response == RESPONSE["synchronous"]).sum())
    return [f"{there} of {found.sizes['omega']}", f"reached at {synchronous}",
            f"{float(last.radius_min):.1f}", f"{float(last.radius_max):.1f}"]  # fmt: skip


# The numbers in the evidence of each row, in their order.
NUMBERS = {
    "(3)": dissipation,
    "(9)": scaling,
    "(11), Fig. 2": force,
    "Fig. 3": curvature,
    "(13)": conserved,
    "(17), 3.2": lambda: [f"{circular_period(A):.5f}" for A in (2.0, 8.0)],
    "Fig. 5": portraits,
    "(18)": lambda: [f"{A:.5f}" for A in (*amplitudes_18(**OF_WHIRLS), *whirls().amplitude)],
    "(20)-(23)": phases,
    "(24)-(28)": transient,
    "(29)": with_clearance_29,
    "(31)": with_clearance_31,
    "4.1.2": unstable,
    "Fig. 6": cusps,
    "Fig. 7": basin_cuts,
    "Figs 8, 9": lambda: [f"{reached(x, 0.0):.5f}" for x in (0.0, 10.0)],
    "4.2.1": clearance,
    "Fig. 11": agreement,
}  # fmt: skip
ROWS = {
    cells[0]: cells[3] for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("| ") and len(cells := line.strip("| ").split(" | ")) == 4
}  # fmt: skip


def test_every_row_of_the_page_is_computed():
    assert ROWS.keys() - {"place"} == NUMBERS.keys()


@pytest.mark.parametrize("place", NUMBERS)
def test_the_numbers_of_a_row_are_those_computed(place):
    at = 0
    for number in NUMBERS[place]():
        at = ROWS[place].find(number, at)
        assert at >= 0, f"{number} in {ROWS[place]!r}"
        at += len(number)
