"""One branch of limit cycles leads from a forward rub to dry whip.

Past its Hopf point a synchronous rub swings in contact. The cycle that is born there is continued
over the friction: it folds, becomes unstable, and reaches a corner where the slip speed just falls
to 0. From that corner on the disc rolls on the stator backwards for a part of each period, in dry
whip. An unstable cycle therefore lies between the rub and whip, and over a range of friction both
attract (omega = 1.2, zeta = 0.07, delta0 = 0.5, rho = 10). In whip one multiplier is 0, because
rolling removes a dimension.

Writes the branch (branch.nc), what simulated rotors settle on, compared with exact whirls and
cycles (simulated.nc), and the figure as PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr

from rotor_ida import Rotor, compare, continue_cycle, sweep, synchronous_response
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import panels, plot_branch, shared_legend, style
from rotor_ida.plot.palette import INK
from rotor_ida.schema import EXACT, RESPONSE, SPECIAL, STABILITY

ROTOR = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)
NEAR_RUB, IN_WHIP = (3.0, 1.0, 0.0, 0.0), (8.0, 0.0, 0.0, -12.0)
LIMITS = (0.06, 0.16)


def main(settings: Settings) -> None:
    branch = continue_cycle(ROTOR, start=NEAR_RUB, parameter="friction", limits=LIMITS)
    settings.keep(branch, "branch")
    given = {"omega": ROTOR.omega, "zeta": ROTOR.zeta, "delta0": ROTOR.delta0}
    frictions = np.linspace(*LIMITS, 5 if settings.quick else 41)
    simulated = compare(
        sweep(
            **given, friction=frictions, disc_radius=ROTOR.disc_radius, method="taylor",
            starts=[NEAR_RUB, IN_WHIP], workers=settings.workers,
        )
    )  # fmt: skip
    settings.keep(simulated, "simulated")
    whirls = synchronous_response(**given, friction=np.linspace(*LIMITS, 201))
    draw(branch, simulated, whirls, settings)


def draw(branch: xr.Dataset, simulated: xr.Dataset, whirls: xr.Dataset, settings: Settings) -> None:
    figure, (ax,) = panels(1, 1, width=7.2, height=5.4)
    plot_branch(branch, ax=ax)
    with style():
        for kind, dashes in (("stable", "-"), ("unstable", (0, (1.2, 1.6)))):
            here = whirls.amplitude.where(whirls.stability == STABILITY[kind])
            here = here.where(whirls.in_contact == 1)
            for number in range(here.sizes["branch"]):
                ax.plot(whirls.friction, here.isel(branch=number).squeeze(), color=INK, lw=1.2,
                        ls=dashes, label=f"{kind} synchronous rub", zorder=2.2)  # fmt: skip
        for start in range(simulated.sizes["start"]):
            seen = simulated.isel(start=start).squeeze()
            ax.vlines(seen.friction, seen.radius_min, seen.radius_max, color="k", lw=0.9,
                      label="simulated: range of $|z|$", zorder=3.4)  # fmt: skip
            for edge in (seen.radius_min, seen.radius_max):
                ax.plot(seen.friction, edge, ".", color="k", ms=3.2, zorder=3.4)
        ax.set(xlim=LIMITS, ylim=(0.0, 9.0))
    shared_legend(figure, [ax], columns=4, outer=False)
    settings.show(
        figure, "branch", archives=["branch", "simulated"],
        shows="Limit cycles over the friction (ω = 1.2, ζ = 0.07, δ₀ = 0.5, ρ = 10), from the Hopf "
        "point of the synchronous rub to dry whip, the rub itself, and what simulated rotors "
        "settle on.",
        found=told(branch, simulated),
    )  # fmt: skip


def told(branch: xr.Dataset, simulated: xr.Dataset) -> str:
    """Return the gallery text."""
    places = {
        kind: branch.special_value.values[branch.special_kind.values == SPECIAL[kind]]
        for kind in ("hopf", "fold", "sliding")
    }
    on = simulated.lies_on.values != EXACT["nothing"]
    whips = int((simulated.response == RESPONSE["rolling"]).sum())
    return (
        f"The cycle is born at μ = {places['hopf'][0]:.8f}, the Hopf point of the closed form, "
        f"folds at {places['fold'][0]:.8f}, and as an unstable one reaches the corner at "
        f"{places['sliding'][0]:.8f}, where its slip speed just falls to 0 and whip begins. Of "
        f"{on.size} simulated responses {int(on.sum())} lie on an exact whirl or cycle, to "
        f"{float(simulated.digits.values[on].min()):.1f} digits and more; {whips} are dry whip."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
