"""Numbers of the errata, computed for each statement or formula of the paper."""

from __future__ import annotations

import cmath

import numpy as np
import xarray as xr

from rotor_ida.checks import COMPONENTS
from rotor_ida.closed_forms import (
    amplitude_from_speed,
    circular_period,
    cusp,
    eigenvalues,
    peaks,
    planar_period,
    restoring_field,
    synchronous_response,
)
from rotor_ida.model.equations import energy, jacobian
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from rotor_ida.paper.errata.scaling import PRINTED, RIGHT, check_scaling, deviations
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
from rotor_ida.simulation.simulate import simulate
from rotor_ida.steady.sweep import sweep

Numbers = dict[str, float]

SPEED, DAMPING = 1.7, 0.07
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=600.0
)


def dissipation() -> Numbers:
    """Eq. (3): energy lost over that of viscous damping."""
    rotor = Rotor(omega=0.0, zeta=DAMPING, delta0=0.0)
    run = simulate(rotor, start=(2.0, 0.0, 0.0, 0.5), duration=20.0, samples=20001)
    states = _states(run)
    taken = 2.0 * DAMPING * float((run["vx"] ** 2 + run["vy"] ** 2).integrate("t"))
    lost = float(energy(states[0], 0.0) - energy(states[-1], 0.0))
    return {"ratio": lost / taken}


def scaling() -> Numbers:
    """Eq. (9): relative error of scaled runs against the dimensional equation."""
    apart = deviations(check_scaling(MACHINE, duration=20.0))
    return {"right": apart[RIGHT], "printed": apart[PRINTED]}


def force() -> Numbers:
    """Eq. (11): f_x at one x and two y, and its least slope over the plane."""
    field = restoring_field(x=[1.0], y=[0.0, 2.0], delta0=0.5)["restoring_x"].values.ravel()
    line = np.linspace(-3.0, 3.0, 121)
    rise = restoring_field(x=line, y=line, delta0=[0.0, 0.5])["restoring_x"].diff("x")
    return {"below": field[0], "above": field[1], "least_rise": float(rise.min())}


def curvature() -> Numbers:
    """Fig. 3: the two curvatures of the potential at r = 1.5, delta0 = 0.5."""
    stiffness = -jacobian((1.5, 0.0, 0.0, 0.0), Rotor(omega=0.0, zeta=0.0, delta0=0.5))[2:, :2]
    low, high = np.linalg.eigvalsh(stiffness)
    return {"low": float(low), "high": float(high)}


def conserved() -> Numbers:
    """Eq. (13): variation of the correct and the printed sum along a free orbit."""
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=0.5)
    run = simulate(rotor, start=(2.0, 0.0, 0.3, 0.25), duration=40.0, samples=801)
    states = _states(run)
    right, printed = energy(states, 0.5), hamiltonian(states, 0.5)
    return {
        "drift": float(abs(right / right[0] - 1.0).max()),
        "lowest": float(printed.min()),
        "highest": float(printed.max()),
    }


def periods() -> Numbers:
    """Eq. (17) and 3.2: periods on a circle."""
    return {"small": circular_period(2.0), "large": circular_period(8.0)}


def portraits() -> Numbers:
    """Fig. 5: excess of the planar period, and amplitude from a start with speed."""
    longer = 100.0 * (planar_period(1.0) / circular_period(1.0) - 1.0)
    return {"longer": longer, "reached": amplitude_from_speed(8.0)}


def single_response() -> Numbers:
    """Eq. (18): the single printed amplitude and the three correct ones."""
    (printed,) = amplitudes_18(omega=SPEED, zeta=DAMPING)
    small, middle, large = _whirls()["amplitude"].values.ravel()
    return {"printed": printed, "small": small, "middle": middle, "large": large}


def phases() -> Numbers:
    """Eqs (20)-(23): the argument of H and the printed arctangent on the small whirl."""
    small = _whirls().isel(branch=0)
    A = small["amplitude"].item()
    given = {"omega": SPEED, "zeta": DAMPING}
    H = transfer_21(A, **given)
    return {
        "argument": cmath.phase(H),
        "arctangent": phase_23(A, **given),
        "lag": small["phase_lag"].item(),
        "modulus": abs(H),
        "amplitude": A,
    }


