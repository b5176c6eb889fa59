"""Fit of a machine to noisy probe signals, with a check of the standard errors.

Six parameters of a machine are fitted to the noisy signals of one run-up with contact. The first
guesses from a data sheet are off by up to a third, the probes have noise of one micrometre, and the
angle of the unbalance is unknown. The fitted values are compared with the true ones, which are
known here.

Many trials check the standard errors: another rotor is measured repeatedly with independent noise,
and each fit is compared with the truth.

Writes the signals (measured.nc), the fitted values (found.nc), the errors of the trials
(trials.nc), and the figures as PNG and SVG.
"""

import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import xarray as xr
from scipy.stats import norm

from rotor_ida import DimensionalRotor, Rotor, dimensional, fit, run_up, signals_of
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import fit_figure, mixed_panels, style
from rotor_ida.plot.palette import BLUE, INK
from rotor_ida.schema import CONVENTIONS

REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(
    mass=4.0,  # kg
    contact_stiffness=3.2e7,  # N/m^1.5
    damping=89.1,  # N s/m
    eccentricity=10e-6,  # m
    clearance=25e-6,  # m
    speed=31.416,  # rad/s, where the run-up begins
    shaft_stiffness=5e4,  # N/m
)
LAST, SLOW = 2500, 50.0  # rpm, rpm/s
RPM = 2.0 * np.pi / 60.0  # rad/s
AHEAD = 0.7  # rad from the mark to the unbalance
NOISE = 1.0  # micrometres
SEED = 1
DATA_SHEET = {
    "damping": 60.0, "eccentricity": 13e-6, "clearance": 30e-6, "shaft_stiffness": 4.5e4,
    "contact_stiffness": 4e7,
}  # fmt: skip

TRIED = Rotor(omega=0.3, zeta=0.1, delta0=1.5, shaft_stiffness=1.0)
SOUGHT = {"zeta": TRIED.zeta, "delta0": TRIED.delta0, "shaft_stiffness": TRIED.shaft_stiffness}
GUESS = replace(TRIED, zeta=0.08, delta0=1.8, shaft_stiffness=0.9)
TRIAL_NOISE, TIME_ERROR = 0.02, 0.01
TRIALS, FEW = 300, 5
SYMBOLS = {"zeta": r"$\zeta$", "delta0": r"$\delta_0$", "shaft_stiffness": r"$k_s$"}


def main(settings: Settings) -> None:
    seen = signals_of_machine(*((1800, 200.0) if settings.quick else (LAST, SLOW)))
    settings.keep(seen, "measured")
    guess = replace(MACHINE, **DATA_SHEET)
    found = fit(seen, guess, [*DATA_SHEET, "unbalance_angle"])
    settings.keep(found, "found")
    draw_found(found, settings)
    trials = trials_with(FEW if settings.quick else TRIALS, settings.workers)
    settings.keep(trials, "trials")
    draw_trials(trials, settings)


def signals_of_machine(last: float, rate: float) -> xr.Dataset:
    """Return noisy signals of two probes, in micrometres, of a run-up to rpm at rpm/s."""
    samples = round(1000.0 * (last - 300.0) / rate) + 1
    run = run_up(MACHINE, to=last * RPM, rate=rate * RPM, samples=samples)
    seen = signals_of(dimensional(run, units={"length": "µm"}))
    # a run counts the angle of the unbalance, a keyphasor that of its mark
    seen["angle"] = seen["angle"].copy(data=seen["angle"].values - AHEAD)
    return with_noise(seen, NOISE, SEED)


def with_noise(signals: xr.Dataset, noise: float, seed: int) -> xr.Dataset:
    """Return signals whose x and y have white noise of this standard deviation."""
    rng = np.random.default_rng(seed)
    size = signals.sizes["t"]
    return signals.assign(
        {
            name: signals[name].copy(data=signals[name].values + rng.normal(0.0, noise, size))
            for name in ("x", "y")
        }
    )


