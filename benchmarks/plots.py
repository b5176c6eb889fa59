"""How long plots of a million samples take, calculated and drawn to PNG, over one of a thousand.

    python benchmarks/plots.py [--samples 1000000]

The ratio to a plot of few samples, in the same run, is what more samples cost; the seconds hang on
the machine.
"""

import argparse
import io
import time

import numpy as np

from rotor_ida import plot
from rotor_ida.schema import labelled_dataset

KINDS = (
    "plot_cascade", "plot_spectrogram", "plot_full_spectrum", "plot_bode", "plot_polar",
    "plot_orders", "plot_orbit", "plot_centre_line", "plot_trace",
)  # fmt: skip
FEW = 10_000


def signals(samples):
    """Return signals of a run-up with forward and backward whirl and noise."""
    times = 0.01 * np.arange(samples)
    angle = 1.0 * times + times**2 / times[-1]
    rng = np.random.default_rng(28)
    noise = rng.normal(size=samples) + 1j * rng.normal(size=samples)
    z = np.exp(1j * angle) + 0.1 * np.exp(-1j * angle) + 0.02 * noise
    columns = {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", angle)}
    return labelled_dataset("Signals", columns, {"t": ("t", times)})


def seconds(kind, given):
    """Return the seconds that a plot takes with its calculation, drawn to PNG."""
    begin = time.perf_counter()
    drawn = getattr(plot, kind)(given)
    figure = (drawn[0] if isinstance(drawn, list) else drawn).figure
    figure.savefig(io.BytesIO(), format="png", dpi=200)
    return time.perf_counter() - begin


def main():
    """Print a table of seconds and ratios."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=1_000_000)
    given = parser.parse_args()
    few, many = signals(FEW), signals(given.samples)
    print(f"{'plot':20s} {'seconds':>8s} {'ratio':>6s}   {given.samples} samples over {FEW}")
    for kind in KINDS:
        seconds(kind, few)  # what is imported and built once does not count
        short, whole = min(seconds(kind, few) for _ in range(3)), seconds(kind, many)
        print(f"{kind:20s} {whole:8.2f} {whole / short:6.1f}")


if __name__ == "__main__":
    main()
