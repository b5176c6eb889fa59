"""A finite-element rotor that rubs in two places.

A shaft of ten beam elements on two bearings carries two discs, with the gyroscopic moments of the
discs: 44 degrees of freedom. A seal surrounds the first disc with a clearance of 0.1 mm. The
second disc has a retainer on a flexible mount, with a clearance of 0.12 mm. Both rub with friction.
Started from rest at a constant speed below the first critical speed, the rotor hits both. In a
run-up it rubs far beyond that speed before it comes off. The speed map shows why: up to a fold the
rubbing whirl is stable beside the contact-free one, to which the rotor jumps there. In a run-down
it keeps clear of both until the contact-free whirl touches.

Writes the run at constant speed (constant.nc), the run-up (run_up.nc), the settled responses up and
down (speed_map.nc), the exact whirls at one speed (whirls.nc), the eigenvalues (campbell.nc) and
the figures as PNG and SVG.
"""

import math
import sys
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.linalg import eigvals

from rotor_ida import (
    Contact,
    RotorSystem,
    Stator,
    Unbalance,
    campbell,
    run_up,
    signals_of,
    simulate,
    special_speeds,
    sweep,
    synchronous_response,
)
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import (
    figure_of,
    plot_bode,
    plot_campbell,
    plot_cascade,
    plot_run,
    plot_shape,
    plot_whirl_shapes,
)
from rotor_ida.schema import SPECIAL

ELEMENTS, LENGTH, DIAMETER = 10, 0.05, 20e-3  # of the shaft: number, length and diameter [m]
YOUNG, DENSITY = 211e9, 7810.0  # Pa, kg/m^3
DISCS = {"seal": 3, "retainer": 7}  # the nodes of the discs, by what stands around them
WIDTH, OUTER = 20e-3, 120e-3  # of a disc [m]
BEARING = 5e6, 200.0  # stiffness [N/m] and damping [N s/m]
DRAG = 60.0  # damping of each disc [N s/m]
UNBALANCE = 1e-4  # kg m, of each disc
RPM = 2.0 * math.pi / 60.0  # rad/s
SPEED, FIRST, LAST = 4070.0 * RPM, 1500.0 * RPM, 8500.0 * RPM
BISTABLE = 6200.0 * RPM  # a speed with a rub and a contact-free whirl, both stable
CLOSED = (0.0, 1e5, 1e6)  # stiffness of the contacts between open and closed [N/m]


def main(settings: Settings) -> None:
    unbalance = [Unbalance(node=name, moment=UNBALANCE) for name in DISCS]
    system = replace(rotor(), contacts=stops(), unbalance=unbalance)
    run = simulate(system, speed=SPEED, duration=0.2, modes=12 if settings.quick else None)
    settings.keep(run, "constant")
    draw_constant(run, settings)
    up = run_up(
        system, speed=FIRST, to=LAST, rate=(4000.0 if settings.quick else 1000.0) * RPM, modes=8
    )
    settings.keep(up, "run_up")
    draw_run_up(up, critical_speed(system), settings)
    draw_speed_map(system, settings)
    draw_shapes(system, settings)
    draw_eigenvalues(system, settings)


