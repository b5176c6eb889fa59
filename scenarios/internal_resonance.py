"""Bouncing cycles of an overhung rotor at internal resonance of two whirls.

Two discs sit on an overhung shaft, and the outer one may touch a stator. Far above its critical
speed the rotor runs inside the clearance, but a kick can leave it bouncing for ever. Shaw,
Champneys and Friswell explain such cycles by two whirls of the free rotor. On axes that rotate with
the rotor, a whirl of speed omega_1 turns by (Omega - omega_1) T in a period T of the cycle. Cycles
exist about where this is a whole number of turns for two whirls at once,

    (Omega - omega_1) T = 2 pi n_1,    (Omega - omega_2) T = 2 pi n_2,

which picks out single speeds. Here these come from the eigenvalues at each speed. The cycles are
exact and followed over the speed, with runs from a kick beside them. The paper's rotor is another.

A. D. Shaw, A. R. Champneys, M. I. Friswell, "Asynchronous partial contact motion due to internal
resonance in multiple degree-of-freedom rotordynamics", Proc. R. Soc. A 472, 2016.

Writes each branch and its first cycle, the runs, and the figure as PNG and SVG.
"""

import math
import sys

import numpy as np
import xarray as xr
from scipy.optimize import brentq

from rotor_ida import (
    Contact,
    RotorSystem,
    Unbalance,
    campbell,
    continue_cycle,
    limit_cycle,
    sweep,
)
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.plot import mixed_panels, plot_amplitude, plot_branch, plot_cycle
from rotor_ida.plot.appearance import drawing, style
from rotor_ida.plot.legends import legend_below
from rotor_ida.plot.palette import GREY

# Each disc: mass, and moments of inertia about a diameter and about the axis. The shaft has bending
# stiffness 1, and length 1 to the inner disc and between the discs.
MASS, DIAMETRAL, POLAR = 1.0, 0.05, 0.1
# Damping: these parts of the mass and of the stiffness.
OF_MASS, OF_STIFFNESS = 0.004, 0.0002
CONTACTS = [Contact(node="outer", clearance=1.0, stiffness=1.0, exponent=1.0)]
UNBALANCE = [Unbalance(node="outer", moment=0.3)]
# Families of cycles: the turns of the first backward and the first forward whirl in a period, and a
# speed at which the kick leads to one. The kick is the velocities of the inner and the outer disc.
FAMILIES = {(2, 1): 1.85, (3, 2): 3.06}
KICK = (1.0, 2.5)
LIMITS = (1.5, 4.0)


def main(settings: Settings) -> None:
    system = overhung()
    branches, cycles = {}, {}
    for turns, speed in FAMILIES.items():
        name = "by".join(map(str, turns))
        with progress_bar(f"cycles {name}") as progress:
            cycles[turns] = cycle_at(system, speed)
            branches[turns] = continue_cycle(
                system, start=cycles[turns], limits=LIMITS,
                points=6 if settings.quick else 100, progress=progress,
            )  # fmt: skip
        settings.keep(cycles[turns], f"cycle_{name}")
        settings.keep(branches[turns], f"branch_{name}")
    with progress_bar("runs") as progress:
        swept = sweep(
            system, speed=np.linspace(1.6, 3.6, 2 if settings.quick else 41),
            starts=[kicked()], workers=settings.workers, progress=progress,
        )  # fmt: skip
    settings.keep(swept, "runs")
    draw(system, branches, cycles, swept, settings)


def overhung() -> RotorSystem:
    """Return two equal discs on a massless overhung shaft: x and its tilt of each, then y."""
    inertia = np.diag([MASS, DIAMETRAL] * 2)
    element = np.array(
        [[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0],
         [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]]
    )  # fmt: skip
    stiffness = element.copy()
    stiffness[:2, :2] += element[2:, 2:]
    both, turning = np.eye(2), np.diag([0.0, POLAR] * 2)
    mass, whole = np.kron(both, inertia), np.kron(both, stiffness)
    return RotorSystem(
        mass=mass, stiffness=whole, damping=OF_MASS * mass + OF_STIFFNESS * whole,
        gyroscopic=np.kron([[0.0, 1.0], [-1.0, 0.0]], turning),
        nodes={"inner": (0, 4), "outer": (2, 6)}, units="1", contacts=CONTACTS,
        unbalance=UNBALANCE,
    )  # fmt: skip


