"""The registry of kinds of result: how each is recognised, shown and drawn.

Every dataset of the package has its kind in the attribute ``result_kind``. (``kind`` is taken: in
archives of bifurcation curves it names the bifurcation.) Older archives are recognised by their
variables and dimensions.

Functions are named here as ``module:name`` and imported when needed, so this module depends on
none of those that compute and draw. A new kind has a row here, its variables in
`rotor_ida.schema.quantities`, and is made by `rotor_ida.schema.labelled_dataset`.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import xarray as xr

from rotor_ida.model.parameters import PARAMETERS
from rotor_ida.schema import RESULT_KIND

OTHER = "other"


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One kind of result.

    Parameters
    ----------
    name : str
        Value of the attribute ``result_kind``.
    meaning : str
        Its name on the page on datasets.
    variables, dims : tuple of str
        Variables and dimensions of every result of the kind. Archives without a stated kind are
        recognised by these; a kind without any is not recognised.
    along : tuple of str
        Dimensions of the first of `variables`, if they are always the same.
    shown : str
        Function of the dataset and a number of rows that returns its record and its tables.
    drawn : str
        Function of the dataset that returns its figure, or axes in it; empty if there is none.
    """

    name: str
    meaning: str
    variables: tuple[str, ...] = ()
    dims: tuple[str, ...] = ()
    along: tuple[str, ...] = ()
    shown: str = "rotor_ida.cli.variables:show_by_dimension"
    drawn: str = ""

    def fits(self, dataset: xr.Dataset) -> bool:
        """Return whether a dataset has the variables and dimensions of this kind."""
        has_all = set(self.variables) <= dataset.variables.keys()
        if not has_all or not set(self.dims) <= set(dataset.dims):
            return False
        return not self.along or dataset[self.variables[0]].dims == self.along


_WHIRLS = "rotor_ida.plot.figures:figure_of_whirls"
_SHOWN = "rotor_ida.cli.describe"
_SIGNALS = "rotor_ida.cli.describe_signals"
_SYSTEM_WHIRLS = "rotor_ida.cli.describe_whirls"
_DRAWN = "rotor_ida.plot.figures"

