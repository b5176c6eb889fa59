"""The registry of kinds of result: how each is recognised, shown and drawn.

Every dataset of the package has its kind in the attribute ``result_kind``. (``kind`` is taken: in
archives of bifurcation curves it names the bifurcation.)

Functions are named here as ``module:name`` and imported when needed, so this module depends on
none of those that compute and draw. The function that builds a dataset gives the name of its kind
to `labelled_dataset`. CONTRIBUTING.md ("A kind of result") lists what a new kind needs besides a
row here.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

import xarray as xr

from rotor_ida.checks import COMPONENTS, listed
from rotor_ida.model.parameters import ALL_PARAMETERS, PARAMETERS
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM, SPEED
from rotor_ida.schema import RESULT_KIND, check_variables

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
    variables : str
        Variables of every result of the kind, with their dimensions in brackets; without brackets
        they have some of `dims`, parameters and components. Those with a question mark may be
        missing. A dataset without a part of these is of the kind ``other``.
    dims : str
        Dimensions of every result of the kind.
    shown : str
        Place, as ``module:name``, of a function of the dataset and a number of rows that returns
        its record and its tables, or of such an object, as ``FOLDS``.
    drawn : str
        Place of a function of the dataset that returns its figure, or axes in it (see
        `rotor_ida.plot.figures.figure_of`); empty if there is none.
    """

    name: str
    meaning: str
    variables: str = ""
    dims: str = ""
    shown: str = "rotor_ida.cli.variables:show_by_dimension"
    drawn: str = ""

    def lacking_in(self, dataset: xr.Dataset) -> str:
        """Return, in words, a variable or dimension of this kind that a dataset lacks, or ""."""
        for dim in self.dims.split():
            if dim not in dataset.sizes or (dim in _FILLED and not dataset.sizes[dim]):
                return f"values along {dim}"
        text = f"{self.variables} {_PARAMETERS}" if self.variables else ""
        for name, bracket, along, optional in _variables_in(text):
            if optional and name not in dataset.variables:
                continue
            found = {*dataset[name].dims} if name in dataset.variables else {None}
            axes = {
                *self.dims.split(),
                *ALL_PARAMETERS,
                *PARAMETERS_OF_SYSTEM,
                *COMPONENTS,
                *_OTHER_AXES,
            }
            if found != {*along.split()} if bracket else not found <= axes:
                return f"{name} along {listed(along.split())}" if along else str(name)
        return ""


_PARAMETERS = "".join(f"{name}? " for name in ALL_PARAMETERS)


@cache
def _variables_in(text: str) -> list[tuple[str, str, str, str]]:
    """Return names, brackets, dimensions in them and question marks in the text of a kind."""
    return re.findall(r"(\w+)(\(([\w ]*)\))?(\?)?", text)


# Further dimensions of variables that are stated without theirs.
_OTHER_AXES = ("direction", SPEED, "contact")
# Dimensions along which every result has at least one value.
_FILLED = frozenset(
    (*PARAMETERS, "t", "speed", "start", "direction", "rate", "phase", "window", "order", "point",
     "frequency")
)  # fmt: skip
_RESPONSES = "rotor_ida.plot.figures:draw_responses"
_SHOWN = "rotor_ida.cli.describe"
_SIGNALS = "rotor_ida.cli.describe_signals"
_WHIRLS = "rotor_ida.cli.describe_whirls"
_BASINS = "rotor_ida.cli.describe_basins"
_DRAWN = "rotor_ida.plot.figures"

