"""Map of dry whip over speed and friction, exact and simulated.

In dry whip the disc rolls backwards round the stator, sustained by friction. Without unbalance the
speed from which whip exists is known exactly for each coefficient of friction: there whip and the
slipping whirl are born together. Whether a rotor reaches whip is another question. Two rotors are
simulated, each from rest on the axis, from a knock backwards along the stator, and on whip itself.
One has a shaft (kappa = 0.05) in a linear stator, as in most publications, and one has none in a
Hertzian stator (zeta = 0.05, delta0 = 1, rho = 10). In a linear stator, friction below a certain
coefficient allows no whip at any speed: the slipping whirl would need a stiffer stator.

Whip is identified at the end of a run: lasting contact, backward whirl, and a disc that rolls, or
that slides both ways by turns if the unbalance is too strong for it to roll.

Writes the map of each rotor (shaft.nc, hertz.nc) and the figure as PNG and SVG.
"""

import math
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch

from rotor_ida import Rotor, backward_whirl, simulate
from rotor_ida.paper.scenario import Settings, progress_bar, run_script
from rotor_ida.paper.whip import ENDS, FIRST_OF_WHIP, end_of
from rotor_ida.plot import mixed_panels, style
from rotor_ida.plot.palette import GREY, INK

SAME = {"zeta": 0.05, "delta0": 1.0, "disc_radius": 10.0}
ROTORS = {
    "shaft": {**SAME, "shaft_stiffness": 0.05, "contact_exponent": 1.0},
    "hertz": SAME,
}
WORDS = {"shaft": "shaft, linear stator", "hertz": "no shaft, Hertzian stator"}
STARTS = {"rest": "rest on the axis", "knock": "a knock backwards", "whip": "whip itself"}
KNOCK = 10.0  # speed along the stator, backwards
LASTS = 250.0
SPEEDS, FRICTIONS = (0.05, 3.0), (0.03, 0.8)


def main(settings: Settings) -> None:
    omega = np.geomspace(*SPEEDS, 6 if settings.quick else 24)
    friction = np.geomspace(*FRICTIONS, 4 if settings.quick else 18)
    maps = {}
    for name in ROTORS:
        maps[name] = map_of(name, omega, friction, settings)
        settings.keep(maps[name], name)
    draw(maps, settings)


def starts(rotor: Rotor) -> list[tuple[float, ...]]:
    """Return rest on the axis, a knock backwards along the stator, and whip if it exists."""
    radius = backward_whirl(rotor).amplitude.values[1]
    surface = rotor.disc_radius * rotor.omega
    rest, knock = (0.0, 0.0, 0.0, 0.0), (rotor.delta0, 0.0, 0.0, -KNOCK)
    return [rest, knock] + ([] if math.isnan(radius) else [(radius, 0.0, 0.0, -surface)])


def ends_of(rotor: Rotor) -> list[int]:
    """Return the ends of runs from rest, a knock and whip; -1 where no whip exists."""
    ends = [
        end_of(simulate(rotor, start=start, duration=LASTS, samples=201, method="taylor"))
        for start in starts(rotor)
    ]
    return ends + [-1] * (len(STARTS) - len(ends))


def birth(name: str, friction: float) -> float:
    """Return the speed from which whip exists; NaN if friction is too weak at any speed."""
    rotor = Rotor(omega=1.0, friction=friction, **ROTORS[name])
    return float(backward_whirl(rotor).birth_omega)


def weakest_friction(name: str) -> float:
    """Return the friction above which whip exists at some speed: 0 for Hertzian contact.

    A linear stator holds a backward whirl of any size by itself, ``Omega**2 = kappa + 1``, and
    friction drives it where it exceeds damping, ``mu > 2 zeta |Omega|``.
    """
    rotor = Rotor(omega=1.0, friction=1.0, **ROTORS[name])
    if rotor.contact_exponent != 1.0:
        return 0.0
    return 2.0 * rotor.zeta * math.sqrt(rotor.shaft_stiffness + 1.0)


def map_of(name: str, omega: np.ndarray, friction: np.ndarray, settings: Settings) -> xr.Dataset:
    """Return the ends of runs from each start, and the speed from which whip exists."""
    rotors = [Rotor(omega=speed, friction=mu, **ROTORS[name]) for mu in friction for speed in omega]
    found = []
    with progress_bar(WORDS[name]) as progress, ThreadPoolExecutor(settings.workers) as pool:
        for ends in pool.map(ends_of, rotors):
            found.append(ends)
            progress(len(found), len(rotors))
    ends = np.array(found, dtype=np.int8).reshape(friction.size, omega.size, -1)
    flags = {
        "flag_values": np.array([-1, *ENDS.values()], dtype=np.int8),
        "flag_meanings": " ".join(["not_started", *ENDS]),
    }  # fmt: skip
    dims = ("friction", "omega")
    return xr.Dataset(
        {
            **{f"end_from_{name}": (dims, ends[..., place],
                                    {"long_name": f"end of a run from {words}", **flags})
               for place, (name, words) in enumerate(STARTS.items())},
            "birth_omega": (
                "friction", [birth(name, mu) for mu in friction],
                {"long_name": "speed from which whip exists without unbalance", "units": "1"}),
        },
        {
            "friction": ("friction", friction, {
                "long_name": "coefficient of friction in the contact", "units": "1"}),
            "omega": ("omega", omega, {
                "long_name": "spin speed over the reference frequency", "units": "1"}),
        },
        {"title": f"Dry whip over speed and friction: {WORDS[name]}"} | ROTORS[name],
    )  # fmt: skip