def draw_found(found: xr.Dataset, settings: Settings) -> None:
    """Draw measured over fitted tracks, and state the errors of the fit."""
    true = {**{name: getattr(MACHINE, name) for name in DATA_SHEET}, "unbalance_angle": AHEAD}
    off = [
        (float(each.estimate) - true[name]) / float(each.standard_error)
        for name in true
        for each in [found.sel(unknown=name)]
    ]
    free = int(found["degrees_of_freedom"])
    settings.show(
        fit_figure(found), "found", archives=["measured", "found"],
        shows="Amplitude and lag from two noisy probes, over those of the fitted machine.",
        found=f"The six fitted values differ from the true ones by {min(map(abs, off)):.1f} to "
        f"{max(map(abs, off)):.1f} of their standard errors; the residual sum of squares is "
        f"{float(found['chi_square']) / free:.2f} of that expected from noise alone.",
    )  # fmt: skip


def trials_with(count: int, workers: int) -> xr.Dataset:
    """Return the error of each fit over its standard error."""
    run = run_up(TRIED, start=REST, to=2.0, rate=0.02, samples=2501)
    clean = signals_of(run)
    entries = run["event_time"].values[run["event_kind"].values == 1]
    jobs = [(clean, entries, seed) for seed in range(count)]
    if workers == 1:
        rows = [one_trial(*job) for job in jobs]
    else:
        with ProcessPoolExecutor(workers) as pool:
            rows = list(pool.map(one_trial, *zip(*jobs, strict=True), chunksize=8))
    words = {"long_name": "estimate less truth over the standard error stated", "units": "1"}
    return xr.Dataset(
        {"miss": (("trial", "unknown"), np.array(rows), words)},
        {"unknown": ("unknown", list(SOUGHT), {"long_name": "fitted parameter"})},
        {"Conventions": CONVENTIONS, "title": "Trials of a fit", "noise": TRIAL_NOISE},
    )


def one_trial(clean: xr.Dataset, entries: np.ndarray, seed: int) -> np.ndarray:
    """Return the error of one fit over its standard error."""
    late = np.random.default_rng([seed, 1]).normal(0.0, TIME_ERROR, entries.size)
    found = fit(
        with_noise(clean, TRIAL_NOISE, seed), GUESS, list(SOUGHT),
        entries=np.sort(entries + late), time_error=TIME_ERROR,
    )  # fmt: skip
    return (found["estimate"].values - list(SOUGHT.values())) / found["standard_error"].values


def draw_trials(trials: xr.Dataset, settings: Settings) -> None:
    """Draw the errors of the trials over the normal distribution."""
    covered = covered_of(trials)
    grid = np.linspace(-4.0, 4.0, 201)
    count = trials.sizes["trial"]
    with style():
        figure, axes = mixed_panels(1, len(SOUGHT), height=2.6)
        for name, ax in zip(SOUGHT, axes, strict=True):
            misses = trials["miss"].sel(unknown=name).values
            ax.hist(np.clip(misses, -4.0, 4.0), np.linspace(-4.0, 4.0, 17), density=True,
                    color=BLUE, alpha=0.45)  # fmt: skip
            ax.plot(grid, norm.pdf(grid), color=INK, lw=1.2)
            for edge in norm.ppf([0.025, 0.975]):
                ax.axvline(edge, color=INK, lw=0.7, ls=":")
            ax.set_title(f"{SYMBOLS[name]}: {covered[name]} of {count} covered", fontsize=9.0)
            ax.set_xlabel("error over its standard error")
        axes[0].set_ylabel("density of the trials")
    settings.show(
        figure, "trials", archives=["trials"],
        shows="Errors of fits to signals with independent noise, over their stated standard "
        "errors, on the normal distribution; dotted: limits of the 95 % intervals.",
        found=f"Of {count} intervals "
        f"{', '.join(f'{covered[name]}' for name in SOUGHT)} contain the true damping, clearance "
        f"and shaft stiffness; {0.95 * count:.0f} are expected.",
    )  # fmt: skip


def covered_of(trials: xr.Dataset) -> Mapping[str, int]:
    """Return the number of trials whose 95 % interval contains the true value."""
    edge = float(norm.ppf(0.975))
    return {name: int((abs(trials["miss"].sel(unknown=name)) <= edge).sum()) for name in SOUGHT}


if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
