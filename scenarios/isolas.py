"""Isolas of limit cycles, and a narrow range of stable ones.

A branch of limit cycles need not be connected to a whirl. At zeta = 0.07, delta0 = 0.5 and 2, it is
an isola: continued over the speed from a cycle of a simulated rotor, it passes two folds and closes
on itself. Continuation from the synchronous whirls would never find it. At delta0 = 2 the isola
folds near omega = 0.4. Between that fold and the next period doubling, cycles are stable over a
range less than 0.003 wide. The rotor bounces there, although hardly any start leads to it. Curves
of folds and period doublings show where the isolas end over speed and clearance, beside those of
the synchronous whirls.

Writes the branches (isola_1.nc, isola_2.nc), the curves (curves_1.nc and so on), a simulated
check inside the narrow range (sliver.nc), and the figures as PNG and SVG.
"""

import sys

import numpy as np
import xarray as xr

from rotor_ida import (
    Rotor,
    bifurcation_curve,
    compare,
    continue_cycle,
    folds,
    limit_cycle,
    sweep,
)
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import panels, plot_branch, plot_curves, shared_legend
from rotor_ida.schema import EXACT, SPECIAL, STABILITY

ZETA = 0.07
CASES = {0.5: (3.0, (3.0, 1.0, 0.0, 0.0)), 2.0: (2.0, (0.0, 0.0, 0.0, 0.0))}
LIMITS = (0.05, 5.0)
# A curve that passes this close to a bifurcation, between two of its points, contains it.
NEAR = 0.03
PLANE = {"omega": (0.1, 4.5), "delta0": (0.1, 4.5)}


def main(settings: Settings) -> None:
    isolas = []
    for number, (delta0, (omega, start)) in enumerate(CASES.items(), start=1):
        rotor = Rotor(omega=omega, zeta=ZETA, delta0=delta0)
        isolas.append(continue_cycle(rotor, start=start, limits=LIMITS))
        settings.keep(isolas[-1], f"isola_{number}")
    low, high = sliver_of(isolas[1])
    witness = inside(isolas[1], 0.5 * (low + high))
    settings.keep(witness, "sliver")
    draw_isolas(isolas, (low, high), witness, settings)

    curves = []
    for isola in isolas:
        for special in np.flatnonzero(isola.special_kind != SPECIAL["graze"]):
            kind = next(
                word for word, flag in SPECIAL.items() if flag == isola.special_kind[special]
            )
            here = float(isola.special_value[special]), float(isola.delta0)
            if any(passes(curve, kind, here) for curve in curves):
                continue
            rotor = Rotor(omega=here[0], zeta=ZETA, delta0=here[1])
            curves.append(
                bifurcation_curve(
                    rotor, start=isola.isel(special=special), kind=kind, limits=PLANE,
                    points=40 if settings.quick else 400,
                )
            )  # fmt: skip
            settings.keep(curves[-1], f"curves_{len(curves)}")
    draw_curves(curves, settings)


def sliver_of(isola: xr.Dataset) -> tuple[float, float]:
    """Return the speeds between which the cycles near the lowest fold are stable."""
    doubled = isola.special_value.where(isola.special_kind == SPECIAL["period_doubling"])
    return float(folds_of(isola).min()), float(doubled.min())


def folds_of(isola: xr.Dataset) -> np.ndarray:
    """Return the speeds at which a branch folds."""
    return isola.special_value.values[isola.special_kind == SPECIAL["fold"]]


def inside(isola: xr.Dataset, omega: float) -> xr.Dataset:
    """Return the run of a rotor started beside the stable cycle of the narrow range."""
    stable = isola.where((isola.stability == STABILITY["stable"]) & (isola.omega < 0.5), drop=True)
    near = stable.isel(point=int(np.argmin(np.abs(stable.omega.values - omega))))
    rotor = Rotor(omega=omega, zeta=float(isola.zeta), delta0=float(isola.delta0))
    start = [float(near[name]) for name in ("x", "y", "vx", "vy")]
    cycle = limit_cycle(rotor, start=start, period=float(near.period))
    beside = [1.0001 * float(cycle[name][0]) for name in ("x", "y", "vx", "vy")]
    swept = sweep(omega=omega, zeta=rotor.zeta, delta0=rotor.delta0, starts=[beside])
    return compare(swept)


