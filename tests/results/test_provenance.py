"""What a result says of the command that made it: enough to type it again, nothing of a machine."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from rotor_ida import Rotor, simulate
from rotor_ida.results import provenance
from rotor_ida.results.provenance import described


@pytest.mark.parametrize(
    ("arguments", "module", "expected"),
    [
        (["/home/me/study.py", "--quick"], "", "study.py --quick"),
        (["./study.py", "a b", "data/run.nc"], "", "study.py 'a b' data/run.nc"),
        (["x.py", "/home/me/run.nc", "-o=/tmp/a/b.nc", "~/c.nc"], "", "x.py run.nc -o=b.nc c.nc"),
        (["x.py", r"C:\me\run.nc"], "", "x.py run.nc"),
        (["/lib/pytest/__main__.py", "-n0"], "pytest.__main__", "python -m pytest -n0"),
        (["/lib/study.py"], "study", "python -m study"),
        (["-c"], "", "python -c"),
        (["-"], "", "python -"),
        ([""], "", "interactive Python"),
        ([], "", "interactive Python"),
        (["/lib/ipykernel_launcher.py", "-f", "/run/k.json"], "ipykernel_launcher", "a notebook"),
        (["x.py", "\udcff", "a\nb"], "", "x.py '\\udcff' 'a b'"),
    ],
)
def test_command_is_told_without_folders(arguments: list[str], module: str, expected: str) -> None:
    assert described(tuple(arguments), module=module) == expected


def test_run_says_which_script_made_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/home/me/study.py", "--out", "/tmp/run.nc"])
    monkeypatch.setattr(sys.modules["__main__"], "__spec__", None)
    run = simulate(Rotor(omega=2.0, zeta=0.1, delta0=2.0), duration=1.0)
    assert run.command == "study.py --out run.nc"


@pytest.mark.parametrize("name", ["model.py", "core/model.h"])
def test_sources_in_python_and_in_c_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setattr(provenance, "__file__", str(tmp_path / "results" / "provenance.py"))
    (tmp_path / "core").mkdir()
    before = provenance.sources_digest.__wrapped__()
    (tmp_path / name).touch()
    assert provenance.sources_digest.__wrapped__() != before


def test_a_result_says_who_compiled_the_core() -> None:
    said = provenance.provenance({})
    assert {"core_compiler", "core_flags", "core_level"} <= {*said}
    assert all(isinstance(value, str) for value in provenance.core().values())


def test_no_compiler_and_no_level_decides_on_the_bits() -> None:
    assert not [name for name in provenance.computing() if name.startswith("core")]


def test_where_scikit_sundae_has_no_wheel_its_version_is_empty(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As on Linux on ARM, where Taylor series do without."""

    def version(name: str) -> str:
        if name == "scikit-sundae":
            raise provenance.PackageNotFoundError(name)
        return "1.0"

    monkeypatch.setattr(provenance, "version", version)
    told = provenance.versions.__wrapped__()
    assert told["scikit_sundae_version"] == ""
    assert told["numpy_version"] == "1.0"
