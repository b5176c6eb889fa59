"""What of a result another processor gives again, how exactly, and what it does not."""

from __future__ import annotations

# Difference allowed between a number of an archive and the same computed on another processor,
# relative to the largest number of its variable.
TOLERANCE = 1e-6
# The same for kinds of result whose numbers Newton's method or a polynomial gives.
TOLERANCE_OF_KIND = dict.fromkeys(
    ("cycle", "cycles", "branch", "curve", "system_cycle", "system_branch",
     "system_curve", "whirls", "folds",
     "hopf_points", "system_whirls", "system_special_points", "campbell", "clearance_report"),
    1e-8,
)  # fmt: skip
# Variables with a wider one, whatever the kind: that of a curve is found by finite differences.
TOLERANCE_OF_VARIABLE = {"slope": 1e-3}
# Variables compared within an error that the dataset itself states, and those whose numbers are
# compared each relative to itself.
STATED_ERROR = {"event_time": "event_time_error"}
EACH_BY_ITSELF = ("amplitude", "radius_min", "radius_max", "period")
_ROUNDING, _TRANSIENT = "of the size of rounding", "depends on the way to the steady state"
# Variables that another processor gives otherwise, and why.
DEPENDS_ON_ROUNDING = {
    **dict.fromkeys(
        ("residual", "trivial_defect", "symplectic_defect", "event_time_error", "period_error",
         "multiplier_error", "lyapunov_error", "horizon", "cycle_distance"),
        _ROUNDING,
    ),
    **dict.fromkeys(
        ("settling_time", "settling_median", "settling_95", "lifetime", "lifetime_low",
         "window_start", "window_end", "revolutions", "confirmed", "agreement", "agreement_count"),
        _TRANSIENT,
    ),
    "message": "words of a solver",
}  # fmt: skip
# Attributes that are neither results nor a part of the question, and why.
_MADE = "describes how it was computed"
NO_RESULTS = {
    **dict.fromkeys(
        ("Conventions", "title", "source", "command", "history", "references", "comment", "note",
         "result_kind", "question", "backend", "confirmation_backend", "computed_with",
         "date_created", "content_sha256"),
        _MADE,
    ),
    **dict.fromkeys(("sentence", "first_reason", "last_reason"), "words"),
    "evaluations": "work of a solver", "interrupted": "work of a solver",
}  # fmt: skip
# Beginnings and ends of the names of others.
OF_PROGRAM = (("core_", "rotor_ida_"), ("_version", "_units", "_scale"))


def why_no_result(attribute: str) -> str:
    """Return why an attribute is not compared; empty if it is a result or a part of the question.

    Examples
    --------
    >>> why_no_result("command"), why_no_result("numpy_version"), why_no_result("duration")
    ('describes how it was computed', 'describes how it was computed', '')
    """
    begins, ends = OF_PROGRAM
    if attribute.startswith("machine_"):
        return "of the machine, by which all numbers got their units"
    if attribute.startswith(begins) or attribute.endswith(ends):
        return _MADE
    return NO_RESULTS.get(attribute, "")
