"""Figures 2 and 3: the restoring force, its potential and the conserved energy.

The paper writes the force as f(x) + i f(y), falling with x, and calls the potential concave. In
fact each component depends on x and on y, f_x grows with x, and the potential is convex: the force
is restoring. In eq. (13) the paper prints |z|^2/2 for the kinetic energy |z'|^2/2. Along a
simulated free orbit the correct sum is constant and the printed one is not.

Writes the force field (field.nc), a free run with both sums (energy.nc), and the figures as
PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr

from rotor_ida import Rotor, simulate
from rotor_ida.closed_forms import restoring_field
from rotor_ida.model.equations import energy
from rotor_ida.paper.printed import hamiltonian
from rotor_ida.paper.scenario import Settings, run_script, scientific
from rotor_ida.plot import mixed_panels, parameter_text, style
from rotor_ida.plot.appearance import finish_solid
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.legends import own_legend
from rotor_ida.plot.palette import look

CLEARANCES = (0.0, 0.5)
START, DURATION = (2.0, 0.0, 0.3, 0.25), 40.0


def main(settings: Settings) -> None:
    places = np.linspace(-3.0, 3.0, 61 if settings.quick else 121)
    field = restoring_field(x=places, y=places, delta0=CLEARANCES)
    settings.keep(field, "field")
    draw_force(field, settings)
    draw_potential(field, settings)

    free = Rotor(omega=0.0, zeta=0.0, delta0=0.5)
    run = with_energies(simulate(free, start=START, duration=DURATION, samples=801))
    settings.keep(run, "energy")
    draw_energy(run, settings)


def with_energies(run: xr.Dataset) -> xr.Dataset:
    """Return a run with the energy, and with the sum printed in eq. (13)."""
    states = np.stack([run[name].values for name in ("x", "y", "vx", "vy")], axis=-1)
    delta0 = float(run.delta0)
    units = {"units": "1"}
    return run.assign(
        energy=("t", energy(states, delta0), {"long_name": "energy", **units}),
        printed_energy=(
            "t", hamiltonian(states, delta0), {"long_name": "eq. (13) as printed", **units},
        ),
    )  # fmt: skip


def draw_force(field: xr.Dataset, settings: Settings) -> None:
    figure, axes = mixed_panels(2, 3, height=5.2, solid=[0, 1, 3, 4])
    for row, delta0 in enumerate(CLEARANCES):
        here = field.sel(delta0=delta0)
        draw_surface(axes[3 * row], here, "restoring_x")
        draw_surface(axes[3 * row + 1], here, "restoring_y")
        draw_cuts(axes[3 * row + 2], here, "restoring_x")
    one, two = (restoring_field(x=1.0, y=y, delta0=0.5).restoring_x.item() for y in (0.0, 2.0))
    settings.show(
        figure, "fig02_force", archives=["field"],
        shows="The restoring force over the plane, without clearance and with δ₀ = 0.5.",
        paper="f = f(x) + i f(y); f(x) decreases from positive to negative with x.",
        verdict="Wrong: the force depends on both coordinates, and rises.",
        found=f"fₓ depends on y too and never decreases with x: at δ₀ = 0.5 it is {one:.4f} "
        f"at (1, 0) and {two:.4f} at (1, 2).",
    )  # fmt: skip


def draw_potential(field: xr.Dataset, settings: Settings) -> None:
    figure, axes = mixed_panels(2, 2, height=5.4, solid=[0, 2])
    for row, delta0 in enumerate(CLEARANCES):
        here = field.sel(delta0=delta0)
        draw_surface(axes[2 * row], here, "potential")
        draw_cuts(axes[2 * row + 1], here, "potential")
    settings.show(
        figure, "fig03_potential", archives=["field"],
        shows="The energy stored in the contact, over the plane and along x.",
        paper="The potential curves are concave under any combination of parameters.",
        verdict="Wrong: the potential is convex.",
        found="They are convex: the curvatures f(r)/r and 1.5 √(r − δ₀) are never negative. "
        "Inside the clearance the potential is flat.",
    )  # fmt: skip


def draw_surface(ax, field: xr.Dataset, name: str) -> None:
    """Draw a component of the force, or the potential, as a surface over the plane."""
    with style():
        across, up = np.meshgrid(field.x, field.y)
        ax.plot_surface(
            across, up, field[name].transpose("y", "x").values, cmap="cividis", rcount=31,
            ccount=31, linewidth=0.15, edgecolor="#3a3a3a", antialiased=True,
        )  # fmt: skip
        ax.set(xlabel=LABELS["x_alone"], ylabel=LABELS["y_alone"])
        ax.xaxis.labelpad = ax.yaxis.labelpad = -6
        # view in which the surface rises
        ax.view_init(elev=26, azim=-148 if name == "restoring_x" else -58)
        finish_solid(ax)
        ax.set_title(f"{LABELS[name]},  {parameter_text({'delta0': field.delta0.item()})}", y=0.98)


def draw_cuts(ax, field: xr.Dataset, name: str) -> None:
    """Draw cuts along x, at a few y, through a component of the force or the potential."""
    with style():
        for number, y in enumerate((0, 1, 2)):
            colour, line = look(number)
            cut = field[name].sel(y=y, method="nearest")
            ax.plot(field.x, cut, color=colour, ls=line, label=f"$y = {y}$")
        ax.set(xlabel=LABELS["x"], ylabel=LABELS[name])
        ax.set_title(parameter_text({"delta0": field.delta0.item()}))
        own_legend(ax)


def draw_energy(run: xr.Dataset, settings: Settings) -> None:
    drift = float(abs(run.energy / run.energy[0] - 1.0).max())
    low, high = float(run.printed_energy.min()), float(run.printed_energy.max())
    figure, (ax,) = mixed_panels(1, 1, height=2.8)
    with style():
        ax.plot(run.t, run.energy, color="#1a1a1a", label="$|z$′$|^2/2 + V$")
        ax.plot(run.t, run.printed_energy, color="#e76300", ls="--", lw=0.9,
                label=r"$|z|^2/2 + V$, as printed")  # fmt: skip
        ax.set(xlabel="time $t$", ylabel="energy $E$", ylim=(0.0, 4.2), xlim=(0.0, DURATION))
        ax.legend(loc="upper right", ncols=2)
    settings.show(
        figure, "eq13_energy", archives=["energy"],
        shows="The energy along a free orbit with clearance 0.5, through "
        f"{run.sizes['event']} contact events.",
        paper="H = |z|²/2 + V, eq. (13).",
        verdict="Wrong: |z′|²/2 + V is conserved, the printed sum is not.",
        found=f"|z′|²/2 + V is conserved to {scientific(drift)} of itself. The printed sum runs "
        f"from {low:.3g} to {high:.3g}.",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
