"""The core is loaded for this processor, and refused in a sentence where it is not what it was."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import pytest

from rotor_ida import Rotor
from rotor_ida.cli import main
from rotor_ida.core import identity, interface
from rotor_ida.core import library as module
from rotor_ida.core.library import build_info
from rotor_ida.errors import InputError, InstallationError

# whatever was loaded before
library = module.library.__wrapped__
WIDEST = library().core_widest_level()


@pytest.fixture(autouse=True)
def asked_anew() -> Iterator[None]:
    """Nothing that was loaded before is remembered, nor what is loaded here afterwards."""
    remembered = (module._load, module.offered, module.library, interface.library)
    for function in remembered:
        function.cache_clear()
    yield
    for function in remembered:
        function.cache_clear()


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of the core, which is then the one in use."""
    made = [
        identity.library_path(module.FOLDER, level, model)
        for level, model in product(identity.LEVELS, identity.MODELS)
    ]
    for path in [*identity.core_sources(module.FOLDER), *filter(Path.is_file, made)]:
        place = tmp_path / path.relative_to(module.FOLDER)
        place.parent.mkdir(exist_ok=True)
        shutil.copy(path, place)
    monkeypatch.setattr(module, "FOLDER", tmp_path)
    return tmp_path


@pytest.mark.parametrize("model", identity.MODELS)
def test_a_copy_is_as_good(folder: Path, model: str) -> None:
    assert identity.stated(library(model))["sources"] == build_info()["sources"]


def test_build_info_says_how_it_was_compiled() -> None:
    info = build_info()
    assert all(info.values())
    assert "-ffp-contract=off" in info["flags"]
    assert info["sources"] == identity.sources_digest(module.FOLDER)


@pytest.mark.parametrize("model", identity.MODELS)
@pytest.mark.parametrize("level", identity.LEVELS[: 1 + WIDEST])
def test_every_level_that_the_processor_has_can_be_chosen(
    monkeypatch: pytest.MonkeyPatch, level: str, model: str
) -> None:
    monkeypatch.setenv("ROTOR_IDA_CPU", level)
    said = identity.stated(library(model))
    assert said["level"] == level
    assert ("-DWHOLE_MODEL" in said["flags"]) == (model != "paper")
    assert ("-DRUN_UP" in said["flags"]) == (model == "run_up")


def test_a_rotor_is_followed_by_the_library_that_knows_it() -> None:
    """The paper's rotor keeps its own; whatever has more takes that of the whole."""
    paper = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}
    assert interface.library_of(Rotor(**paper)) is interface.library("paper")
    for more in ("shaft_stiffness", "contact_damping", "load"):
        machine = interface.library_of(Rotor(**paper, **{more: 0.1}))
        assert machine is interface.library("whole")
    assert interface.library_of(Rotor(**paper, contact_exponent=1.0)) is machine


@pytest.mark.parametrize("nothing", [None, ""])
def test_the_widest_level_is_the_default(
    monkeypatch: pytest.MonkeyPatch, nothing: str | None
) -> None:
    monkeypatch.delenv("ROTOR_IDA_CPU", raising=False)
    if nothing is not None:
        monkeypatch.setenv("ROTOR_IDA_CPU", nothing)
    assert identity.stated(library())["level"] == identity.LEVELS[WIDEST]


@pytest.mark.parametrize("level", ["v5", "Baseline", "v4 "])
def test_a_level_that_is_none_is_refused(monkeypatch: pytest.MonkeyPatch, level: str) -> None:
    monkeypatch.setenv("ROTOR_IDA_CPU", level)
    with pytest.raises(InputError, match=f"must be one of baseline, v3, v4, got '{level}'"):
        library()


def test_a_level_that_the_processor_has_not_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "_load", lambda _: SimpleNamespace(core_widest_level=lambda: 1))
    monkeypatch.setenv("ROTOR_IDA_CPU", "v4")
    with pytest.raises(InputError, match="must be at most v3 on this processor, got 'v4'"):
        library()


