"""Figure 7: basins of attraction.

At omega = 1.7, zeta = 0.07, delta0 = 0, starts at rest form one smooth egg round the small whirl,
where the paper sees a spider. So do starts from the centre with any velocity. Fast starts bend the
egg into a crescent, and starts with large angular momentum have arms. With clearance the picture
is different: contact-free, bouncing and full-contact responses share the plane.

Writes a basin for each plane and clearance, and the figures as PNG and SVG.
"""

import sys

import numpy as np

from rotor_ida import Rotor, basin
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import panels, plot_basin, style
from rotor_ida.schema import flags_of

OMEGA, ZETA = 1.7, 0.07
# Range of two of the coordinates, and values of the others.
PLANES = {
    "x_y": ({"x": 15.0, "y": 15.0}, {}),
    "vx_vy": ({"vx": 30.0, "vy": 30.0}, {}),
    "x_y_moving": ({"x": 30.0, "y": 30.0}, {"vx": -15.0}),
    "x_vy": ({"x": 60.0, "vy": 100.0}, {}),
}
CLEARANCES = (0.0, 0.5, 1.0, 2.0)


def main(settings: Settings) -> None:
    cells = 32 if settings.quick else 512
    rotor = Rotor(omega=OMEGA, zeta=ZETA, delta0=0.0)
    found = {}
    for name, (ranges, held) in PLANES.items():
        found[name] = follow(rotor, ranges, held, cells, settings)
        settings.keep(found[name], f"plane_{name}")
    small = found["x_y"].fraction.values[0]
    figure, axes = panels(2, 2, width=7.2, height=7.2, shared=False)
    for ax, plane in zip(axes, found.values(), strict=True):
        plot_basin(plane, ax=ax)
    one_legend(figure, axes)
    settings.show(
        figure, "fig07", archives=[f"plane_{name}" for name in PLANES],
        shows="Whirl reached from each start, for four planes of starts: at rest; from the "
        "centre with any velocity; everywhere with x′ = −15; and on the x axis with any y′.",
        paper="The shape of the attraction region looks like a spider.",
        verdict="For starts at rest it is one smooth egg.",
        found=f"For starts at rest it is one smooth egg round the small whirl, {small:.1%} of the "
        "square. Fast starts bend it into a crescent, and starts with much angular momentum, far "
        "out and moving across, have arms.",
    )  # fmt: skip

    coarse = 24 if settings.quick else 256
    figure, axes = panels(2, 2, width=7.2, height=8.8, shared=False)
    words = []
    for ax, delta0 in zip(axes, CLEARANCES, strict=True):
        rotor = Rotor(omega=OMEGA, zeta=ZETA, delta0=delta0)
        plane = follow(rotor, {"x": 15.0, "y": 15.0}, {}, coarse, settings)
        settings.keep(plane, f"clearance_{delta0:g}")
        plot_basin(plane, ax=ax)
        words.append(f"{kinds_reached(plane)} at δ₀ = {delta0:g}")
    settings.show(
        figure, "clearances", archives=[f"clearance_{delta0:g}" for delta0 in CLEARANCES],
        shows="The plane of starts at rest for four clearances.",
        found="Responses reached: " + "; ".join(words) + ".",
    )  # fmt: skip


def one_legend(figure, axes):
    """Draw one shared legend under the panels."""
    handles = axes[0].get_legend().legend_handles
    for ax in axes:
        ax.get_legend().remove()
    with style():
        figure.legend(handles=handles, loc="outside lower center", ncols=2)


def kinds_reached(plane):
    """Return the kinds of response that starts reach, in words."""
    reached = set(plane.kind.values[plane["count"].values > 0].tolist())
    names = [
        kind.replace("_", " ") for kind, flag in flags_of(plane.kind).items() if flag in reached
    ]
    return ", ".join(names)


def follow(rotor, ranges, held, cells, settings):
    """Return the basin over a square grid of two start coordinates."""
    axes = {name: np.linspace(-reach, reach, cells) for name, reach in ranges.items()}
    return basin(rotor, **{"x": 0.0, "y": 0.0, **held, **axes}, workers=settings.workers)


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
