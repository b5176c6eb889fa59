"""The functions of the core's own library of mathematics, which are those of the folder `libm`."""

from __future__ import annotations

import math
import shutil
import subprocess
from pathlib import Path
from runpy import run_path

import mpmath
import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
CORE = ROOT / "rotor_ida" / "core"
NAMES = ("sin", "cos", "exp", "expm1", "log", "log1p")
PROGRAM = """
#include <math.h>
#include <stdio.h>
int main(void)
{
    double x;
    while (fread(&x, sizeof x, 1, stdin) == 1) {
        const double found[] = {sin(x), cos(x), exp(x), expm1(x), log(x), log1p(x)};
        fwrite(found, sizeof found, 1, stdout);
    }
    return 0;
}
"""


@pytest.fixture(scope="module")
def functions(tmp_path_factory):
    """Return what maps an array of numbers to a column for each function, compiled alone."""
    if not (ROOT / "hatch_build.py").is_file():
        pytest.skip("an installed package has no sources to compile")
    hatch_build = run_path(str(ROOT / "hatch_build.py"))
    compiler = hatch_build["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    folder = tmp_path_factory.mktemp("libm")
    (folder / "program.c").write_text(PROGRAM, encoding="utf-8")

    def of_level(level: str):
        program = folder / level
        words = [*compiler, *hatch_build["flags"](compiler, level), str(folder / "program.c")]
        subprocess.run([*words, str(CORE / "libm.c"), "-lm", "-o", str(program)], check=True)

        def found(x):
            given = np.asarray(x, dtype=float).tobytes()
            said = subprocess.run([program], input=given, capture_output=True, check=True).stdout
            return dict(zip(NAMES, np.frombuffer(said).reshape(-1, len(NAMES)).T, strict=True))

        return found

    return of_level


def arguments():
    """Return numbers of all sizes, multiples of a quarter turn, and those about the bounds."""
    rng = np.random.default_rng(7)
    sizes = 10.0 ** rng.uniform(-20.0, 22.0, 600)
    turns = 0.5 * math.pi * rng.integers(1, 10**6, 200)
    near = [1e-300, 5e-324, 1e-8, 0.5, 0.9375, 1.0, 1.0625, 2.0**20 * math.pi, 709.7, 745.0, 1e22]
    whole = np.concatenate([sizes, turns, rng.uniform(0.0, 30.0, 600), near])
    return np.concatenate([whole, -whole])


def test_they_are_right_to_a_unit_in_the_last_place(functions):
    """Beside mpmath with 60 digits, which computes them in its own way."""
    x = arguments()
    found = functions("baseline")(x)
    defined = {"log": x > 0.0, "log1p": x > -1.0, "exp": np.abs(x) < 700.0, "expm1": x < 700.0}
    for name in NAMES:
        kept = defined.get(name, np.full(x.shape, True))
        assert kept.sum() > 900
        with mpmath.workdps(60):
            exact = [getattr(mpmath, name)(mpmath.mpf(float(each))) for each in x[kept]]
            pairs = zip(exact, found[name][kept].tolist(), strict=True)
            errors = [
                abs(float((mpmath.mpf(mine) - true) / math.ulp(float(true))))
                for true, mine in pairs
            ]
        assert 0.3 < max(errors) < 1.0, name


def test_what_has_no_finite_value_is_as_ieee_754_has_it(functions):
    found = functions("baseline")([0.0, -1.0, math.inf, -math.inf, math.nan, 800.0, -800.0, -0.0])
    nan, inf = math.nan, math.inf
    for name, values in {
        "sin": [0.0, None, nan, nan, nan, None, None, -0.0],
        "exp": [1.0, None, inf, 0.0, nan, inf, 0.0, 1.0],
        "expm1": [0.0, None, inf, -1.0, nan, inf, -1.0, -0.0],
        "log": [-inf, nan, inf, nan, nan, None, nan, -inf],
        "log1p": [0.0, -inf, inf, nan, nan, None, nan, -0.0],
    }.items():
        for mine, value in zip(found[name].tolist(), values, strict=True):
            assert value is None or repr(abs(mine)) == repr(abs(value)), name
            assert value in (None, 0.0, nan) or mine == value or math.isnan(mine), name
            assert value != 0.0 or math.copysign(1.0, mine) == math.copysign(1.0, value), name


def test_all_levels_have_the_same_bits(functions):
    from rotor_ida.core.library import offered

    x, levels = arguments(), offered()
    first = functions(levels[0])(x)
    for level in levels[1:]:
        found = functions(level)(x)
        for name in NAMES:
            assert found[name].tobytes() == first[name].tobytes(), (level, name)


def test_the_core_asks_no_system_for_them():
    """Of the names that its libraries take from the system, none is of these functions."""
    found = [*CORE.glob("librotor_*.so")]
    if not found or shutil.which("nm") is None:
        pytest.skip("there is no nm, or no library beside the sources")
    for path in found:
        said = subprocess.run(
            ["nm", "-D", "--undefined-only", path], capture_output=True, text=True, check=True
        )
        taken = {line.split()[-1].partition("@")[0] for line in said.stdout.splitlines()}
        assert "memset" in taken
        others = {"sincos", "pow", "cbrt", "hypot", "lgamma", "atan2", "tan"}
        assert not taken & {*NAMES, *others}, path.name