def reached(mapped: xr.Dataset) -> xr.DataArray:
    """Return the starts that lead to whip: 3 rest, 2 the knock, 1 whip alone, 0 none."""
    rest, knock, whip = (mapped[f"end_from_{name}"] >= FIRST_OF_WHIP for name in STARTS)
    return xr.where(rest, 3, xr.where(knock, 2, xr.where(whip, 1, 0)))


def draw(maps: dict[str, xr.Dataset], settings: Settings) -> None:
    figure, axes = mixed_panels(1, 2, height=4.2)
    colours = ("white", "#cfe3f5", "#ffd0a8", "#d98a78")
    lines = []
    for ax, (name, mapped) in zip(axes, maps.items(), strict=True):
        with style():
            ax.pcolormesh(
                mapped.omega, mapped.friction, reached(mapped), cmap=ListedColormap(colours),
                vmin=-0.5, vmax=3.5, shading="nearest", rasterized=True,
            )  # fmt: skip
            fine = np.geomspace(*FRICTIONS, 400)
            born = ax.plot([birth(name, mu) for mu in fine], fine, color=INK, lw=1.6,
                            label="whip is born (exact, no unbalance)")  # fmt: skip
            weakest = weakest_friction(name)
            if weakest > 0.0:
                limit = ax.axhline(weakest, color=GREY, lw=1.2, ls=(0, (4, 2)),
                                   label="below it no whip at any speed (exact)")  # fmt: skip
                lines.append(limit)
            ax.set(xscale="log", yscale="log", xlim=SPEEDS, ylim=FRICTIONS,
                   xlabel=r"spin speed $\omega$", ylabel=r"friction $\mu$")  # fmt: skip
            ax.set_xticks([0.1, 0.3, 1.0, 3.0], ["0.1", "0.3", "1", "3"])
            ax.set_yticks([0.03, 0.1, 0.3, 0.8], ["0.03", "0.1", "0.3", "0.8"])
            ax.minorticks_off()
            ax.grid(visible=False)
            ax.set_title(WORDS[name], fontsize=9.5)
    patches = [
        Patch(facecolor=colour, edgecolor=GREY, lw=0.6, label=words)
        for colour, words in zip(
            colours, ("no whip", "lasts only if started on it", "reached from the knock",
                      "reached from rest"),
            strict=True,
        )
    ]  # fmt: skip
    with style():
        figure.legend(handles=[*born, *lines, *patches], loc="outside lower center", ncols=2)
    settings.show(
        figure, "whip_map", archives=list(maps),
        shows="Where dry whip exists over speed and friction (line, exact without unbalance), "
        f"where a rotor stays in it, and where it reaches it from rest or from a knock of "
        f"{KNOCK:g} backwards along the stator: with a shaft (κ = 0.05) in a linear stator, and "
        "without in a Hertzian one (ζ = 0.05, δ₀ = 1, ρ = 10).",
        found=" ".join(told(name, mapped) for name, mapped in maps.items()),
    )  # fmt: skip


def told(name: str, mapped: xr.Dataset) -> str:
    """Return the gallery text on one rotor."""
    exists = mapped.omega >= mapped.birth_omega
    state = reached(mapped)
    beyond, without = int(exists.sum()), int((~exists).sum())
    counted = [int(((state >= least) & exists).sum()) for least in (1, 2, 3)]
    outside = int(((state > 0) & ~exists).sum())
    kinds = mapped.end_from_knock
    rolling, by_turns, reversing = (
        int((kinds == ENDS[end]).sum()) for end in ("rolling", "rolling_by_turns", "reversing")
    )
    first = mapped.omega.values[(state == 3).any("friction").values]
    text = (
        f"{WORDS[name][0].upper()}{WORDS[name][1:]}: of {beyond} places where whip exists, a rotor "
        f"that starts on it stays in it in {counted[0]}; the knock leads to it in {counted[1]}, "
        f"rest in {counted[2]}"
        + (f" (from ω = {first.min():.2g} on)" if first.size else "")
        + f"; of the {without} where it does not, {outside or 'none'} lead to it. After the knock "
        f"the disc rolls on in {rolling}, rolls and slips by turns in {by_turns}, and slides "
        f"both ways in {reversing}."
    )
    weakest = weakest_friction(name)
    return text + (f" No whip at any speed below μ = {weakest:.6f}." if weakest else "")


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
