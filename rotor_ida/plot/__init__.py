"""Plots of datasets, in one style that stays legible in grey and with colour blindness.

`figure_of` draws the figure of any result. Each function ``plot_...`` draws one thing, of one disc
and of rotor systems alike; of a system a node or a contact is chosen by name or number. The
functions read labelled datasets only, and no simulation runs: an archive can be plotted without a
solver. They show nothing. A function with the keyword `ax` draws a single picture there, by default
on that of a new figure, and returns these axes; one without draws several and returns their figure,
whose ``axes`` they are. (`cycle_figure`, `cycles_figure` and `fit_figure` do so too.) All raise
`rotor_ida.InputError` for data that they cannot draw: a Dataset that lacks a variable or has
several values of a parameter that must have one, axes of another kind, or other units.

CONTRIBUTING.md ("A plot") lists what a new one needs.
"""

import os

from rotor_ida.errors import InputError

try:
    import matplotlib as _matplotlib  # noqa: F401 - before all that draw: it refuses its backend
except ValueError as _error:
    raise InputError(
        "MPLBACKEND must name a backend of matplotlib, such as agg, "
        f"got {os.environ.get('MPLBACKEND')!r}"
    ) from _error

from rotor_ida.plot.appearance import mixed_panels as mixed_panels
from rotor_ida.plot.appearance import panels as panels
from rotor_ida.plot.appearance import style as style
from rotor_ida.plot.basins import plot_attractor_fractions as plot_attractor_fractions
from rotor_ida.plot.basins import plot_attractor_map as plot_attractor_map
from rotor_ida.plot.basins import plot_attractors as plot_attractors
from rotor_ida.plot.basins import plot_basin as plot_basin
from rotor_ida.plot.basins import plot_basin_fractions as plot_basin_fractions
from rotor_ida.plot.branches import plot_branch as plot_branch
from rotor_ida.plot.branches import plot_curves as plot_curves
from rotor_ida.plot.cycles import cycle_figure as cycle_figure
from rotor_ida.plot.cycles import cycles_figure as cycles_figure
from rotor_ida.plot.cycles import plot_cycle as plot_cycle
from rotor_ida.plot.cycles import plot_lines as plot_lines
from rotor_ida.plot.cycles import plot_multipliers as plot_multipliers
from rotor_ida.plot.diagrams import plot_exponents as plot_exponents
from rotor_ida.plot.diagrams import plot_extrema as plot_extrema
from rotor_ida.plot.diagrams import plot_section as plot_section
from rotor_ida.plot.diagrams import plot_strobes as plot_strobes
from rotor_ida.plot.drops import plot_drops as plot_drops
from rotor_ida.plot.drops import save_orbit_film as save_orbit_film
from rotor_ida.plot.figures import figure_of as figure_of
from rotor_ida.plot.fits import fit_figure as fit_figure
from rotor_ida.plot.fits import plot_fit as plot_fit
from rotor_ida.plot.fits import plot_fit_residuals as plot_fit_residuals
from rotor_ida.plot.labels import parameter_text as parameter_text
from rotor_ida.plot.legends import shared_legend as shared_legend
from rotor_ida.plot.motion import plot_forces as plot_forces
from rotor_ida.plot.responses import plot_amplitude as plot_amplitude
from rotor_ida.plot.responses import plot_phase as plot_phase
from rotor_ida.plot.responses import plot_unbalance_response as plot_unbalance_response
from rotor_ida.plot.run_up import plot_run_up as plot_run_up
from rotor_ida.plot.run_ups import plot_endings as plot_endings
from rotor_ida.plot.run_ups import plot_largest_force as plot_largest_force
from rotor_ida.plot.run_ups import plot_run_ups as plot_run_ups
from rotor_ida.plot.runs import plot_node_orbits as plot_node_orbits
from rotor_ida.plot.runs import plot_run as plot_run
from rotor_ida.plot.saving import save_figure as save_figure
from rotor_ida.plot.signals.orbits import plot_centre_line as plot_centre_line
from rotor_ida.plot.signals.orbits import plot_orbit as plot_orbit
from rotor_ida.plot.signals.orbits import plot_trace as plot_trace
from rotor_ida.plot.signals.orders import plot_bode as plot_bode
from rotor_ida.plot.signals.orders import plot_orders as plot_orders
from rotor_ida.plot.signals.orders import plot_polar as plot_polar
from rotor_ida.plot.signals.spectra import plot_cascade as plot_cascade
from rotor_ida.plot.signals.spectra import plot_full_spectrum as plot_full_spectrum
from rotor_ida.plot.signals.spectra import plot_spectrogram as plot_spectrogram
from rotor_ida.plot.whirls import plot_backward_whirl as plot_backward_whirl
from rotor_ida.plot.whirls import plot_campbell as plot_campbell
from rotor_ida.plot.whirls import plot_clearance as plot_clearance
from rotor_ida.plot.whirls import plot_shape as plot_shape
from rotor_ida.plot.whirls import plot_whirl_shapes as plot_whirl_shapes