def transient() -> Numbers:
    """Eqs (24)-(28): the error from (10, 0, 0, 0) at t = 5, as printed and with corrected signs."""
    start = (10.0, 0.0, 0.0, 0.0)
    rotor = Rotor(omega=SPEED, zeta=DAMPING, delta0=0.0)
    run = simulate(rotor, start=start, duration=5.0, samples=501)
    z = run["x"].values + 1j * run["y"].values
    A = float(_whirls()["amplitude"].values.ravel()[2])
    found = {}
    for name, mended in (("printed", False), ("mended", True)):
        error = abs(z - general_solution(
            run["t"].values, start=start, omega=SPEED, zeta=DAMPING, amplitude=A, mended=mended
        ))  # fmt: skip
        found[name] = float(error[-1])
        found[f"{name}_from"] = float(run["t"].values[int(np.argmax(error > 1.0))])
    return found


def with_clearance() -> Numbers:
    """Eqs (29) and (31) at omega = 1.2, delta0 = 0.5: amplitudes and phases."""
    given = {"omega": 1.2, "zeta": DAMPING, "delta0": 0.5}
    (printed,) = amplitudes_29(**given)
    whirl = synchronous_response(Rotor(**given))
    A = whirl["amplitude"].item()
    return {
        "amplitude": A,
        "printed_amplitude": printed,
        "lag": whirl["phase_lag"].item(),
        "printed_lag": phase_31(A, **given),
    }


def unstable() -> Numbers:
    """4.1.2: amplitude and growth rate of the unstable whirl."""
    A = float(_whirls()["amplitude"].values.ravel()[1])
    rates = eigenvalues(A, omega=SPEED, zeta=DAMPING, delta0=0.0)
    return {"amplitude": A, "growth": float(rates.real.max())}


def captions() -> Numbers:
    """Figs 8 and 9: amplitudes reached from the two starts."""
    return {"rest": _reached(0.0, 0.0), "ten": _reached(10.0, 0.0)}


def basin_cuts() -> Numbers:
    """Fig. 7: the starts on the axes, at rest, that end on the small whirl."""
    line = np.linspace(-12.0, 12.0, 17)
    across = np.array([_reached(x, 0.0, duration=120.0) < 5.0 for x in line])
    up = np.array([_reached(0.0, y, duration=120.0) < 5.0 for y in line])
    return {
        "changes": float((across[1:] != across[:-1]).sum() + (up[1:] != up[:-1]).sum()),
        "left": line[across].min(),
        "right": line[across].max(),
        "low": line[up].min(),
        "high": line[up].max(),
    }


def cusps() -> Numbers:
    """Fig. 6: damping above which no jump exists, without clearance and at any clearance."""
    anywhere = cusp()
    return {
        "without": cusp(delta0=0.0)["cusp_zeta"].item(),
        "anywhere": anywhere["cusp_zeta"].item(),
        "at": anywhere["delta0"].item(),
    }


def clearance() -> Numbers:
    """4.2.1: amplitudes below resonance, and peaks."""
    slow = synchronous_response(omega=1.2, zeta=DAMPING, delta0=[0.0, 0.5, 1.0, 2.0])
    a, b, c, d = slow["amplitude"].max("branch").values.ravel()
    first, last = peaks(zeta=DAMPING, delta0=[0.0, 2.0])["peak_amplitude"].values.ravel()
    return {"a": a, "b": b, "c": c, "d": d, "first": first, "last": last}


def agreement() -> Numbers:
    """Fig. 11: response from rest at delta0 = 2."""
    found = sweep(omega=[0.75, 1.0, 1.25, 1.5, 2.0], zeta=DAMPING, delta0=2.0).squeeze()
    exact = synchronous_response(omega=found["omega"].values, zeta=DAMPING, delta0=2.0)
    branch = (exact["in_contact"] == 1).any("branch").squeeze()
    last = found.isel(omega=-1)
    return {
        "speeds": found.sizes["omega"],
        "with_branch": int(branch.sum()),
        "reached": int((found["response"] == RESPONSE["synchronous"]).sum()),
        "bounces": float(last["response"] == RESPONSE["bouncing"]),
        "inner": last["radius_min"].item(),
        "outer": last["radius_max"].item(),
    }


def _whirls() -> xr.Dataset:
    return synchronous_response(omega=SPEED, zeta=DAMPING, delta0=0.0)


def _states(run: xr.Dataset) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.stack([run[name].values for name in COMPONENTS], axis=-1)


def _reached(x: float, y: float, *, duration: float = 300.0) -> float:
    rotor = Rotor(omega=SPEED, zeta=DAMPING, delta0=0.0)
    end = simulate(rotor, start=(x, y, 0.0, 0.0), duration=duration, samples=2).isel(t=-1)
    return float(np.hypot(end["x"], end["y"]))