def rotor() -> RotorSystem:
    """Return the shaft with its discs and bearings; each node has x, its slope, y and its slope."""
    mass, stiffness = (np.zeros((2 * (ELEMENTS + 1),) * 2) for _ in range(2))
    for first in range(0, 2 * ELEMENTS, 2):
        here = slice(first, first + 4)
        of_element = beam_element()
        mass[here, here] += of_element[0]
        stiffness[here, here] += of_element[1]
    polar, damping = (np.zeros(mass.shape) for _ in range(2))
    disc = DENSITY * math.pi / 4.0 * (OUTER**2 - DIAMETER**2) * WIDTH
    across = disc * (OUTER**2 + DIAMETER**2) / 16.0 + disc * WIDTH**2 / 12.0
    for node in DISCS.values():
        mass[2 * node, 2 * node] += disc
        damping[2 * node, 2 * node] = DRAG
        mass[2 * node + 1, 2 * node + 1] += across
        polar[2 * node + 1, 2 * node + 1] = disc * (OUTER**2 + DIAMETER**2) / 8.0
    for end in (0, 2 * ELEMENTS):
        stiffness[end, end] += BEARING[0]
        damping[end, end] += BEARING[1]
    names = {node: name for name, node in DISCS.items()}
    nodes = [names.get(node, str(node)) for node in range(ELEMENTS + 1)]
    # x and y are the same but for the gyroscopic moments, which turn one into the other
    both, turned = np.eye(2), np.array([[0.0, 1.0], [-1.0, 0.0]])
    return RotorSystem(
        mass=np.kron(both, mass), stiffness=np.kron(both, stiffness),
        damping=np.kron(both, damping), gyroscopic=np.kron(turned, polar),
        nodes={name: (2 * k, 2 * k + len(mass)) for k, name in enumerate(nodes)},
        positions={name: LENGTH * k for k, name in enumerate(nodes)},
    )  # fmt: skip


def beam_element() -> tuple[np.ndarray, np.ndarray]:
    """Return mass and stiffness matrix of a beam element by Euler and Bernoulli."""
    own = DENSITY * math.pi / 4.0 * DIAMETER**2 * LENGTH / 420.0
    bending = YOUNG * math.pi / 64.0 * DIAMETER**4 / LENGTH**3
    scale = np.diag([1.0, LENGTH, 1.0, LENGTH])
    mass = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
    bent = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    return own * scale @ mass @ scale, bending * scale @ bent @ scale


def stops() -> list[Contact]:
    """Return the seal, and the retainer on its mount."""
    ring = Stator(mass=1.5, stiffness=2e6, damping=400.0)
    usual = {"stiffness": 1e6, "exponent": 1.0, "friction": 0.1, "radius": OUTER / 2.0}
    return [
        Contact(node="seal", clearance=0.1e-3, **usual),
        Contact(node="retainer", clearance=0.12e-3, stator=ring, **usual),
    ]


def critical_speed(system: RotorSystem) -> float:
    """Return the speed at which a synchronous forward whirl resonates without damping [rad/s]."""
    half = system.size // 2
    polar = system.gyroscopic[:half, half:]
    squares = eigvals(system.stiffness[:half, :half], system.mass[:half, :half] - polar)
    return float(np.sqrt(squares.real[squares.real > 0.0].min()))


def draw_constant(run: xr.Dataset, settings: Settings) -> None:
    """Draw the run at constant speed."""
    first = run.isel(event=0)
    name = str(run.contact_node.values[int(first.event_contact)])
    largest = [
        float(run.peak_force.values[run.episode_contact.values == number].max())
        for number in range(run.sizes["contact"])
    ]
    # of the retainer itself: where the disc is in space, less where it is in the retainer
    aside = [run[each].sel(node="retainer") - run[f"contact_{each}"][:, 1] for each in ("x", "y")]
    moved = 1e6 * float(np.hypot(*aside).max())
    settings.show(
        plot_run(run), "orbits", archives=["constant"],
        shows="A finite-element rotor from rest at 4070 rpm: the orbits of its nodes with the "
        "clearances, that in the retainer relative to it, and the forces of both contacts.",
        found=f"{run.sizes['event']} events; the first is at the {name} after "
        f"{1e3 * float(first.event_time):.4f} ms, and the largest estimated error of a time is "
        f"{1e12 * float(run.event_time_error.max()):.2g} ps. The largest forces are "
        f"{largest[0]:.0f} N at the seal and {largest[1]:.0f} N at the retainer.",
    )  # fmt: skip
    settings.show(
        plot_shape(run), "shape", archives=["constant"],
        shows="The deflected shaft at the instant of its largest deflection, with the room that "
        "the seal and the retainer leave.",
        found=f"It bends as in its first mode. The retainer moves by up to {moved:.0f} µm.",
    )  # fmt: skip


