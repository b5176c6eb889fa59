"""A call that may take long tells its progress; one of many jobs has workers, and is a study."""

import inspect

import pytest

import rotor_ida
from rotor_ida import closed_forms
from rotor_ida.results.question import VERBS

FUNCTIONS = {
    name: each for name in rotor_ida.__all__
    if inspect.isfunction(each := getattr(rotor_ida, name))
}  # fmt: skip
# Closed forms, files, and analyses of one result: seconds at most for whatever fits into memory.
QUICK = {
    *(name for name in FUNCTIONS if name in dir(closed_forms)),
    "load", "load_course", "load_machine", "load_system", "machine_from_data_sheet",
    "open_archive", "save", "save_machine", "read_signals", "status", "decode_flags", "concat",
    "dimensional", "summary", "contact_summary", "contact_forces", "rotating", "signals_of",
    "correct_probes", "subtract_runout", "filtered_orbit", "centre_line", "orders",
    "bode_peaks",
    "spectral_lines", "full_spectrum", "spectrogram", "whirl_ratio", "rub_signs",
    "ball_bearing_stiffness", "synchronous_response", "campbell", "clearance_report",
    "to_dataframe",
}  # fmt: skip
# Jobs that are no study: they resume one, or answer within minutes.
NO_STUDY = {"resume", "compare", "touchdown_report"}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_call_is_quick_or_tells_its_progress(name):
    parameters = inspect.signature(FUNCTIONS[name]).parameters
    assert ("progress" in parameters) != (name in QUICK)
    if name not in QUICK:
        assert "bool" in parameters["progress"].annotation
    assert ("workers" in parameters) <= ("study" in parameters or name in NO_STUDY)
    if "study" in parameters:
        assert name in VERBS  # so that it can be resumed
        assert name not in QUICK
