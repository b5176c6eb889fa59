"""C that is written of a mode that the model has not: it compiles, and computes what was stated."""

import ctypes
import subprocess
from ctypes import POINTER, c_double
from pathlib import Path
from runpy import run_path
from types import SimpleNamespace

import numpy as np
import pytest

from rotor_ida.model.derivation import derive
from rotor_ida.model.mode_functions import write_series, write_spent, write_values
from rotor_ida.model.modes import Mode, Model
from rotor_ida.model.symbols import Symbol
from rotor_ida.model.writing import FOLDER

ROOT = Path(__file__).parents[2]
STATE = ("x", "y", "x_", "spent")
AT, SLOPE = np.array([0.3, -0.4, 0.7, 0.1]), np.array([0.02, 0.05, -0.03, 0.0])
ROTOR = SimpleNamespace(zeta=0.07)
# What has no series here is read at eight parts of a step, four to a vector.
PROBE = """
void spent_at(const struct parameters *m, const double *state, const double *slope, double *spent)
{
    struct series series = {0};
    const vec4 parts[AT_ONCE] = {{0.0, 1.0, 2.0, 3.0}, {4.0, 5.0, 6.0, 7.0}};
    vec4 rate[AT_ONCE][2];
    memcpy(series.terms[0], state, TRIAL_SIZE * sizeof *state);
    memcpy(series.terms[1], slope, TRIAL_SIZE * sizeof *slope);
    trial_spent(m, &series, 1, parts, rate);
    for (int v = 0; v < AT_ONCE; v++)
        store(&spent[4 * v], rate[v][0]);
}
void expand(const struct parameters *m, const double *state, double *next)
{
    struct series series = {0};
    memcpy(series.terms[0], state, TRIAL_SIZE * sizeof *state);
    trial_expand(m, &series, 1);
    memcpy(next, series.terms[1], TRIAL_SIZE * sizeof *next);
}
"""


def named(value, name):
    """Return a value, as a local variable of the model with that name would hold it."""
    if isinstance(value, Symbol):
        value.name = name
    return value


def trial_rates(state, rotor):
    """Return rates with a drag by the speed, of which locals are called like parts of a state."""
    x, y, other, _ = state
    square = named(x * x + y * y, "x")
    speed = named(square**0.5, "y")
    return [-rotor.zeta * speed * x, -rotor.zeta * speed * y - x, -other * x, 0.0 * x]


def drawn_trial_rates(state, rotor):
    """Return the same, and what is spent: by roots, by a power, and by what does not change."""
    x, y, other, _ = state
    square = x * x + y * y
    spent = square**0.5 + square**0.25 * other**1.75 + rotor.zeta**0.5 * other / (1.0 + square)
    return [*trial_rates(state, rotor)[:-1], spent]


TRIAL = Mode(
    name="trial",
    state=STATE,
    rates=trial_rates,
    neighbour=None,
    pace=lambda _state: 1.0,
    guards=(),
    drawn_rates=drawn_trial_rates,
)
MODEL = Model(name="trial", modes=(TRIAL,), parameters=("zeta",), constants={}, columns=())


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Return the library that is compiled of what is written of the trial."""
    if not (ROOT / "hatch_build.py").is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(ROOT / "hatch_build.py"))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    derived = derive(TRIAL, MODEL)
    places = ", ".join(f"TRIAL_{name.upper()}" for name in (*STATE, "size"))
    lines = ['#include "motion.h"', f"enum {{ {places} }};"]
    lines += [*write_values(derived, ()), *write_series(derived, []), *write_spent(derived), PROBE]
    folder = tmp_path_factory.mktemp("written")
    (folder / "trial.c").write_text("\n".join(lines), encoding="utf-8")
    flags = hatch_build["flags"](compiler, "baseline", warnings=True)
    flags += ["-fvisibility=default", f"-I{FOLDER}", "-shared"]
    files = [str(folder / "trial.c"), "-lm", "-o", str(folder / "trial.so")]
    subprocess.run([*compiler, *flags, *files], check=True)
    return ctypes.CDLL(str(folder / "trial.so"))


def called(function, given, count):
    """Return what a written function fills, of a rotor whose second parameter is zeta."""
    arrays = [np.array([0.0, ROTOR.zeta, *[0.0] * 16]), *given, np.empty(count)]
    function(*(array.ctypes.data_as(POINTER(c_double)) for array in arrays))
    return arrays[-1]


def test_what_a_model_names_like_a_component_of_its_state_is_told_from_it(written):
    expected = trial_rates(AT, ROTOR)
    np.testing.assert_allclose(called(written.expand, [AT], 4), expected, rtol=1e-14)
    found = called(written.trial_field, [AT], 4)
    np.testing.assert_allclose(found, drawn_trial_rates(AT, ROTOR), rtol=1e-14)


def test_vectors_are_raised_to_powers_lane_by_lane(written):
    found = called(written.spent_at, [AT, SLOPE], 8)
    expected = [drawn_trial_rates(AT + part * SLOPE, ROTOR)[-1] for part in range(8)]
    np.testing.assert_allclose(found, expected, rtol=1e-14)
