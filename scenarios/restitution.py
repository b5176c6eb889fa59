"""Restitution from contact damping, and its effect on bouncing and chaos.

Hunt and Crossley's contact damping c takes energy from each impact. The restitution e of a radial
impact at speed v follows from a closed form that contains neither stiffness nor exponent of the
contact: x (1 + e) = ln((1 + x)/(1 - e x)) with x = c v. Simulated radial impacts agree with it to
machine precision in a linear and in a Hertzian stator, and so do their depths. A rotor that
bounces, driven by its unbalance (omega = 2, zeta = 0.07, delta0 = 2), keeps its cycle at any
contact damping. Its
branch over c has no end, but above a certain c it no longer leaves the stator. Chaos (omega = 1.38,
delta0 = 1) ends at a far smaller c, in a cascade of period doublings.

Writes the impacts (law.nc), the branch (bouncing.nc), peaks and exponents (chaos.nc), the doubled
branches (doubled_1.nc and so on), and the figures as PNG and SVG.
"""

import math
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr
from matplotlib.axes import Axes

from rotor_ida import Rotor, continue_cycle, impact, lyapunov_exponent, simulate
from rotor_ida.paper.scenario import Settings, progress_bar, run_script, scientific
from rotor_ida.plot import mixed_panels, parameter_text, plot_branch, shared_legend, style
from rotor_ida.plot.palette import BLUE, BROWN, DASHES, GREY, INK, ORANGE, RED
from rotor_ida.schema import SPECIAL

RINGS = {1.0: "linear", 1.5: "Hertz"}
METHODS = {"taylor": "Taylor series", "adams": "CVODE"}
BOUNCING = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
CHAOTIC = {"omega": 1.38, "zeta": 0.07, "delta0": 1.0}
START = (1.5, -0.25, 0.0, 0.0)
LARGEST = 0.008  # contact damping up to which the end of the chaos is shown
CYCLIC = 0.006  # one at which the rotor settles on a cycle
PEAKS = 48  # contacts whose depths are shown


def main(settings: Settings) -> None:
    law = impacts(number=3 if settings.quick else 10)
    settings.keep(law, "law")
    draw_law(law, settings)

    branch = continue_cycle(
        Rotor(**BOUNCING),
        start=(0.0, 0.0, 0.0, 0.0),
        parameter="contact_damping",
        limits=(0.0, 1.0),
    )
    settings.keep(branch, "bouncing")
    draw_bouncing(branch, settings)

    chaos = peaks_and_exponents(settings)
    settings.keep(chaos, "chaos")
    branches = cascade(levels=1 if settings.quick else 3)
    for number, doubled in enumerate(branches, start=1):
        settings.keep(doubled, f"doubled_{number}")
    draw_chaos(chaos, branches, settings)


def impacts(number: int) -> xr.Dataset:
    """Return simulated radial impacts beside their closed forms."""
    exact = impact(
        entry_speed=np.geomspace(0.03, 10.0, number), contact_damping=[0.01, 0.1, 1.0, 3.0],
        contact_exponent=list(RINGS),
    )  # fmt: skip
    shape = (len(METHODS), *exact.restitution.shape)
    rebound, depth = np.empty(shape), np.empty(shape)
    for place in np.ndindex(shape):
        here = exact.isel(dict(zip(exact.restitution.dims, place[1:], strict=True)))
        rebound[place], depth[place] = simulated_impact(here, list(METHODS)[place[0]])
    dims = ("solver", *exact.restitution.dims)
    names = {"long_name": "method of simulation"}
    words = {
        "simulated_restitution": (rebound, "speed at exit over that at entry, simulated"),
        "simulated_indentation": (depth, "largest indentation, simulated"),
    }
    return exact.assign_coords(solver=("solver", list(METHODS), names)).assign(
        {
            name: (dims, values, {"long_name": text, "units": "1"})
            for name, (values, text) in words.items()
        }
    )


