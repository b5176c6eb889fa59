"""Pictures of datasets, in one style that survives the photocopier and colour blindness.

The functions here see labelled datasets only, so that an archive can be drawn where no solver is
installed. They return the axes that they drew on and show nothing by themselves.
"""

from rotor_ida.plot.appearance import panels, shared_legend, style
from rotor_ida.plot.basins import plot_basin
from rotor_ida.plot.responses import plot_amplitude, plot_phase
from rotor_ida.plot.runs import plot_orbit, plot_run
from rotor_ida.plot.saving import save_figure

__all__ = [
    "panels",
    "plot_amplitude",
    "plot_basin",
    "plot_orbit",
    "plot_phase",
    "plot_run",
    "save_figure",
    "shared_legend",
    "style",
]