def passes(curve: xr.Dataset, kind: str, place: tuple[float, float]) -> bool:
    """Return whether a curve of a kind passes this place of the plane."""
    away = np.hypot(curve.omega.values - place[0], curve.delta0.values - place[1])
    return curve.attrs["kind"] == kind and bool(away.min() < NEAR)


def draw_isolas(
    isolas: list[xr.Dataset],
    sliver: tuple[float, float],
    witness: xr.Dataset,
    settings: Settings,
) -> None:
    figure, axes = panels(3, 1, height=9.0, shared=False)
    for ax, isola in zip(axes, isolas, strict=False):
        plot_branch(isola, ax=ax)
    low, high = sliver
    ax = plot_branch(isolas[1], ax=axes[2])
    shown = witness.squeeze()
    ax.plot(
        [float(shown.omega)] * 2, [float(shown.radius_min), float(shown.radius_max)],
        "o-", color="k", ms=4, lw=1.2, label="simulated", zorder=3.5,
    )  # fmt: skip
    width = high - low
    ax.set_xlim(low - 0.5 * width, high + 1.0 * width)
    near = isolas[1].where(np.abs(isolas[1].omega - low) < 2 * width, drop=True)
    ax.set_ylim(0.0, 1.08 * float(near.radius_max.max()))
    ax.set_title(
        ax.get_title() + ", the narrow stable range", fontsize=axes[0].title.get_fontsize()
    )
    shared_legend(figure, axes, columns=4, outer=False)
    digits = float(witness.digits.squeeze())
    lies = int(witness.lies_on.squeeze()) == EXACT["cycle"]
    closed = ["closes" if isola.attrs["closed"] else "does not close" for isola in isolas]
    settings.show(
        figure,
        "isolas",
        archives=["isola_1", "isola_2", "sliver"],
        shows="The branches of limit cycles at δ₀ = 0.5 and 2 over the speed, and the left end of "
        "the second enlarged.",
        found="; ".join(
            f"at δ₀ = {float(isola.delta0):g} the branch {word} on itself, between folds at ω = "
            f"{folds_of(isola).min():.10f} and {folds_of(isola).max():.10f}"
            for isola, word in zip(isolas, closed, strict=True)
        ).capitalize()
        + f". Near the left end of the second, cycles are stable from {low:.10f}, a fold, to "
        f"{high:.10f}, a period doubling: {high - low:.4f} wide. "
        + (
            f"A rotor simulated inside it stays on the exact cycle, to {digits:.1f} digits."
            if lies
            else "A rotor simulated inside it does not stay there."
        ),
    )


def draw_curves(curves: list[xr.Dataset], settings: Settings) -> None:
    figure, (ax,) = panels(1, 1, width=6.4, height=5.6)
    clearances = np.linspace(PLANE["delta0"][0], PLANE["delta0"][1], 30 if settings.quick else 150)
    plot_curves(curves, ax=ax, fold_points=folds(zeta=ZETA, delta0=clearances))
    ax.set(xlim=PLANE["omega"], ylim=PLANE["delta0"])
    largest = max(float(curve.residual.max()) for curve in curves)
    settings.show(
        figure,
        "curves",
        archives=[f"curves_{number + 1}" for number in range(len(curves))],
        shows="Folds and period doublings of limit cycles over speed and clearance, beside the "
        "folds of the synchronous whirls.",
        found=f"{sum(curve.sizes['point'] for curve in curves)} points on {len(curves)} curves; "
        f"each cycle closes to {largest:.0e} of its size. The isolas of the previous figure are "
        "sections through this map at δ₀ = 0.5 and 2.",
    )


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