def simulated_impact(here: xr.Dataset, method: str) -> tuple[float, float]:
    """Return restitution and depth of an impact on the stator, without spin and damping."""
    speed = here.entry_speed.item()
    rotor = Rotor(
        omega=0.0, zeta=0.0, delta0=1.0, contact_damping=here.contact_damping.item(),
        contact_exponent=here.contact_exponent.item(),
    )  # fmt: skip
    # time to enter without damping and to leave at the remaining speed, with a margin
    lasts = 4.0 * here.peak_indentation.item() / speed / here.restitution.item()
    run = simulate(
        rotor, start=(1.0, 0.0, speed, 0.0), duration=lasts, samples=2, rtol=1e-13, method=method
    )
    left = run.event_kind.values == -1
    return -run.event_vx.values[left][0] / speed, run.peak_indentation.values[0]


def cascade(levels: int) -> list[xr.Dataset]:
    """Return the branch of a cycle over the contact damping, and its period-doubled branches."""
    rotor = Rotor(**CHAOTIC, contact_damping=CYCLIC)
    given = {"parameter": "contact_damping", "limits": (0.0037, LARGEST)}
    branches = [continue_cycle(rotor, start=START, **given)]
    for _ in range(levels):
        first = doublings(branches[-1]).argmin()
        at = np.flatnonzero(branches[-1].special_kind == SPECIAL["period_doubling"])[first]
        branches.append(continue_cycle(rotor, start=branches[-1].isel(special=at), **given))
    return branches


def doublings(branch: xr.Dataset) -> np.ndarray:
    """Return the contact dampings at which the period doubles along a branch."""
    return branch.special_value.values[branch.special_kind == SPECIAL["period_doubling"]]


def peaks_and_exponents(settings: Settings) -> xr.Dataset:
    """Return the depths of late contacts and the largest exponent over the contact damping."""
    dampings = np.linspace(0.0, LARGEST, 17 if settings.quick else 121)
    sparse = dampings[:: 4 if settings.quick else 6]
    duration = 4000.0 if settings.quick else 6000.0

    def peaks_at(damping: float) -> np.ndarray:
        rotor = Rotor(**CHAOTIC, contact_damping=damping)
        run = simulate(rotor, start=START, duration=3000.0, samples=2, method="taylor")
        return run.peak_indentation.values[-PEAKS - 1 : -1]

    def exponent_at(damping: float) -> tuple[float, float]:
        rotor = Rotor(**CHAOTIC, contact_damping=damping)
        found = lyapunov_exponent(rotor, start=START, transient=3000.0, duration=duration)
        return found.lyapunov_exponent.values[0], found.lyapunov_error.values[0]

    with (
        progress_bar("chaos over the damping") as progress,
        ThreadPoolExecutor(settings.workers) as pool,
    ):
        peaks = []
        for found in pool.map(peaks_at, dampings):
            peaks.append(found)
            progress(len(peaks), dampings.size + sparse.size)
        exponents = []
        for pair in pool.map(exponent_at, sparse):
            exponents.append(pair)
            progress(len(peaks) + len(exponents), dampings.size + sparse.size)
    columns = {
        "peak_indentation": (("damping", "peak"), peaks, "largest indentation of late contacts"),
        "largest_exponent": ("sparse", np.array(exponents)[:, 0], "largest Lyapunov exponent"),
        "exponent_error": ("sparse", np.array(exponents)[:, 1], "standard error of the exponent"),
    }
    coordinates = {
        "damping": ("damping", dampings, "contact damping"),
        "sparse": ("sparse", sparse, "contact damping at which the exponent is computed"),
    }
    return xr.Dataset(
        *({name: (dims, values, {"long_name": words, "units": "1"})
           for name, (dims, values, words) in table.items()}
          for table in (columns, coordinates)),
        {"title": "Depths of contacts and Lyapunov exponents over the contact damping"} | CHAOTIC,
    )  # fmt: skip