# In the order in which archives without a stated kind are recognised.
KINDS = {
    kind.name: kind
    for kind in (
        Kind(
            name="drop", meaning="drop of a rotor system",
            variables=("whirl_turns", "standstill_time", "event_contact"), dims=("t", "node"),
            shown="rotor_ida.cli.describe_systems:show_drop",
            drawn="rotor_ida.plot:drop_figure",
        ),
        Kind(
            name="drop_ensemble", meaning="many drops of a rotor system",
            variables=("whirl_turns", "decided_fraction"), dims=("drop", "contact"),
            shown="rotor_ida.cli.describe_systems:show_drops",
            drawn="rotor_ida.plot:drops_figure",
        ),
        Kind(
            name="system_run", meaning="run of a rotor system", variables=("x", "event_contact"),
            dims=("t", "node"), shown="rotor_ida.cli.describe_systems:show_system_run",
            drawn=f"{_DRAWN}:figure_of_run",
        ),
        Kind(
            name="system_sweep", meaning="sweep of a rotor system",
            variables=("response", "touched", "node_amplitude"),
            dims=("speed", "start", "direction"),
            shown="rotor_ida.cli.describe_systems:show_system_sweep",
            drawn="rotor_ida.plot:system_sweep_figure",
        ),
        Kind(
            name="system_branch", meaning="branch of limit cycles of a rotor system",
            variables=("multiplier_real", "special_state"), dims=("point", "contact"),
            shown=f"{_SYSTEM_WHIRLS}:SYSTEM_BRANCH", drawn="rotor_ida.plot:system_branch_figure",
        ),
        Kind(
            name="system_cycle", meaning="limit cycle of a rotor system",
            variables=("multiplier_real", "node_radius_max"), dims=("t", "contact"),
            shown=f"{_SYSTEM_WHIRLS}:SYSTEM_CYCLE", drawn="rotor_ida.plot:system_cycle_figure",
        ),
        Kind(
            name="system_whirls", meaning="exact whirls of a rotor system",
            variables=("amplitude", "node_amplitude"), dims=("speed", "branch"),
            shown=f"{_SYSTEM_WHIRLS}:WHIRLS_OF_SYSTEM", drawn="rotor_ida.plot:system_whirls_figure",
        ),
        Kind(
            name="system_special_points", meaning="special speeds of a rotor system",
            variables=("special_speed",), shown=f"{_SYSTEM_WHIRLS}:SPECIAL_SPEEDS",
            drawn="rotor_ida.plot:special_speeds_figure",
        ),
        Kind(
            name="campbell", meaning="eigenvalues over the speed",
            variables=("whirl_speed", "damping_ratio"), dims=("eigenvalue",),
            shown=f"{_SYSTEM_WHIRLS}:EIGENVALUES", drawn="rotor_ida.plot:plot_campbell",
        ),
        Kind(
            name="clearance_report", meaning="report on close clearances",
            variables=("running_share", "clearance_verdict"), dims=("case", "contact"),
            shown=f"{_SYSTEM_WHIRLS}:show_clearance_report",
            drawn="rotor_ida.plot:clearance_report_figure",
        ),
        Kind(
            name="comparison", meaning="comparison", variables=("matched_branch",),
            shown=f"{_SHOWN}:show_comparison",
        ),
        Kind(
            name="basin", meaning="basin", variables=("label",), dims=("attractor",),
            shown=f"{_SHOWN}_basins:show_attractors", drawn="rotor_ida.plot:plot_basin",
        ),
        Kind(
            name="basin_fractions", meaning="basin fractions", variables=("response_fraction",),
            shown=f"{_SHOWN}_basins:show_attractors", drawn=f"{_DRAWN}:figure_of_fractions",
        ),
        Kind(
            name="atlas", meaning="atlas", variables=("missed_fraction",), dims=PARAMETERS,
            shown=f"{_SHOWN}_basins:show_atlas", drawn=f"{_DRAWN}:figure_of_atlas",
        ),
        Kind(
            name="touchdown", meaning="report on touching",
            variables=("missed_fraction", "excursion"), shown=f"{_SHOWN}_basins:show_touchdown",
        ),
        Kind(
            name="bifurcation_diagram", meaning="bifurcation diagram",
            variables=("extremum_radius",), shown=f"{_SHOWN}:show_sweep",
            drawn=f"{_DRAWN}:figure_of_diagram",
        ),
        Kind(
            name="run_ups", meaning="run-ups", variables=("ending", "rate", "to"),
            shown=f"{_SHOWN}:show_run_ups", drawn="rotor_ida.plot:run_ups_figure",
        ),
        Kind(
            name="sweep", meaning="sweep", variables=("response",), dims=PARAMETERS,
            shown=f"{_SHOWN}:show_sweep", drawn=_WHIRLS,
        ),
        Kind(
            name="run", meaning="run",
            variables=("event_time",), dims=("t",), along=("event",),
            shown=f"{_SHOWN}:show_run", drawn=f"{_DRAWN}:figure_of_run",
        ),
        Kind(
            name="whirls", meaning="exact whirls", variables=("amplitude",), dims=("branch",),
            shown=f"{_SHOWN}_whirls:WHIRLS", drawn=_WHIRLS,
        ),
        Kind(
            name="folds", meaning="folds", variables=("fold_omega",),
            shown=f"{_SHOWN}_whirls:FOLDS", drawn=_WHIRLS,
        ),
        Kind(
            name="hopf_points", meaning="Hopf points", variables=("hopf_omega",),
            shown=f"{_SHOWN}_whirls:HOPF_POINTS", drawn=_WHIRLS,
        ),
        Kind(
            name="backward_whirl", meaning="backward whirls",
            variables=("birth_omega",), dims=("whirl",),
            shown=f"{_SHOWN}_whirls:BACKWARD_WHIRL", drawn="rotor_ida.plot:plot_backward_whirl",
        ),
        Kind(
            name="curve", meaning="bifurcation curve", variables=("special_second_value",),
            shown=f"{_SHOWN}:show_curve", drawn=f"{_DRAWN}:figure_of_curve",
        ),
        Kind(
            name="fit", meaning="fit", variables=("estimate", "covariance"),
            shown=f"{_SHOWN}:show_fit", drawn="rotor_ida.plot:fit_figure",
        ),
        Kind(
            name="branch", meaning="branch", variables=("special_value",), dims=("special",),
            shown=f"{_SHOWN}:show_branch", drawn=f"{_DRAWN}:figure_of_branch",
        ),
        Kind(
            name="cycle", meaning="limit cycle", variables=("period_error", "multiplier_error"),
            shown=f"{_SHOWN}:show_cycle", drawn="rotor_ida.plot:cycle_figure",
        ),
        Kind(
            name="orders", meaning="orders", variables=("forward_whirl_amplitude",),
            shown=f"{_SIGNALS}:show_orders", drawn="rotor_ida.plot:plot_orders",
        ),
        Kind(
            name="centre_line", meaning="mean position", variables=("offset_x",),
            shown=f"{_SIGNALS}:show_centre_line", drawn="rotor_ida.plot:plot_centre_line",
        ),
        Kind(
            name="whirl_over_spin", meaning="whirl against spin", variables=("whirl_over_spin",),
            shown=f"{_SIGNALS}:show_whirl_over_spin",
        ),
        Kind(
            name="full_spectrum", meaning="full spectrum", variables=("noise_floor",),
            shown=f"{_SIGNALS}:show_full_spectrum", drawn="rotor_ida.plot:plot_full_spectrum",
        ),
        Kind(
            name="spectrogram", meaning="spectrogram", variables=("bandwidth",), dims=("window",),
            shown=f"{_SIGNALS}:show_spectrogram", drawn="rotor_ida.plot:plot_spectrogram",
        ),
        Kind(
            name="spectral_lines", meaning="lines of the spectrum",
            variables=("window_residual",), dims=("line",),
            shown=f"{_SIGNALS}:SPECTRAL_LINES",
        ),
        Kind(
            name="signals", meaning="signals", variables=("x", "y"), dims=("t",),
            shown=f"{_SIGNALS}:show_signals", drawn=f"{_DRAWN}:figure_of_signals",
        ),
        Kind(
            name="late_jumps", meaning="late jumps", shown=f"{_SHOWN}_whirls:FOLDS", drawn=_WHIRLS,
        ),
        Kind(
            name="run_up_summary", meaning="summary of a run-up",
            variables=("smallest_gap", "ending"), shown=f"{_SHOWN}:show_run_up_summary",
        ),
        Kind(name="contact_summary", meaning="summary of contacts"),
        Kind(name="contact_forces", meaning="contact forces"),
        Kind(name="spectrum", meaning="spectrum of a run"),
        Kind(name="section", meaning="section"),
        Kind(name="lyapunov_exponent", meaning="Lyapunov exponents"),
        Kind(name="response_curve", meaning="response curve"),
        Kind(name="torque_curve", meaning="Sommerfeld's curve"),
        Kind(name="cusps", meaning="cusps"),
        Kind(name="peaks", meaning="largest whirls"),
        Kind(name="impact", meaning="impact"),
        Kind(name="rest", meaning="rest"),
        Kind(name="free_vibration", meaning="periods of free vibration"),
        Kind(name="restoring_force", meaning="restoring force"),
        Kind(name="exact_motion", meaning="exact motion"),
        Kind(name=OTHER, meaning="any other dataset"),
    )
}  # fmt: skip


def kind_of(dataset: xr.Dataset) -> str:
    """Return the kind of a dataset: as stated, or from its variables and dimensions.

    A dataset without a part of its kind, such as a dimension removed by a selection, is recognised
    by the remaining ones.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    >>> kind_of(whirls), kind_of(whirls.isel(branch=0))
    ('whirls', 'other')
    """
    stated = KINDS.get(str(dataset.attrs.get(RESULT_KIND, "")))
    if stated is not None and stated.fits(dataset):
        return stated.name
    recognised = (kind for kind in KINDS.values() if kind.variables and kind.fits(dataset))
    return next((kind.name for kind in recognised), OTHER)


def loaded(place: str) -> Any:
    """Import and return an object named in the registry.

    Examples
    --------
    >>> loaded("rotor_ida.results.kinds:kind_of") is kind_of
    True
    """
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
