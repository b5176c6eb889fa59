"""Every picture of one dataset: what it is drawn from, and what its axes show.

Datasets are made once, when a picture first needs one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import xarray as xr

from rotor_ida import (
    DimensionalRotor,
    Rotor,
    backward_whirl,
    basin,
    bifurcation_diagram,
    contact_forces,
    continue_cycle,
    folds,
    limit_cycle,
    lyapunov_exponent,
    plot,
    poincare_section,
    simulate,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms import clearance_curve, response_curve

REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=418.0, eccentricity=5e-6,
                           clearance=1e-5, speed=1495.0)  # fmt: skip
ROTOR = MACHINE.rotor()
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
WHIPPED = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
OF_CURVE = {"zeta": ROTOR.zeta, "delta0": 0.5}
WIDE = {"zeta": ROTOR.zeta, "delta0": 2.0}
PLANE = np.linspace(-3.0, 3.0, 4)


def _starts() -> dict[str, object]:
    # nothing that is beyond the model in SI units
    return {"omega": [0.4, 0.8], "starts": [REST]} | WIDE


_MAKERS: dict[str, Callable[[], xr.Dataset]] = {
    "run": lambda: simulate(ROTOR, start=REST, duration=40.0, samples=2001),
    "forces": lambda: contact_forces(made("run")),
    "entries": lambda: poincare_section(ROTOR, start=REST, revolutions=10, at="entry"),
    "turns": lambda: poincare_section(ROTOR, start=REST, revolutions=10),
    "exponents": lambda: lyapunov_exponent(ROTOR, start=REST, duration=200.0),
    "extrema": lambda: bifurcation_diagram(**_starts()),
    "curve": lambda: response_curve(**OF_CURVE, limits=(0.1, 2.0)),
    "folds": lambda: folds(**OF_CURVE),
    "wide_curve": lambda: response_curve(**WIDE, limits=(0.1, 2.0)),
    "wide_folds": lambda: folds(**WIDE),
    "whirls": lambda: synchronous_response(omega=[0.4, 0.8], **OF_CURVE),
    "sweep": lambda: sweep(omega=[0.4, 0.8], **OF_CURVE),
    "over_clearance": lambda: clearance_curve(omega=0.8, zeta=ROTOR.zeta, limits=(0.0, 1.0)),
    "at_clearance": lambda: sweep(omega=[0.8], zeta=ROTOR.zeta, delta0=[0.5]),
    "along_friction": lambda: sweep(
        WHIPPED, friction=[0.0, 0.1], zeta=0.5, direction="both", method="taylor"
    ),
    "whirls_of_friction": lambda: synchronous_response(
        WHIPPED, friction=np.linspace(0.0, 0.1, 11), zeta=0.5
    ),
    "basin": lambda: basin(ROTOR, x=PLANE, y=PLANE),
    "backward": lambda: backward_whirl(WHIPPED),
    "cycle": lambda: limit_cycle(BOUNCING, start=(2.6, 0.75, 0.66, -1.65), period=4.5),
    "branch": lambda: continue_cycle(BOUNCING, start=made("cycle"), limits=(0.3, 3.0)),
}


def lines_of(ax):
    """Return the lines of axes by their labels."""
    return {line.get_label(): line for line in ax.lines}


def line_of(ax, label):
    """Return the one line of axes that has a label."""
    (found,) = (each for each in ax.lines if each.get_label() == label)
    return found


def words_of(ax):
    """Return the words of the legend of axes."""
    return [text.get_text() for text in ax.get_legend().get_texts()]


def check_nothing_cut_off(figure):
    figure.draw_without_rendering()
    box = figure.get_tightbbox()
    assert min(box.x0, box.y0) >= -0.02
    assert box.x1 <= figure.get_figwidth() + 0.02
    assert box.y1 <= figure.get_figheight() + 0.02


@cache
def made(name: str) -> xr.Dataset:
    """Return one of the datasets."""
    return _MAKERS[name]()


@dataclass(frozen=True)
class Picture:
    """A picture: its function, its datasets, and label and kind of unit of each axis."""

    draw: Callable[..., object]
    dataset: str
    across: tuple[str, str]
    up: tuple[str, str]
    beside: Mapping[str, str] = field(default_factory=dict)
    options: Mapping[str, object] = field(default_factory=dict)

    def drawn(self, convert: Callable[[xr.Dataset], xr.Dataset] = lambda each: each, **options):
        """Return the axes with all that is drawn on them."""
        beside = {name: convert(made(other)) for name, other in self.beside.items()}
        return self.draw(convert(made(self.dataset)), **beside, **self.options, **options)

    def __str__(self) -> str:
        return "_".join([self.draw.__name__, self.dataset, *map(str, self.options.values())])


NUMBER, LENGTH, TIME = "number", "length", "time"
X, Y = ("x", LENGTH), ("y", LENGTH)
ALONG, ACROSS = ("rotating_x", LENGTH), ("rotating_y", LENGTH)
T, SPEED, AMPLITUDE, RADIUS = (
    ("t", TIME),
    ("omega", NUMBER),
    ("amplitude", LENGTH),
    ("radius", LENGTH),
)
LAG = ("phase_lag", NUMBER)
ON_CURVE = {"fold_points": "folds", "simulated": "sweep", "whirls": "whirls"}

PICTURES = (
    Picture(plot.plot_orbit, "run", X, Y),
    Picture(plot.plot_forces, "forces", T, ("force", "force")),
    Picture(plot.plot_section, "entries", ("angle", NUMBER), ("radial_velocity", "velocity")),
    Picture(plot.plot_section, "turns", ALONG, ACROSS),
    Picture(plot.plot_exponents, "exponents", T, ("running_exponent", "rate")),
    Picture(plot.plot_extrema, "extrema", SPEED, RADIUS),
    Picture(plot.plot_extrema, "extrema", SPEED, RADIUS,
            {"exact": "wide_curve", "fold_points": "wide_folds"}),
    Picture(plot.plot_amplitude, "curve", SPEED, AMPLITUDE, ON_CURVE),
    Picture(plot.plot_phase, "curve", SPEED, LAG, ON_CURVE),
    Picture(plot.plot_amplitude, "over_clearance", ("delta0", NUMBER), AMPLITUDE,
            {"simulated": "at_clearance"}),
    Picture(plot.plot_amplitude, "whirls_of_friction", ("friction", NUMBER), AMPLITUDE,
            {"simulated": "along_friction"}),
    Picture(plot.plot_basin, "basin", X, Y),
    Picture(plot.plot_backward_whirl, "backward", X, Y),
    Picture(plot.plot_cycle, "cycle", ALONG, ACROSS),
    Picture(plot.plot_multipliers, "cycle", ("multiplier_real", NUMBER),
            ("multiplier_imag", NUMBER)),
    Picture(plot.plot_lines, "cycle", ("frequency_over_omega", NUMBER),
            ("whirl_amplitude", LENGTH)),
    Picture(plot.plot_branch, "branch", SPEED, RADIUS),
)  # fmt: skip
