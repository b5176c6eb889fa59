"""Describe exact whirls of one disc, and results of rotor systems over the speed."""

from __future__ import annotations

import xarray as xr

from rotor_ida.cli.variables import Description, Layout, Rows, is_in_si, tabled
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.results.growth_words import RESONANT, damped_words

FOUND_FOLDS = Rows(
    title="Folds", key="folds", lead="fold_omega", gaps=True,
    names=(*ALL_PARAMETERS[1:], "fold_omega", "fold_amplitude", "rate", "jump_omega"),
)  # fmt: skip
FOLDS = Layout("Rotor", (FOUND_FOLDS,))
WHIRLS = Layout("Rotor", (Rows(
    title="Synchronous whirls", key="whirls", lead="amplitude", gaps=True,
    names=(*ALL_PARAMETERS, "amplitude", "phase_lag", "stability", "growth_rate", "in_contact"),
), FOUND_FOLDS))  # fmt: skip
HOPF_POINTS = Layout("Rotor", (Rows(
    title="Hopf points", key="hopf_points", lead="hopf_omega", gaps=True,
    names=(*ALL_PARAMETERS[1:], "hopf_omega", "hopf_amplitude", "hopf_frequency"),
),))  # fmt: skip
BACKWARD_WHIRL = Layout("Rotor", (Rows(
    title="Backward whirls without unbalance", key="whirls", lead="amplitude", gaps=True,
    names=("kind", "amplitude", "whirl_speed", "stability", "growth_rate", "normal_force",
           "tangential_force"),
),))  # fmt: skip
CRITICAL = Rows(
    title="Critical speeds", key="critical_speeds", lead="critical_speed", digits=5,
    names=("critical_speed", "critical_damping_ratio", "peak_node", "peak_speed",
           "peak_major_axis", "amplification_factor"),
)  # fmt: skip
UNBALANCE_RESPONSE = Layout("Rotor system", (
    CRITICAL,
    Rows(
        title="At contacts", key="contacts", lead="unbalance_radius",
        names=("speed", "contact", "contact_node", "clearance", "unbalance_radius")),
    Rows(
        title="At nodes", key="nodes", lead="node_major_axis",
        names=("speed", "node", "node_major_axis", "node_minor_axis", "node_forward_amplitude",
               "node_forward_phase_lag", "node_backward_amplitude", "node_backward_phase_lag")),
))  # fmt: skip
_OF_WHIRL = ("stability", "growth_rate")
WHIRLS_OF_SYSTEM = Layout("Whirls", (
    CRITICAL,
    Rows(
        title="At contacts", key="whirls", lead="amplitude", gaps=True,
        names=("speed", "branch", "contact", "amplitude", "phase_lag", "normal_force",
               "in_contact", *_OF_WHIRL)),
    Rows(
        title="At nodes", key="nodes", lead="node_amplitude", gaps=True,
        names=("speed", "branch", "node", "node_amplitude", "node_phase_lag", *_OF_WHIRL)),
))  # fmt: skip
SPECIAL_SPEEDS = Layout("Rotor system", (
    Rows(
        title="Special speeds", key="special_speeds", lead="special_speed", prefix="special_",
        names=("special_speed", "special_kind", "whirl_speed", "grazed_contact",
               "hopf_frequency")),
    Rows(
        title="At contacts", key="contacts", lead="amplitude",
        names=("special", "contact", "contact_node", "amplitude", "in_contact")),
))  # fmt: skip
OF_CAMPBELL = (
    Rows(
        title="Critical speeds", key="critical_speeds", lead="critical_speed", prefix="critical_",
        names=("critical_stiffness", "critical_speed", "critical_sense",
               "critical_damping_ratio")),
    Rows(
        title="Eigenvalues", key="eigenvalues", lead="whirl_speed", gaps=True,
        names=("contact_stiffness", "speed", "eigenvalue", "whirl_speed", "damping_ratio",
               "whirl_sense")),
)  # fmt: skip
CLEARANCE_REPORT = Layout("Report", (
    Rows(
        title="Clearances", key="clearances", lead="clearance_verdict", digits=5,
        names=("contact", "contact_node", "clearance", "clearance_verdict", "sag_share",
               "first_touch_speed", "rub_force", "rub_speed", "rub_stability", "passage_rub_force",
               "whip_speed", "whip_force", "whip_stability")),
    Rows(
        title="Shares of the clearances", key="shares", lead="running_share", digits=5,
        names=("case", "contact", "running_share", "running_share_speed", "passage_share")),
    Rows(
        title="Critical speeds", key="critical_speeds", lead="critical_speed", digits=5,
        names=("critical_speed", "amplification_factor", "separation_margin", "required_margin")),
    Rows(
        title="Unbalance", key="unbalance", lead="applied_unbalance", digits=5,
        names=("case", "node", "applied_unbalance", "applied_phase", "scale_factor")),
))  # fmt: skip


def show_campbell(dataset: xr.Dataset, most: int | None) -> Description:
    """Return critical speeds and eigenvalues.

    Those damped too much for a resonance stand in a sentence; only JSON has them in the table.
    """
    record, _ = tabled(dataset, most, *OF_CAMPBELL)
    speeds, ratios = (dataset[name].values for name in ("critical_speed", "critical_damping_ratio"))
    _, parts = tabled(dataset.isel(critical=ratios <= RESONANT), most, *OF_CAMPBELL)
    units = "SI" if is_in_si(dataset) else "1"
    return record, [*damped_words(speeds, ratios, units), *parts]