def test_a_missing_core_is_refused(folder: Path) -> None:
    identity.library_path(folder, "baseline").unlink()
    with pytest.raises(InstallationError, match=r"librotor_baseline\.so is missing; run: pip "):
        library()


def test_a_missing_core_of_the_whole_model_is_missed_by_machines_alone(folder: Path) -> None:
    for path in folder.glob("librotor_whole_*.so"):
        path.unlink()
    assert library()
    with pytest.raises(InstallationError, match=r"librotor_whole_\w+\.so is missing; run: pip "):
        library("whole")


def forged(content: bytes) -> bytes:
    """Return a library as if for a processor that there is not."""
    return content[:18] + b"\xff\x7f" + content[20:]


@pytest.mark.parametrize("spoilt", [lambda _: b"", lambda _: b"no library", forged])
def test_a_core_that_cannot_be_loaded_is_refused(folder: Path, spoilt) -> None:
    path = identity.library_path(folder, "baseline")
    content = path.read_bytes()
    path.unlink()
    path.write_bytes(spoilt(content))
    with pytest.raises(InstallationError, match=r"broken or of another platform \(.*run: pip "):
        library()


@pytest.mark.parametrize("part", [0.1, 0.5, 0.99])
def test_a_core_that_is_cut_off_is_refused(folder: Path, part: float) -> None:
    """Before it is loaded: that would end the process with a bus error."""
    path = identity.library_path(folder, "baseline")
    content = path.read_bytes()
    path.unlink()
    path.write_bytes(content[: int(part * len(content))])
    with pytest.raises(InstallationError, match=r"is cut off; run: pip "):
        library()


@pytest.mark.parametrize("other", [("baseline", "whole"), ("v3", "paper")])
def test_a_core_of_another_level_or_model_is_refused(folder: Path, other: tuple[str, str]) -> None:
    taken = identity.library_path(folder, *other)
    if not taken.is_file():
        pytest.skip("this machine has one level")
    path = identity.library_path(folder, "baseline")
    path.unlink()
    shutil.copy(taken, path)
    with pytest.raises(InstallationError, match=rf"is of level {other[0]} .* '{other[1]}', where"):
        library()


def test_a_core_of_another_version_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module.importlib.metadata, "version", lambda _: "9.9")
    with pytest.raises(InstallationError, match=r"is of version .*, rotor-ida of 9\.9; run: pip "):
        library()


@pytest.mark.parametrize("change", ["edited", "added", "removed"])
def test_a_core_older_than_its_sources_is_refused(folder: Path, change: str) -> None:
    if change == "removed":
        (folder / "core.h").unlink()
    else:
        with (folder / ("core.h" if change == "edited" else "more.c")).open("a") as source:
            source.write("\n")
    with pytest.raises(InstallationError, match=r"is older than its sources; run: pip "):
        library()


def test_without_sources_the_core_is_trusted(folder: Path) -> None:
    for path in identity.core_sources(folder):
        path.unlink()
    assert library()


def test_the_command_that_mends_it_is_that_of_a_checkout_or_of_a_wheel(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    identity.library_path(folder, "baseline").unlink()
    with pytest.raises(
        InstallationError, match=r"run: pip install --force-reinstall, from where rotor-ida came$"
    ):
        library()
    checkout = folder / "rotor_ida" / "core"
    monkeypatch.setattr(module, "FOLDER", checkout)
    (folder / "hatch_build.py").touch()
    with pytest.raises(InstallationError, match=r"run: pip install -e \.$"):
        library()


def test_the_program_says_it_in_one_line(monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.setenv("ROTOR_IDA_CPU", "v9")
    rotor = ["--omega", "2", "--zeta", "0", "--delta0", "9"]
    assert main(["simulate", *rotor, "--start", "0", "0", "0", "0", "--duration", "1"]) == 2
    said = "rotor-ida: ROTOR_IDA_CPU must be one of baseline, v3, v4, got 'v9'\n"
    assert capsys.readouterr() == ("", said)