def draw_law(law: xr.Dataset, settings: Settings) -> None:
    figure, axes = mixed_panels(1, 3, height=3.2)
    x = (law.contact_damping * law.entry_speed).transpose("entry_speed", "contact_damping")
    fine = np.geomspace(float(x.min()), float(x.max()), 300)
    one = impact(entry_speed=fine, contact_damping=1.0).isel(contact_damping=0)
    scaled = one.peak_indentation**2.5 / (2.5 * one.entry_speed**2)
    power = law.contact_exponent + 1.0
    depths = law.simulated_indentation**power / (power * law.entry_speed**2)
    for ax, curve, points, words in (
        (axes[0], one.restitution, law.simulated_restitution, "restitution $e$"),
        (axes[1], scaled, depths, r"$d_{\max}^{\,n + 1}/((n + 1)\,v^2)$"),
    ):
        with style():
            ax.plot(fine, curve, color=INK, lw=1.3, label="closed form")
            for ring, (marker, colour) in zip(RINGS, (("o", BLUE), ("x", RED)), strict=True):
                ax.plot(
                    x.values.ravel(),
                    points.sel(solver="taylor", contact_exponent=ring)
                    .transpose(*x.dims).values.ravel(),
                    ls="", marker=marker, ms=4.2, mfc="none", mew=0.9, color=colour,
                    label=f"simulated, $n = {ring:g}$",
                )  # fmt: skip
            ax.set(xscale="log", xlabel=r"$x = c\,v$", ylabel=words, ylim=(0.0, None))
    axes[0].set_title("one law for all stators", fontsize=9.5)
    axes[1].set_title("one law for all depths", fontsize=9.5)
    missed = {name: np.abs(law.simulated_restitution - law.restitution).sel(solver=name)
              for name in METHODS}  # fmt: skip
    with style():
        for (name, words), marker, colour in zip(
            METHODS.items(), ("s", "D"), (ORANGE, BROWN), strict=True
        ):
            for ring in RINGS:
                values = missed[name].sel(contact_exponent=ring).transpose(*x.dims).values
                shown = np.where(values > 0.0, values, np.nan)
                axes[2].plot(x.values.ravel(), shown.ravel(), ls="",
                             marker=marker, ms=3.6, mfc="none", mew=0.9, color=colour,
                             label=words)  # fmt: skip
        axes[2].set(xscale="log", yscale="log", xlabel=r"$x = c\,v$", ylim=(3e-18, 1e-11),
                    ylabel="error of simulated $e$")  # fmt: skip
        worst = math.ceil(math.log10(max(float(each.max()) for each in missed.values())))
        axes[2].set_title(f"equal to better than $10^{{{worst}}}$", fontsize=9.5)
    shared_legend(figure, axes, columns=5, outer=False)
    deep = np.abs(law.simulated_indentation / law.peak_indentation - 1.0)
    settings.show(
        figure, "law", archives=["law"],
        shows="Restitution and depth of a radial impact over contact damping times speed: closed "
        "form and simulated impacts, and their difference.",
        found=f"{law.simulated_restitution.sel(solver='taylor').size} impacts with x from "
        f"{float(x.min()):.1g} to {float(x.max()):.2g} in a linear stator and in a Hertzian one "
        "lie on the law to "
        + " and ".join(
            f"{scientific(float(missed[name].max()))} by {words}" for name, words in METHODS.items()
        )
        + ", their depth to "
        + " and ".join(scientific(float(deep.sel(solver=name).max())) for name in METHODS)
        + " of it.",
    )  # fmt: skip


def draw_bouncing(branch: xr.Dataset, settings: Settings) -> None:
    figure, axes = mixed_panels(1, 3, height=3.3)
    plot_branch(branch, ax=axes[0])
    axes[0].set_title("no longer bounces", fontsize=9.5)
    axes[0].set_ylim(0.0, 4.6)
    graze = float(branch.special_value.values[branch.special_kind == SPECIAL["graze"]][0])
    for ax, name, words, title in (
        (axes[1], "period", "period $T$", "somewhat faster"),
        (axes[2], "largest_force", "largest force $N$", "and harder"),
    ):
        with style():
            ax.plot(branch.contact_damping, branch[name], color=INK, lw=1.3)
            ax.axvline(graze, color=BROWN, lw=0.8, ls=DASHES, label="no longer leaves the stator")
            ax.set(xlabel="contact damping $c$", ylabel=words)
            ax.set_title(title, fontsize=9.5)
    for ax in axes:
        ax.set_xlim(0.0, 1.0)
    shared_legend(figure, axes, columns=3, outer=False)
    first, last = branch.isel(point=0), branch.isel(point=-1)
    settings.show(
        figure, "bouncing", archives=["bouncing"],
        shows="A bouncing rotor at ω = 2, ζ = 0.07, δ₀ = 2, over the contact damping: "
        "range of the radius, period and largest force.",
        found=f"From c = {graze:.7f} on the rotor no longer leaves the stator: bouncing has become "
        "full contact, and the cycle stays stable. From c = 0 to 1 the largest radius falls from "
        f"{first.radius_max.item():.4f} to {last.radius_max.item():.4f}, the period from "
        f"{first.period.item():.4f} to {last.period.item():.4f}; the largest force rises from "
        f"{first.largest_force.item():.3f} to {last.largest_force.item():.3f}, because damping "
        "adds to it.",
    )  # fmt: skip