_CONTACTS = (
    "clearance(contact) contact_node(contact) law_radius(contact)? law_stiffness(contact)? "
    "law_exponent(contact)? law_damping(contact)? law_friction(contact)?"
)
_SYSTEM_RUN = (
    "x(t node) mode(t contact) normal_force(t contact) t(t)? speed(t)? event_time(event) "
    "event_kind(event) event_contact(event) episode_contact(episode) entry_time(episode) "
    "peak_force(episode) rolling_time(episode) contact_stator(contact) excursion(contact) "
    + _CONTACTS
)  # fmt: skip
_OF_CONTACTS = "radius_max largest_force clearance contact_clearance? contact_node(contact)"
_STATES = "rotating_x rotating_y rotating_vx rotating_vy "
_STATES_OF_NODES = _STATES.replace(" ", "(crossing node) ")
_STARTS = "start_x(start) start_y(start) start_vx(start) start_vy(start)"
_BRANCH = "special_kind(special) period(point) radius_min(point) radius_max(point)"
_BRANCH_OF_SYSTEM = (
    "special_kind(special) special_value(special) multiplier_real(point multiplier) special_state "
    "contact_clearance(point contact)? " + _CONTACTS.replace("clearance(contact)", "clearance")
)
_WINDOWS = " t(window) speed(window)? window_residual(window)?"
_ORDERS = "order(order) window_residual(window) " + " ".join(
    f"{sense}_{what}(window order)"
    for sense in ("forward", "backward")
    for what in ("whirl_amplitude", "amplitude_error", "phase_lag")
)

