"""Pictures of datasets, in one style that survives the photocopier and colour blindness.

The functions here see labelled datasets only, so that an archive can be drawn where no solver is
installed. They return the axes that they drew on and show nothing by themselves.
"""

from rotor_ida.plot.appearance import panels, shared_legend, style
from rotor_ida.plot.exponents import plot_exponents
from rotor_ida.plot.extrema import plot_extrema
from rotor_ida.plot.forces import plot_force_peaks, plot_forces
from rotor_ida.plot.responses import plot_amplitude, plot_phase
from rotor_ida.plot.runs import plot_orbit, plot_rotating_orbit, plot_run
from rotor_ida.plot.saving import save_figure
from rotor_ida.plot.sections import plot_section
from rotor_ida.plot.spectra import plot_spectrum

__all__ = [
    "panels",
    "plot_amplitude",
    "plot_exponents",
    "plot_extrema",
    "plot_force_peaks",
    "plot_forces",
    "plot_orbit",
    "plot_phase",
    "plot_rotating_orbit",
    "plot_run",
    "plot_section",
    "plot_spectrum",
    "save_figure",
    "shared_legend",
    "style",
]