def draw_run_up(up: xr.Dataset, critical: float, settings: Settings) -> None:
    """Draw the run-up at the seal."""
    signals = signals_of(up, node="seal")
    first, last = (float(up.event_speed[place]) / RPM for place in (0, -1))
    settings.show(
        plot_bode(signals), "bode", archives=["run_up"],
        shows="Amplitude and phase lag of 1X at the seal as the rotor runs up with eight modes.",
        found=f"Without contacts the rotor resonates at {critical / RPM:.0f} rpm. It touches from "
        f"{first:.0f} rpm on, which stiffens it, and comes off at {last:.0f} rpm.",
    )  # fmt: skip
    settings.show(
        plot_cascade(signals).figure, "cascade", archives=["run_up"],
        shows="Full spectra at the seal over the speed of the run-up, backward whirl on the left.",
        found=f"The rotor rubs from {first:.0f} to {last:.0f} rpm.",
    )  # fmt: skip


def draw_speed_map(system: RotorSystem, settings: Settings) -> None:
    """Draw the settled responses up and down, over the exact whirls."""
    reduced = system.reduced(modes=6 if settings.quick else 12)
    swept = sweep(
        reduced, direction="both",
        speed=np.linspace(FIRST, LAST, 15 if settings.quick else 71),
    )  # fmt: skip
    settings.keep(swept, "speed_map")
    special = special_speeds(reduced, limits=(FIRST, LAST))
    folds = special.special_speed.values[special.special_kind.values == SPECIAL["fold"]]
    largest = swept.largest_force.max(["speed", "start", "direction"]).values.tolist()
    touched = swept.touched.any("contact").squeeze("start")
    last = [float(swept.speed.where(touched.sel(direction=way)).max()) / RPM for way in (1, -1)]
    settings.show(
        figure_of(swept), "speed_map", archives=["speed_map"],
        shows="Settled responses at both stops with the speed going up and down, simulated, over "
        "all exact synchronous whirls, in the coordinates of few modes.",
        found=f"Going up the rotor rubs up to {last[0]:.0f} rpm; the exact fold is at "
        f"{max(folds) / RPM:.0f} rpm. Going down it rubs only from {last[1]:.0f} rpm on. The "
        f"largest forces are {largest[0]:.0f} N at the seal and {largest[1]:.0f} N at the "
        "retainer.",
    )  # fmt: skip


def draw_shapes(system: RotorSystem, settings: Settings) -> None:
    """Draw the deflected shapes of all synchronous whirls at a speed."""
    whirls = synchronous_response(system, speed=BISTABLE)
    settings.keep(whirls, "whirls")
    settings.show(
        plot_whirl_shapes(whirls).figure, "shapes", archives=["whirls"],
        shows="Deflected shapes of the whirls at 6200 rpm, with the clearance of the seal.",
        found=f"{int((whirls.stability == 1).sum())} of {whirls.sizes['branch']} whirls are "
        "stable: which of them the rotor follows depends on how it came to this speed.",
    )  # fmt: skip


def draw_eigenvalues(system: RotorSystem, settings: Settings) -> None:
    """Draw whirl speeds over the speed, with contacts open, half closed and closed."""
    found = campbell(
        system, speed=np.linspace(0.0, LAST, 9 if settings.quick else 35),
        contact_stiffness=CLOSED, modes=8,
    )  # fmt: skip
    settings.keep(found, "campbell")
    slowest = found.whirl_speed.where(found.whirl_sense == 1).min("eigenvalue")[:, 0]
    first, _, last = (slowest.values / RPM).tolist()
    settings.show(
        plot_campbell(found).figure, "campbell", archives=["campbell"],
        shows="A Campbell diagram with the contacts open and with springs for a rub.",
        found=f"Contacts that are closed raise the first forward whirl from {first:.0f} to "
        f"{last:.0f} rpm.",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
