"""Plots of datasets, in one style that stays legible in grey and with colour blindness.

The functions read labelled datasets only, so an archive can be plotted without a solver. They
show nothing. One that draws a single picture draws on `ax`, by default that of a new figure, and
returns these axes; one that draws several returns their figure, whose ``axes`` they are. All raise
`rotor_ida.InputError` for data that they
cannot draw: a Dataset that lacks a variable or has several values of a parameter that must have
one, axes of another kind, or other units.

A new plot is exported here and drawn in ``tests/plot/pictures.py``; `rotor_ida.results.kinds` names
it if it is the figure of a kind of result, and `rotor_ida.cli.commands.plot` if the command offers
it.
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

from rotor_ida.plot.appearance import mixed_panels, panels, shared_legend, style
from rotor_ida.plot.basins import (
    plot_attractor_fractions,
    plot_attractor_map,
    plot_attractors,
    plot_basin,
    plot_basin_fractions,
)
from rotor_ida.plot.branches import plot_branch, plot_curves
from rotor_ida.plot.clearance_reports import clearance_report_figure, plot_clearance
from rotor_ida.plot.closed_forms import (
    plot_cuts,
    plot_deviation,
    plot_periods,
    plot_portrait,
    plot_solutions,
    plot_surface,
)
from rotor_ida.plot.cycles import cycle_figure, plot_cycle, plot_lines, plot_multipliers
from rotor_ida.plot.cycles_over import cycles_figure
from rotor_ida.plot.diagrams import diagram_figure, plot_extrema, plot_strobes
from rotor_ida.plot.drops import drop_figure, drops_figure, save_orbit_film
from rotor_ida.plot.dynamics import plot_exponents, plot_section, section_figure
from rotor_ida.plot.fits import fit_figure, plot_fit, plot_fit_residuals
from rotor_ida.plot.forces import plot_force_peaks, plot_forces
from rotor_ida.plot.labels import parameter_text
from rotor_ida.plot.responses import plot_along, plot_amplitude, plot_over_clearance, plot_phase
from rotor_ida.plot.run_up import plot_run_up
from rotor_ida.plot.run_ups import plot_endings, plot_largest_force, run_ups_figure
from rotor_ida.plot.runs import (
    plot_drawn_out,
    plot_history,
    plot_machine,
    plot_rotating_orbit,
    plot_run,
)
from rotor_ida.plot.saving import save_figure
from rotor_ida.plot.signals import (
    plot_bode,
    plot_cascade,
    plot_centre_line,
    plot_full_spectrum,
    plot_orbit,
    plot_orders,
    plot_polar,
    plot_spectrogram,
    plot_spectrum,
    plot_trace,
)
from rotor_ida.plot.system_cycles import (
    plot_system_cycle,
    system_cycle_figure,
)
from rotor_ida.plot.system_sweeps import plot_system_sweep, system_sweep_figure
from rotor_ida.plot.system_whirls import (
    plot_campbell,
    plot_special_speeds,
    plot_system_whirls,
    plot_unbalance_response,
    plot_whirl_shapes,
    special_speeds_figure,
    system_whirls_figure,
)
from rotor_ida.plot.systems import (
    plot_contact_forces,
    plot_node_history,
    plot_node_orbits,
    plot_shape,
    system_figure,
)
from rotor_ida.plot.whirls import (
    plot_backbone,
    plot_backward_whirl,
    plot_by_clearance,
    plot_by_damping,
    plot_cusp,
    plot_jumps,
)

__all__ = [
    "clearance_report_figure",
    "cycle_figure",
    "cycles_figure",
    "diagram_figure",
    "drop_figure",
    "drops_figure",
    "fit_figure",
    "mixed_panels",
    "panels",
    "parameter_text",
    "plot_along",
    "plot_amplitude",
    "plot_attractor_fractions",
    "plot_attractor_map",
    "plot_attractors",
    "plot_backbone",
    "plot_backward_whirl",
    "plot_basin",
    "plot_basin_fractions",
    "plot_bode",
    "plot_branch",
    "plot_by_clearance",
    "plot_by_damping",
    "plot_campbell",
    "plot_cascade",
    "plot_centre_line",
    "plot_clearance",
    "plot_contact_forces",
    "plot_curves",
    "plot_cusp",
    "plot_cuts",
    "plot_cycle",
    "plot_deviation",
    "plot_drawn_out",
    "plot_endings",
    "plot_exponents",
    "plot_extrema",
    "plot_fit",
    "plot_fit_residuals",
    "plot_force_peaks",
    "plot_forces",
    "plot_full_spectrum",
    "plot_history",
    "plot_jumps",
    "plot_largest_force",
    "plot_lines",
    "plot_machine",
    "plot_multipliers",
    "plot_node_history",
    "plot_node_orbits",
    "plot_orbit",
    "plot_orders",
    "plot_over_clearance",
    "plot_periods",
    "plot_phase",
    "plot_polar",
    "plot_portrait",
    "plot_rotating_orbit",
    "plot_run",
    "plot_run_up",
    "plot_section",
    "plot_shape",
    "plot_solutions",
    "plot_special_speeds",
    "plot_spectrogram",
    "plot_spectrum",
    "plot_strobes",
    "plot_surface",
    "plot_system_cycle",
    "plot_system_sweep",
    "plot_system_whirls",
    "plot_trace",
    "plot_unbalance_response",
    "plot_whirl_shapes",
    "run_ups_figure",
    "save_figure",
    "save_orbit_film",
    "section_figure",
    "shared_legend",
    "special_speeds_figure",
    "style",
    "system_cycle_figure",
    "system_figure",
    "system_sweep_figure",
    "system_whirls_figure",
]