def draw_chaos(chaos: xr.Dataset, branches: Sequence[xr.Dataset], settings: Settings) -> None:
    figure, (diagram, exponents) = mixed_panels(2, 1, height=6.0)
    places = sorted({place for each in branches for place in doublings(each)}, reverse=True)
    dampings = np.broadcast_to(chaos.damping.values[:, None], chaos.peak_indentation.shape)
    with style():
        diagram.plot(
            dampings.ravel(), chaos.peak_indentation.values.ravel(), ls="", marker=".", ms=2.2,
            mew=0.0, color=INK, label="contacts at each $c$", rasterized=True,
        )  # fmt: skip
        diagram.set(ylabel="largest indentation of a contact")
        exponents.axhline(0.0, color=GREY, lw=0.8)
        exponents.errorbar(chaos.sparse, chaos.largest_exponent, yerr=chaos.exponent_error,
                           color=RED, marker="o", ms=3.0, lw=0.9, capsize=2.0,
                           label="largest exponent with its error")  # fmt: skip
        exponents.set(ylabel=r"Lyapunov exponent $\lambda$")
        exponents.set_title("chaos ends where the doublings accumulate", fontsize=9.5)
        diagram.set_title(f"{parameter_text(CHAOTIC)}: a cycle doubles into chaos", fontsize=9.5)
        for ax in (diagram, exponents):
            mark_doublings(ax, places)
            ax.set(xlabel="contact damping $c$", xlim=(0.0, LARGEST))
    shared_legend(figure, [diagram, exponents], columns=3, outer=False)
    settings.show(
        figure, "chaos",
        archives=["chaos", *(f"doubled_{number + 1}" for number in range(len(branches)))],
        shows="Chaos at ω = 1.38, ζ = 0.07, δ₀ = 1 over the contact damping: depths of contacts, "
        "largest Lyapunov exponent, and period doublings of the exact cycles.",
        found=words_of_chaos(chaos, places, branches),
    )  # fmt: skip


def mark_doublings(ax: Axes, places: Sequence[float]) -> None:
    for place in places:
        ax.axvline(place, color=BLUE, lw=0.7, ls=DASHES, zorder=1.5, label="period doubling")


def words_of_chaos(
    chaos: xr.Dataset, places: Sequence[float], branches: Sequence[xr.Dataset]
) -> str:
    """Return the gallery text on the end of chaos."""
    clear = chaos.largest_exponent > 5.0 * chaos.exponent_error
    last = float(chaos.sparse.values[clear.values].max())
    at_last = impact(entry_speed=1.0, contact_damping=places[-1]).restitution.item()
    text = (
        f"The largest exponent falls from {chaos.largest_exponent.values[0]:.4f} at c = 0; the "
        f"last one above its error is at c = {last:.4f}. Coming down from cycles, the period "
        f"doubles at c = {', '.join(f'{place:.7f}' for place in places)}, from "
        f"{0.5 * branches[0].period.values[0]:.1f} on"
    )
    steps = -np.diff(places)
    if steps.size > 1:
        ratios = ", ".join(f"{ratio:.2f}" for ratio in steps[:-1] / steps[1:])
        text += f", in steps with the ratios {ratios} (Feigenbaum's number is 4.669)"
    return (
        f"{text}. The restitution at a speed of 1 is then still {at_last:.4f}: very little damping "
        "ends the chaos."
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
