"""Figure 6: amplitude and phase for four dampings, and where they jump.

Without clearance and at zeta = 0.07 three whirls coexist between two speeds, of which the middle
one is unstable. At the ends of that range the rotor jumps. The curve leans along its backbone, the
amplitude of free whirl over its speed. The paper's other dampings, 1.0, 1.5 and 2.0, are far too
strong for a jump. At delta0 = 0 no jump exists above zeta = 0.156045, and above 0.251003 none
exists at any clearance.

Writes the curves (curves.nc), the folds and jumps (jumps.nc), the backbones (backbone.nc), the
cusps (cusp.nc), and the figures as PNG and SVG.
"""

import sys

import numpy as np

from rotor_ida import folds
from rotor_ida.closed_forms import cusp, free_periods, jumps, response_curve
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import mixed_panels, parameter_text, plot_amplitude, plot_phase, style
from rotor_ida.plot.appearance import draw_marks
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.legends import own_legend
from rotor_ida.plot.palette import INK, RED, SHADE, look

DAMPINGS = [0.07, 1.0, 1.5, 2.0]
LIMITS = (0.02, 3.0)


def main(settings: Settings) -> None:
    exact = response_curve(zeta=DAMPINGS, delta0=0.0, limits=LIMITS)
    found = jumps(zeta=0.07, delta0=0.0)
    backbone = free_periods(amplitude=np.linspace(0.02, 14.0, 300), delta0=[0.0, 0.5])
    limit = cusp(delta0=np.linspace(0.0, 3.0, 61 if settings.quick else 301))
    highest = cusp()
    settings.keep(exact, "curves")
    settings.keep(found, "jumps")
    settings.keep(backbone, "backbone")
    settings.keep(limit.assign_attrs(highest_zeta=highest.cusp_zeta.item()), "cusp")

    figure, axes = mixed_panels(2, 2, height=5.8)
    weak, strong = exact.sel(zeta=0.07), exact.sel(zeta=DAMPINGS[1:])
    plot_amplitude(weak, fold_points=folds(zeta=0.07, delta0=0.0), ax=axes[0])
    with style():
        draw_backbone(axes[0], backbone.sel(delta0=0.0))
        draw_jumps(axes[0], found)
    plot_phase(weak, fold_points=folds(zeta=0.07, delta0=0.0), ax=axes[1])
    axes[1].get_legend().remove()
    for ax, draw in ((axes[2], plot_amplitude), (axes[3], plot_phase)):
        draw_dampings(ax, strong, draw)
    up, down = found.fold_omega.values.ravel()[::-1]
    settings.show(
        figure, "fig06_jumps", archives=["curves", "jumps", "backbone"],
        shows="Amplitude and phase lag over the speed without clearance: weak damping above, the "
        "strong dampings of the paper below.",
        paper="The frequency response shows the jump bifurcation phenomenon.",
        verdict="Only at ζ = 0.07; not at the three other dampings.",
        found=f"At ζ = 0.07 the rotor jumps down at {up:.6f} and up at {down:.6f}; the other "
        "three dampings have no jump.",
    )  # fmt: skip

    figure, (ax,) = mixed_panels(1, 1, width=5.4, height=3.4)
    with style():
        draw_cusp(ax, limit, highest)
    settings.show(
        figure, "fig06_cusp", archives=["cusp"],
        shows="The cusp: damping above which the response curve has no fold, against clearance.",
        found=f"{limit.cusp_zeta[0].item():.9f} without clearance. It rises with the clearance "
        f"to {highest.cusp_zeta.item():.6f} at δ₀ = {highest.delta0.item():.4f}, then falls. "
        "Above that value no rotor jumps.",
    )  # fmt: skip


def draw_backbone(ax, free) -> None:
    """Draw the amplitude of a free whirl over its speed."""
    ax.plot(2.0 * np.pi / free.circular_period, free.amplitude, color="#6b7673", lw=0.9,
            ls=(0, (1, 2)), label="backbone", zorder=2.2)  # fmt: skip


def draw_jumps(ax, found) -> None:
    """Draw an arrow from each fold to the whirl that the rotor jumps to."""
    names = ("fold_omega", "fold_amplitude", "landing_amplitude")
    for omega, begin, end in zip(*(found[name].values.ravel() for name in names), strict=True):
        if np.isfinite(end):
            arrow = {"arrowstyle": "-|>", "color": RED, "lw": 1.1, "shrinkA": 3.0, "shrinkB": 0.0}
            ax.annotate("", (omega, end), (omega, begin), arrowprops=arrow)
    ax.plot([], [], color=RED, lw=1.1, marker=">", ms=4.0, markevery=[-1], label="jump")
    own_legend(ax)


def draw_dampings(ax, exact, draw) -> None:
    """Draw a curve for each damping, unstable whirls thin."""
    for number, zeta in enumerate(exact.zeta.values):
        before = set(ax.lines)
        draw(exact.sel(zeta=zeta), ax=ax)
        colour, line = look(number)
        for each in set(ax.lines) - before:
            unstable = each.get_label() == "unstable whirl"
            each.set(color=colour, linestyle=line, linewidth=0.6 if unstable else 1.3)
            each.set_label("_unstable" if unstable else parameter_text({"zeta": zeta}))
    with style():
        ax.set_title(parameter_text({"delta0": 0.0}))
        own_legend(ax)


def draw_cusp(ax, limit, highest) -> None:
    """Draw the damping above which no fold exists over the clearance, and its largest value."""
    ax.fill_between(limit.delta0, limit.cusp_zeta, color=SHADE, lw=0.0)
    ax.plot(limit.delta0, limit.cusp_zeta, color=INK)
    place = highest.delta0.item(), highest.cusp_zeta.item()
    draw_marks(ax, *place, "D", INK, size=4.0, face="white")
    ax.annotate(f"$\\zeta = {place[1]:.6f}$ at $\\delta_0 = {place[0]:.4f}$", place, xytext=(8, 3),
                textcoords="offset points")  # fmt: skip
    ax.text(0.3, 0.25, "jumps", transform=ax.transAxes, ha="center")
    ax.text(0.7, 0.75, "no jumps", transform=ax.transAxes, ha="center")
    ax.set_xlim(float(limit.delta0.min()), float(limit.delta0.max()))
    ax.set_ylim(0.0, 1.2 * float(limit.cusp_zeta.max()))
    ax.set(xlabel=LABELS["delta0"], ylabel=LABELS["zeta"])


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
