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
from rotor_ida.plot import (
    mixed_panels,
    plot_amplitude,
    plot_backbone,
    plot_by_damping,
    plot_cusp,
    plot_jumps,
    plot_phase,
)

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
    plot_backbone(backbone.sel(delta0=0.0), ax=axes[0])
    plot_jumps(found, ax=axes[0])
    plot_phase(weak, fold_points=folds(zeta=0.07, delta0=0.0), ax=axes[1])
    axes[1].get_legend().remove()
    plot_by_damping(strong, "amplitude", ax=axes[2])
    plot_by_damping(strong, "phase_lag", ax=axes[3])
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
    plot_cusp(limit, highest=highest, ax=ax)
    settings.show(
        figure, "fig06_cusp", archives=["cusp"],
        shows="The cusp: damping above which the response curve has no fold, against clearance.",
        found=f"{limit.cusp_zeta[0].item():.9f} without clearance. It rises with the clearance "
        f"to {highest.cusp_zeta.item():.6f} at δ₀ = {highest.delta0.item():.4f}, then falls. "
        "Above that value no rotor jumps.",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
