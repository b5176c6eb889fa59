"""Practitioners' plots of simulated and measured signals.

Each function takes signals of `rotor_ida.signals_of` or `rotor_ida.read_signals`, a run or run-up,
or what `rotor_ida.orders`, `rotor_ida.full_spectrum`, `rotor_ida.spectrogram` or
`rotor_ida.centre_line` made of one. Speeds are in rpm and frequencies in Hz where times have a
unit, dimensionless otherwise. Exact results go `beneath` the picture.
"""

from rotor_ida.plot.signals.cascades import plot_cascade, plot_spectrogram
from rotor_ida.plot.signals.orbits import plot_centre_line, plot_orbit, plot_trace
from rotor_ida.plot.signals.orders import plot_bode, plot_orders, plot_polar
from rotor_ida.plot.signals.spectra import plot_full_spectrum

__all__ = [
    "plot_bode",
    "plot_cascade",
    "plot_centre_line",
    "plot_full_spectrum",
    "plot_orbit",
    "plot_orders",
    "plot_polar",
    "plot_spectrogram",
    "plot_trace",
]
