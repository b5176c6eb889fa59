"""Eqs (24)–(28): the "general solution" of the paper beside the simulated motion.

The paper adds two exponentials to the whirl. The equation is nonlinear, so solutions do not
superpose. The paper also gives three different exponents, and its phase has the wrong sign. The
figures show the formula as printed, with corrected signs, and with exponents from the stiffness of
the whirl, for two starts. The motion near a whirl is described by its linearisation, whose four
exponents are exact. The last figure shows its error beside the others, from a start one percent
away.

Writes the comparisons (from_ten.nc, from_rest.nc, near_whirl.nc) and the figures as PNG and SVG.
"""

import cmath
import sys

import numpy as np
import xarray as xr
from scipy.linalg import expm

from rotor_ida import Rotor, simulate, synchronous_response
from rotor_ida.model.equations import rotated, rotating_jacobian
from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.paper.printed import general_solution
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import (
    mixed_panels,
    parameter_text,
    shared_legend,
    style,
)
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.palette import INK, look
from rotor_ida.schema import labelled

ROTOR = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
FORMULAS = {
    "as printed": {},
    "signs corrected": {"mended": True},
    "signs and exponents corrected": {"mended": True, "rates": "stiffness"},
}
LINEARISED = "linearised about the whirl"


def main(settings: Settings) -> None:
    whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.0)
    small, _, large = zip(
        whirls.amplitude.values.ravel(), whirls.phase_lag.values.ravel(), strict=True
    )
    for name, start, whirl, words in (
        ("from_ten", (10.0, 0.0, 0.0, 0.0), large, "(10, 0, 0, 0)"),
        ("from_rest", (0.0, 0.0, 0.0, 0.0), small, "rest"),
    ):
        compared = compare_formulas(start, *whirl)
        settings.keep(compared, name)
        draw(compared, name, words, settings)

    near = tuple(1.01 * part for part in on_whirl(*large))
    compared = compare_formulas(near, *large, linearised=True)
    settings.keep(compared, "near_whirl")
    draw(compared, "near_whirl", "one percent outside the large whirl", settings)


def on_whirl(amplitude: float, lag: float) -> tuple[float, float, float, float]:
    """Return the state on a whirl at time 0."""
    z = cmath.rect(amplitude, -lag)
    v = 1j * ROTOR.omega * z
    return (z.real, z.imag, v.real, v.imag)


def compare_formulas(start, amplitude: float, lag: float, *, linearised: bool = False):
    """Return the simulated motion with that of each formula."""
    run = simulate(ROTOR, start=start, duration=60.0, samples=1201)
    time = run.t.values
    given = {"start": start, "omega": 1.7, "zeta": 0.07, "amplitude": amplitude}
    table = [general_solution(time, **given, **options) for options in FORMULAS.values()]
    names = list(FORMULAS)
    if linearised:
        table.append(linear_motion(time, start, on_whirl(amplitude, lag)))
        names.append(LINEARISED)
    dims = ("solution", "t")
    return xr.Dataset(
        {
            "x": run.x,
            "y": run.y,
            "solution_x": labelled("solution_x", dims, np.real(table)),
            "solution_y": labelled("solution_y", dims, np.imag(table)),
        },
        {"t": run.t, "solution": names, **{name: run[name] for name in PARAMETERS}},
        {**run.attrs, "title": "The paper's general solution beside a simulated run"},
    )


def linear_motion(time, start, whirl) -> np.ndarray:
    """Return z(t) of the equation linearised about a whirl, on the rotating axes."""
    step = expm(rotating_jacobian(whirl, ROTOR) * time[1])
    offsets = [np.subtract(start, whirl)]
    for _ in time[1:]:
        offsets.append(step @ offsets[-1])
    states = rotated(np.add(whirl, offsets), ROTOR.omega * time)
    return states[:, 0] + 1j * states[:, 1]


def draw_solutions(ax, compared: xr.Dataset) -> None:
    """Draw x over time, simulated and from each formula."""
    ax.plot(compared.t, compared.x, color=INK, lw=1.4, label="simulated")
    for number, name in enumerate(compared.solution.values.tolist(), start=1):
        colour, line = look(number)
        ax.plot(compared.t, compared.solution_x.sel(solution=name), color=colour, ls=line, lw=1.0,
                label=name)  # fmt: skip
    ax.set(xlabel=LABELS["t"], ylabel=LABELS["x"], xlim=compared.t.values[[0, -1]])


def draw_errors(ax, error: xr.DataArray) -> None:
    """Draw the distance of each formula from the simulated motion over time."""
    for number, name in enumerate(error.solution.values.tolist(), start=1):
        colour, line = look(number)
        shown = error.sel(solution=name)
        ax.semilogy(error.t, shown.where(shown > 0.0), color=colour, ls=line, lw=1.1, label=name)
    ax.set(xlabel=LABELS["t"], ylabel=LABELS["deviation"], xlim=error.t.values[[0, -1]])


def draw(compared: xr.Dataset, name: str, words: str, settings: Settings) -> None:
    error = np.hypot(compared.solution_x - compared.x, compared.solution_y - compared.y)
    at_five = error.sel(t=5.0)
    first = {
        each: float(compared.t[int(np.argmax(error.sel(solution=each).values > 1.0))])
        for each in FORMULAS
    }
    figure, axes = mixed_panels(2, 1, height=4.8)
    with style():
        draw_solutions(axes[0], compared.sel(t=slice(0.0, 30.0)))
        draw_errors(axes[1], error)
    axes[1].set_ylim(max(1e-6, 0.5 * float(error.where(error > 0.0)[:, 20:].min())), 100.0)
    with style():
        parameters = {each: float(compared[each]) for each in PARAMETERS}
        axes[0].set_title(f"{parameter_text(parameters)},  from {words}")
    shared_legend(figure, axes, columns=4 if compared.sizes["solution"] < 4 else 3, outer=False)
    found = "; ".join(
        f"{each}: off by {float(at_five.sel(solution=each)):.3g} at t = 5"
        + (f", by more than 1 from t = {first[each]:.2f} on" if first[each] else "")
        for each in FORMULAS
    )
    if LINEARISED in compared.solution:
        linear = error.sel(solution=LINEARISED)
        found += f"; {LINEARISED}: never off by more than {float(linear.max()):.2g}"
    settings.show(
        figure, name, archives=[name],
        shows=f"x over time from {words}: simulated, and by eqs (24)–(28); below, the distance "
        "from the simulated motion.",
        paper='z = C₃ exp(λ₁t) + C₄ exp(λ₂t) + A exp(i(ωt + θ)) is "the '
        'general solution".',
        verdict="Wrong: it does not solve the nonlinear equation; off by "
        f"{float(at_five.sel(solution='as printed')):.3g} at t = 5."
        if name == "from_ten"
        else "",
        found=f"{found}. It does not solve the nonlinear equation.",
    )  # fmt: skip


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