KINDS = {
    kind.name: kind
    for kind in (
        Kind(name="drop", meaning="drop of a rotor system",
             variables=_SYSTEM_RUN + " whirl_turns(contact) standstill_time()",
             dims="t node contact event episode coordinate",
             shown="rotor_ida.cli.describe_systems:show_drop", drawn="rotor_ida.plot:plot_run_up"),
        Kind(name="drop_ensemble", meaning="many drops of a rotor system",
             variables="whirl_turns(drop contact) decided_fraction(contact) status(drop) "
             "contact_node(contact)", dims="drop contact",
             shown="rotor_ida.cli.describe_systems:show_drops", drawn="rotor_ida.plot:plot_drops"),
        Kind(name="system_run", meaning="run of a rotor system", variables=_SYSTEM_RUN,
             dims="t node contact event episode coordinate",
             shown="rotor_ida.cli.describe_systems:show_system_run",
             drawn=f"{_DRAWN}:draw_run"),
        Kind(name="system_sweep", meaning="sweep of a rotor system",
             variables="response touched node_amplitude radius_max largest_force clearance "
             "contact_clearance? contact_node(contact)", dims="speed start direction contact node",
             shown="rotor_ida.cli.describe_systems:show_system_sweep", drawn=_RESPONSES),
        Kind(name="system_diagram", meaning="bifurcation diagram of a rotor system",
             variables="extremum_radius(extremum) response " + _OF_CONTACTS,
             dims="speed start node contact",
             shown="rotor_ida.cli.describe_systems:show_system_sweep",
             drawn="rotor_ida.plot:plot_extrema"),
        Kind(name="system_stroboscopic_diagram", meaning="stroboscopic diagram of a rotor system",
             variables=_STATES + "response " + _OF_CONTACTS,
             dims="speed start crossing node contact",
             shown="rotor_ida.cli.describe_systems:show_system_sweep",
             drawn="rotor_ida.plot:plot_strobes"),
        Kind(name="system_section", meaning="section of a rotor system",
             variables="crossing_time(crossing) " + _STATES_OF_NODES + _CONTACTS,
             dims="crossing node contact", shown=f"{_SHOWN}:show_section",
             drawn="rotor_ida.plot:plot_section"),
        Kind(name="system_run_ups", meaning="run-ups of a rotor system",
             variables="ending rate(rate) to() largest_force failed_count clearance "
             "contact_clearance? contact_node(contact) law_radius(contact)?",
             dims="speed rate phase start contact node", shown=f"{_SHOWN}:show_run_ups",
             drawn="rotor_ida.plot:plot_run_ups"),
        Kind(name="system_curve", meaning="bifurcation curve of a rotor system",
             variables="special_second_value(special) " + _BRANCH_OF_SYSTEM,
             dims="point contact special component", shown=f"{_SHOWN}:show_curve",
             drawn=f"{_DRAWN}:draw_curve"),
        Kind(name="system_branch", meaning="branch of limit cycles of a rotor system",
             variables=_BRANCH_OF_SYSTEM, dims="point contact special component",
             shown=f"{_SHOWN}:show_branch", drawn="rotor_ida.plot:plot_branch"),
        Kind(name="system_cycle", meaning="limit cycle of a rotor system",
             variables="multiplier_real(multiplier) node_radius_max(node) " + _CONTACTS,
             dims="contact",  # t is empty where there is no cycle
             shown=f"{_SHOWN}:show_cycle", drawn="rotor_ida.plot:cycle_figure"),
        Kind(name="system_whirls", meaning="exact whirls of a rotor system",
             variables="amplitude node_amplitude " + _CONTACTS, dims="speed branch contact node",
             shown=f"{_WHIRLS}:WHIRLS_OF_SYSTEM", drawn=_RESPONSES),
        Kind(name="unbalance_response", meaning="unbalance response of a rotor system",
             variables="node_major_axis(speed node) unbalance_radius(speed contact) "
             "critical_speed(critical) amplification_factor(critical) " + _CONTACTS,
             dims="speed node", drawn=_RESPONSES,
             shown=f"{_WHIRLS}:UNBALANCE_RESPONSE"),
        Kind(name="system_special_points", meaning="special speeds of a rotor system",
             variables="special_speed " + _CONTACTS, dims="special contact",
             shown=f"{_WHIRLS}:SPECIAL_SPEEDS", drawn=_RESPONSES),
        Kind(name="campbell", meaning="eigenvalues over the speed",
             variables="whirl_speed damping_ratio", dims="speed eigenvalue contact_stiffness",
             shown=f"{_WHIRLS}:show_campbell", drawn="rotor_ida.plot:plot_campbell"),
        Kind(name="clearance_report", meaning="report on close clearances",
             variables="running_share clearance_verdict law_stiffness law_exponent " + _CONTACTS,
             dims="case contact", shown=f"{_WHIRLS}:CLEARANCE_REPORT",
             drawn="rotor_ida.plot:plot_clearance"),
        Kind(name="comparison", meaning="comparison",
             variables="matched_branch lies_on response digits delta0",
             dims="delta0 start direction", shown=f"{_SHOWN}:show_comparison"),
        Kind(name="basin", meaning="basin", variables="label", dims="attractor",
             shown=f"{_BASINS}:show_attractors", drawn="rotor_ida.plot:plot_basin"),
        Kind(name="basin_fractions", meaning="basin fractions", variables="response_fraction",
             dims="response", shown=f"{_BASINS}:show_attractors",
             drawn=f"{_DRAWN}:draw_fractions"),
        Kind(name="atlas", meaning="atlas",
             variables="missed_fraction() undecided_fraction kind fraction radius_max",
             dims="omega zeta delta0 attractor", shown=f"{_BASINS}:show_atlas",
             drawn=f"{_DRAWN}:draw_atlas"),
        Kind(name="touchdown", meaning="report on touching",
             variables="missed_fraction excursion(attractor) kind(attractor) "
             "velocity_shock(attractor target)? displacement_shock(attractor target)?",
             dims="attractor", shown=f"{_BASINS}:show_touchdown"),
        Kind(name="system_atlas", meaning="atlas of a rotor system",
             variables="missed_fraction() undecided_fraction kind fraction " + _OF_CONTACTS,
             dims="speed attractor contact", shown=f"{_BASINS}:show_atlas",
             drawn=f"{_DRAWN}:draw_atlas"),
        Kind(name="system_touchdown", meaning="report on touching of a rotor system",
             variables="missed_fraction excursion(attractor contact) kind(attractor) " + _CONTACTS,
             dims="attractor contact", shown=f"{_BASINS}:show_touchdown"),
        Kind(name="bifurcation_diagram", meaning="bifurcation diagram",
             variables="extremum_radius(extremum) response " + _STARTS,
             dims="omega zeta delta0 start", shown=f"{_SHOWN}:show_sweep",
             drawn=f"{_DRAWN}:draw_diagram"),
        Kind(name="stroboscopic_diagram", meaning="stroboscopic diagram",
             variables=_STATES + "response " + _STARTS, dims="omega zeta delta0 start crossing",
             shown=f"{_SHOWN}:show_sweep", drawn="rotor_ida.plot:plot_strobes"),
        Kind(name="run_ups", meaning="run-ups",
             variables="ending rate(rate) to() largest_force failed_count " + _STARTS,
             dims="rate phase start", shown=f"{_SHOWN}:show_run_ups",
             drawn="rotor_ida.plot:plot_run_ups"),
        Kind(name="sweep", meaning="sweep", variables="response " + _STARTS,
             dims="omega zeta delta0 start direction", shown=f"{_SHOWN}:show_sweep",
             drawn=_RESPONSES),
        Kind(name="run", meaning="run",
             variables="event_time(event) t(t)? speed(t)? entry_time(contact)? "
             "peak_indentation(contact)? peak_force(contact)? heat(contact)?", dims="t",
             shown=f"{_SHOWN}:show_run", drawn=f"{_DRAWN}:draw_run"),
        Kind(name="whirls", meaning="exact whirls", variables="amplitude omega zeta delta0",
             dims="branch", shown=f"{_WHIRLS}:WHIRLS", drawn=_RESPONSES),
        Kind(name="folds", meaning="folds", variables="fold_omega zeta delta0", dims="fold",
             shown=f"{_WHIRLS}:FOLDS", drawn=_RESPONSES),
        Kind(name="hopf_points", meaning="Hopf points", variables="hopf_omega zeta delta0",
             dims="hopf", shown=f"{_WHIRLS}:HOPF_POINTS", drawn=_RESPONSES),
        Kind(name="backward_whirl", meaning="backward whirls", variables="birth_omega",
             dims="whirl", shown=f"{_WHIRLS}:BACKWARD_WHIRL",
             drawn="rotor_ida.plot:plot_backward_whirl"),
        Kind(name="curve", meaning="bifurcation curve",
             variables="special_second_value(special) " + _BRANCH, dims="point special",
             shown=f"{_SHOWN}:show_curve", drawn=f"{_DRAWN}:draw_curve"),
        Kind(name="fit", meaning="fit",
             variables="estimate(unknown) covariance forward_amplitude_error(window order)?",
             dims="unknown unknown_too window", shown=f"{_SHOWN}:show_fit",
             drawn="rotor_ida.plot:fit_figure"),
        Kind(name="branch", meaning="branch",
             variables="special_value(special) stability(point) response(point) "
             "special_point(special) special_radius_min(special) special_radius_max(special) " +
             _BRANCH, dims="point special", shown=f"{_SHOWN}:show_branch",
             drawn="rotor_ida.plot:plot_branch"),
        Kind(name="cycles", meaning="limit cycles over a range of parameters",
             variables="period response stability status radius_max multiplier_real "
             "multiplier_imag period_error multiplier_error contact_node(contact)?",
             dims="multiplier", shown=f"{_SHOWN}:show_cycles",
             drawn="rotor_ida.plot:cycles_figure"),
        Kind(name="cycle", meaning="limit cycle",
             variables="period_error multiplier_error(multiplier) multiplier_real(multiplier) "
             "period() response() whirl_amplitude(line) line_kind(line) frequency(line)",
             shown=f"{_SHOWN}:show_cycle", drawn="rotor_ida.plot:cycle_figure"),
        Kind(name="orders", meaning="orders", variables=_ORDERS + _WINDOWS, dims="window order",
             shown=f"{_SIGNALS}:show_orders", drawn="rotor_ida.plot:plot_orders"),
        Kind(name="bode_peaks", meaning="peaks of a Bode plot", dims="critical",
             variables="half_power_low half_power_high bode_amplitude"),
        Kind(name="centre_line", meaning="mean position",
             variables="offset_x(window) offset_y(window) " + _WINDOWS, dims="window",
             shown=f"{_SIGNALS}:MEAN_POSITION", drawn="rotor_ida.plot:plot_centre_line"),
        Kind(name="whirl_over_spin", meaning="whirl against spin",
             variables="whirl_over_spin(window) whirl_sense(window) " + _WINDOWS, dims="window",
             shown=f"{_SIGNALS}:WHIRL_OVER_SPIN"),
        Kind(name="full_spectrum", meaning="full spectrum",
             variables="noise_floor() whirl_amplitude(frequency) frequency(frequency) bandwidth()",
             dims="frequency", shown=f"{_SIGNALS}:show_full_spectrum",
             drawn="rotor_ida.plot:plot_full_spectrum"),
        Kind(name="spectrogram", meaning="spectrogram",
             variables="bandwidth() whirl_amplitude(window frequency) frequency(frequency)" +
             _WINDOWS, dims="window frequency", shown=f"{_SIGNALS}:show_spectrogram",
             drawn="rotor_ida.plot:plot_spectrogram"),
        Kind(name="rub_signs", meaning="signs of rub", variables="line_order least_crest",
             shown=f"{_SIGNALS}:show_rub_signs"),
        Kind(name="spectral_lines", meaning="lines of the spectrum", variables="window_residual",
             dims="line", shown=f"{_SIGNALS}:SPECTRAL_LINES"),
        Kind(name="signals", meaning="signals", variables="x(t) y(t) t(t) angle(t)?", dims="t",
             shown=f"{_SIGNALS}:show_signals", drawn=f"{_DRAWN}:draw_signals"),
        Kind(name="late_jumps", meaning="late jumps", shown=f"{_WHIRLS}:FOLDS",
             drawn=_RESPONSES),
        Kind(name="run_up_summary", meaning="summary of a run-up", variables="smallest_gap ending",
             shown=f"{_SHOWN}:show_run_up_summary"),
        Kind(name="contact_summary", meaning="summary of contacts"),
        Kind(name="contact_forces", meaning="contact forces", drawn="rotor_ida.plot:plot_forces"),
        Kind(name="section", meaning="section", variables="crossing_time(crossing) " + _STATES,
             dims="crossing", shown=f"{_SHOWN}:show_section", drawn="rotor_ida.plot:plot_section"),
        Kind(name="lyapunov_exponent", meaning="Lyapunov exponents",
             drawn="rotor_ida.plot:plot_exponents"),
        Kind(name="response_curve", meaning="response curve",
             drawn="rotor_ida.plot:plot_amplitude"),
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
    """Return the kind that a dataset states; ``other`` if it lacks a part of that.

    One that states none is ``signals`` if it has their variables, as one made by hand.

    Raises
    ------
    InputError
        If a variable is not of the type that `QUANTITIES` states.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    >>> kind_of(whirls), kind_of(whirls.isel(branch=0))
    ('whirls', 'other')
    """
    stated = KINDS.get(str(dataset.attrs.get(RESULT_KIND, "signals")))
    if stated is None or stated.lacking_in(dataset):
        return OTHER
    check_variables(f"this {stated.meaning}", dataset)
    return stated.name


def why_not(dataset: xr.Dataset) -> str:
    """Return what a dataset lacks of the kind that it states, in words that follow its kind.

    Examples
    --------
    >>> from rotor_ida import synchronous_response
    >>> whirls = synchronous_response(omega=1.7, zeta=0.07, delta0=0.5)
    >>> why_not(whirls.drop_vars("amplitude")), why_not(whirls)
    (" (for 'whirls' it lacks amplitude)", '')
    """
    stated = KINDS.get(str(dataset.attrs.get(RESULT_KIND, "")))
    lacking = stated.lacking_in(dataset) if stated else ""
    return f" (for {stated.name!r} it lacks {lacking})" if stated and lacking else ""


def loaded(place: str) -> Any:
    """Import and return an object named in the registry.

    Examples
    --------
    >>> loaded("rotor_ida.results.dataset_kinds:kind_of") is kind_of
    True
    """
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
