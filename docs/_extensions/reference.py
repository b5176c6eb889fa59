"""Pages of the reference that come from the code: the public names, and the command line."""

import re
import shutil
from pathlib import Path

from notation import public_names

from rotor_ida.cli.program import SHORT, application
from rotor_ida.schema import flags as categories

HERE = Path(__file__).parents[1]
# The main functions by task. A public name that is in no list is shown under the last title.
TASKS = {
    "Describe a rotor": [
        *("Rotor", "DimensionalRotor", "machine_from_data_sheet", "load_machine", "save_machine"),
        "dimensional",
    ],
    "Describe a rotor system": [
        *("RotorSystem", "Contact", "Stator", "Race", "Unbalance", "Support", "Bearing"),
        *("ball_bearing_stiffness", "load_system", "load_course"),
    ],
    "Simulate": [
        *("simulate", "run_up", "run_ups", "summary", "contact_summary", "contact_forces"),
        "rotating",
    ],
    "Drops on touchdown bearings": ["drop", "drop_ensemble"],
    "Exact responses": [
        *("synchronous_response", "folds", "hopf_points", "backward_whirl", "impact", "rest"),
        *("special_speeds", "campbell", "clearance_report"),
    ],
    "Steady states, sweeps and chaos": [
        *("sweep", "compare", "bifurcation_diagram", "poincare_section", "lyapunov_exponent"),
    ],
    "Limit cycles and branches": [
        *("limit_cycle", "continue_cycle", "bifurcation_curve", "branches_through"),
    ],
    "Basins of attraction": [
        *("basin", "basin_fractions", "continue_attractors", "touchdown_report"),
    ],
    "Probe signals": [
        *("read_signals", "signals_of", "orders", "bode_peaks", "centre_line", "whirl_ratio"),
        *("full_spectrum", "spectrogram", "spectral_lines", "filtered_orbit", "correct_probes"),
        "subtract_runout",
    ],
    "Fit a measurement": ["fit"],
    "Archives, tables and studies": [
        *("save", "load", "open_archive", "to_dataframe", "decode_flags", "concat"),
        *("status", "resume"),
    ],
    "Errors and modules": [],
}
PARTS = {
    "rotor_ida.closed_forms": "Closed forms",
    "rotor_ida.plot": "Plots",
    "rotor_ida.testing": "Assertions for your own tests",
    "rotor_ida.paper.printed": "The paper's formulas, as printed",
}
HEAD = """Functions and classes
=====================

Find a function by its task; each links to its docstring with an example. Quantities are
dimensionless where a docstring says so; :doc:`/model` defines the units.

"""


def write_names():
    """Write the page of names; autosummary makes a page of each."""
    text = HEAD
    rest = set(listed("rotor_ida")).difference(*TASKS.values())
    for title, names in TASKS.items():
        text += section("rotor_ida", title, names or sorted(rest))
    known = listed("rotor_ida")  # these have their pages above
    for module, title in PARTS.items():
        text += section(module, title, [name for name in listed(module) if name not in known])
    write(HERE / "functions.rst", text)


def listed(module):
    """Return the public names of a module that are not constants."""
    return [name for name in public_names(module) if not name.isupper()]


def section(module, title, names):
    """Return one section of the page of names."""
    lines = "\n".join(f"   {name}" for name in names)
    return (
        f"{title}\n{'-' * len(title)}\n\n.. currentmodule:: {module}\n\n"
        f".. autosummary::\n   :toctree: api\n   :template: name.rst\n\n{lines}\n\n"
    )


def write_commands():
    """Write the page of commands from their own help."""
    found = application().generate_docs(output_format="markdown")
    found = re.sub(r"## Table of Contents\n\n(?:- .*\n)+\n", "", found)
    for name, short in SHORT.items():
        link = f"[`{name}`](#rotor-ida-{name})"
        found = found.replace(link, f"{link} (`{short}`)")
    write(HERE / "command_line.md", found.replace("# rotor-ida\n", "# The command line\n", 1))


def write(path, text):
    """Write a file if it is to change, so that what is up to date stays so."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def write_categories():
    """Write the list of the words of categories, which the page on datasets includes."""
    lines = []
    for name, flags in vars(categories).items():
        if name.isupper() and isinstance(flags, dict) and set(map(type, flags.values())) == {int}:
            words = ", ".join(f"{word} {number}" for word, number in flags.items())
            lines.append(f"- `{name}`: {words}")
    write(HERE / "categories.md", "\n".join(lines) + "\n")


def setup(_app):
    """Write the pages before Sphinx looks for its sources; what an older build wrote goes."""
    for folder in ("api", "gallery", "tutorials"):
        shutil.rmtree(HERE / folder, ignore_errors=True)
    write_names()
    write_categories()
    write_commands()
    return {"parallel_read_safe": True}
