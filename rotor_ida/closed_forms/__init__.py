"""Exact results: synchronous whirls, their folds and stability, free flight and vibration.

This code and the simulator do not import each other: each is an independent check of the other.
"""

from rotor_ida.closed_forms.backward_whirl import backward_whirl
from rotor_ida.closed_forms.clearance_curve import clearance_curve
from rotor_ida.closed_forms.contact_free import (
    ContactFreeWhirl,
    contact_free_whirl,
    flight,
    touch_fading,
    touch_speeds,
)
from rotor_ida.closed_forms.folds import cusp, cusp_zeta, folds, jumps
from rotor_ida.closed_forms.free_vibration import (
    amplitude_from_speed,
    centre_speed,
    circular_period,
    free_periods,
    planar_period,
)
from rotor_ida.closed_forms.hopf import hopf_points
from rotor_ida.closed_forms.impact import impact
from rotor_ida.closed_forms.late_jumps import late_jumps
from rotor_ida.closed_forms.peaks import backbone, peak_amplitude, peaks, speeds_at_amplitude
from rotor_ida.closed_forms.ramp_flight import ramp_flight
from rotor_ida.closed_forms.response_curve import response_curve
from rotor_ida.closed_forms.rest import rest
from rotor_ida.closed_forms.restoring_field import restoring_field
from rotor_ida.closed_forms.sommerfeld import sommerfeld_curve, whirl_torque
from rotor_ida.closed_forms.stability import eigenvalues, stability_determinant
from rotor_ida.closed_forms.synchronous import synchronous_response

__all__ = [
    "ContactFreeWhirl",
    "amplitude_from_speed",
    "backbone",
    "backward_whirl",
    "centre_speed",
    "circular_period",
    "clearance_curve",
    "contact_free_whirl",
    "cusp",
    "cusp_zeta",
    "eigenvalues",
    "flight",
    "folds",
    "free_periods",
    "hopf_points",
    "impact",
    "jumps",
    "late_jumps",
    "peak_amplitude",
    "peaks",
    "planar_period",
    "ramp_flight",
    "response_curve",
    "rest",
    "restoring_field",
    "sommerfeld_curve",
    "speeds_at_amplitude",
    "stability_determinant",
    "synchronous_response",
    "touch_fading",
    "touch_speeds",
    "whirl_torque",
]