def kicked() -> tuple[np.ndarray, np.ndarray]:
    """Return the start of the kick: no displacement, and velocities along x."""
    velocity = np.zeros(8)
    velocity[[0, 2]] = KICK
    return np.zeros(8), velocity


def cycle_at(system: RotorSystem, speed: float) -> xr.Dataset:
    """Return the limit cycle to which the kick leads at a speed."""
    return limit_cycle(system, speed=speed, start=kicked())


def first_whirls(system: RotorSystem, speed: float) -> tuple[float, float]:
    """Return the speeds of the first backward and the first forward whirl."""
    whirls = campbell(system, speed=[speed]).whirl_speed.values.ravel()
    return float(whirls[whirls < 0.0].max()), float(whirls[whirls > 0.0].min())


def turns_of(system: RotorSystem, speed: float, period: float) -> tuple[float, float]:
    """Return by how many turns the first two whirls turn in a period, on rotating axes."""
    backward, forward = first_whirls(system, speed)
    turn = period / (2.0 * math.pi)
    return (speed - backward) * turn, (speed - forward) * turn


def condition(system: RotorSystem, turns: tuple[int, int]) -> tuple[float, float]:
    """Return speed and period at which both whirls turn by whole numbers."""

    def off(speed: float) -> float:
        backward, forward = first_whirls(system, speed)
        return turns[1] * (speed - backward) - turns[0] * (speed - forward)

    speed = float(brentq(off, *LIMITS, xtol=1e-12))
    return speed, 2.0 * math.pi * turns[1] / (speed - first_whirls(system, speed)[1])


def draw(
    system: RotorSystem, branches: dict, cycles: dict, swept: xr.Dataset, settings: Settings
) -> None:
    with drawing(None, width=7.2, height=4.2) as ax:
        plot_amplitude(None, simulated=swept, ax=ax)
        for turns, branch in branches.items():
            plot_branch(branch, ax=ax)
            ax.axvline(condition(system, turns)[0], color=GREY, lw=0.9, ls=":",
                       label="whole turns of two whirls")  # fmt: skip
        legend_below(ax, columns=3)
    settings.show(
        ax.figure, "internal_resonance",
        archives=[*(f"branch_{a}by{b}" for a, b in branches), "runs"],
        shows="Bouncing cycles of two discs on an overhung shaft: exact branches over the speed "
        "(solid where stable), runs from a kick, and the speeds at which the first backward and "
        "the first forward whirl turn by whole numbers in a period (dotted).",
        found=" ".join(told(system, turns, branch) for turns, branch in branches.items()),
    )  # fmt: skip
    figure, axes = mixed_panels(1, 2, height=3.9)
    for ax, (turns, cycle) in zip(axes, cycles.items(), strict=True):
        plot_cycle(cycle, ax=ax)
        with style():
            ax.set_title(f"{turns[0]} and {turns[1]} turns, $\\Omega$ = {cycle.speed.item():g}")
    settings.show(
        figure, "resonant_cycles",
        archives=[f"cycle_{a}by{b}" for a, b in cycles],
        shows="One cycle of each family at the outer disc, on axes that rotate with the rotor.",
        found="Contacts are slight where the speed is near that of whole turns.",
    )  # fmt: skip


def told(system: RotorSystem, turns: tuple[int, int], branch: xr.Dataset) -> str:
    """Return the gallery text on one family."""
    speed, _ = condition(system, turns)
    lowest, highest = (int(find(branch.speed.values)) for find in (np.argmin, np.argmax))
    at = [
        (branch.speed.values[i], *turns_of(system, branch.speed.values[i], branch.period.values[i]))
        for i in (lowest, highest)
    ]
    words = [f"Ω = {each[0]:.4f} ({each[1]:.3f} and {each[2]:.3f} turns)" for each in at]
    return (
        f"The first two whirls turn {turns[0]} and {turns[1]} times at Ω = {speed:.4f}. The exact "
        f"branch was followed from {words[0]} to {words[1]}: the condition holds where contacts "
        "are slight, and fails as they grow hard."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
