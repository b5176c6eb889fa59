"""Tutorials: their sentences are true of what they compute, and of what their commands do."""

import re
import shutil

import numpy as np
import pytest

from rotor_ida import load, load_system
from rotor_ida.cli.program import main
from rotor_ida.schema import RESPONSE
from tests.docs.pages import SCRIPTS, commands, names_of, said_by, text_of

RPM = np.pi / 30.0


@pytest.fixture(scope="module")
def study():
    return names_of("own_study")


def in_folder(folder, script, *files):
    """Yield the names of a tutorial that runs in a folder with its files."""
    for each in files:
        shutil.copy(SCRIPTS / each, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        yield names_of(script) | {"folder": folder}


@pytest.fixture(scope="module")
def compressor(tmp_path_factory):
    files = ("compressor.toml", "compressor.npz")
    yield from in_folder(tmp_path_factory.mktemp("compressor"), "compressor", *files)


@pytest.fixture(scope="module")
def run_down(tmp_path_factory):
    yield from in_folder(tmp_path_factory.mktemp("run_down"), "run_down")


def test_ross_gives_the_files_of_the_compressor(tmp_path, monkeypatch):
    pytest.importorskip("ross", reason="there is no ROSS")
    monkeypatch.chdir(tmp_path)
    (first, *_) = commands(text_of("compressor"))
    shutil.copy(SCRIPTS / first[1], tmp_path)
    assert main(first) == 0
    made, kept = load_system("compressor.toml"), load_system(SCRIPTS / "compressor.toml")
    for name in ("mass", "stiffness", "damping", "gyroscopic", "stiffness_rate"):
        whole = getattr(kept, name)
        np.testing.assert_allclose(getattr(made, name), whole, atol=1e-12 * np.abs(whole).max())
    assert (made.nodes, made.positions) == (kept.nodes, kept.positions)
    for mine, theirs in zip(made.bearings, kept.bearings, strict=True):
        assert mine.node == theirs.node
        for name in ("speed", "stiffness", "damping"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(theirs, name))


def test_the_commands_on_the_compressor_give_its_answers(compressor, monkeypatch, capsys):
    monkeypatch.chdir(compressor["folder"])
    block = re.search(r"code-block:: toml\n\n(.*?)\n\nIn Python", text_of("compressor"), re.DOTALL)
    added = "\n".join(line.strip() for line in block[1].splitlines())
    with open("compressor.toml", "a", encoding="utf-8") as file:
        file.write(f"\n{added}\n")
    given = load_system("compressor.toml")
    assert (given.contacts, given.unbalance) == (
        compressor["compressor"].contacts, compressor["compressor"].unbalance,
    )  # fmt: skip
    said = said_by(commands(text_of("compressor"))[1:], monkeypatch, capsys)
    assert len(said) == 4
    begins, turns = compressor["found"]
    assert f"{begins:.0f} threshold {turns / 60.0:.6g}" in said[1]
    assert " ".join(compressor["report"].attrs["sentence"].split()) in said[3]
    assert "report.pdf" in {each.name for each in (compressor["folder"] / "page").iterdir()}


def test_the_compressor_is_unstable_from_the_threshold_on(compressor):
    """By the eigenvalues of its matrices, which share nothing with the search."""
    for name, told, low, high in (("compressor", "found", 9900.0, 11000.0),
                                  ("worn_compressor", "found_worn", 9000.0, 9900.0)):  # fmt: skip
        system, (begins, turns) = compressor[name], compressor[told]
        assert low < begins < high
        for factor in (0.999, 1.001):
            speed = factor * begins * RPM
            held = system.at(speed)
            inverse = np.linalg.inv(held.mass)
            damping = held.damping + speed * held.gyroscopic
            matrix = np.block([[np.zeros_like(inverse), np.eye(len(inverse))],
                               [-inverse @ held.stiffness, -inverse @ damping]])  # fmt: skip
            found = np.linalg.eigvals(matrix)
            found = found[(np.abs(found.imag) > 1.0) & (np.abs(found.real) > 1e-6)]  # no torsion
            fastest = found[found.real.argmax()]
            assert (fastest.real > 0.0) == (factor > 1.0)
            assert abs(fastest.imag) == pytest.approx(turns * RPM, rel=1e-2)


def test_what_the_compressor_fills_is_as_told(compressor):
    report = compressor["report"]
    assert 0.15 < float(report.running_share.max()) < 0.25
    assert 0.6 < float(report.passage_share.max()) < 0.7
    assert compressor["sharp"].sum() == 1


def test_the_run_down_is_read_as_it_was_made(run_down):
    """Runout and gap are taken off, so that the noise of half a micrometre is left."""
    run, signals = run_down["run"], run_down["signals"]
    times = signals.t.values
    passing = times < 30.0  # before the slow roll, in which its own whirl goes too
    for name in ("x", "y"):
        apart = signals[name].values - 1e6 * np.interp(times, run_down["t"], run[name].values)
        assert abs(apart.mean()) < 0.15
        assert np.std(apart[passing]) < 0.55
    truth = run_down["truth"]
    assert run_down["below"] == pytest.approx(1e6 * truth.load / truth.shaft_stiffness, abs=0.1)


def test_the_run_down_has_its_critical_speed_and_forward_whirl(run_down):
    peak = 3000.0 / np.sqrt(1.0 - 2.0 * 0.05**2)  # of a rotor that passes slowly
    assert 0.99 * peak < run_down["found_speed"] < peak
    assert 9.4 < run_down["factor"] < 10.1
    np.testing.assert_allclose(run_down["ratio"], 1.0, atol=0.03)


def test_the_fit_of_the_run_down_finds_what_made_it(run_down):
    found = run_down["found"]
    off = (found.estimate.values - run_down["known"]) / found.standard_error.values
    assert (np.abs(off) < 2.0).all()


def test_the_commands_on_the_run_down_find_the_same(run_down, monkeypatch, capsys):
    monkeypatch.chdir(run_down["folder"])
    assert len(said_by(commands(text_of("run_down")), monkeypatch, capsys)) == 4
    found, errors = load("page/result.nc"), run_down["found"].standard_error.values
    assert (np.abs(found.estimate.values - run_down["known"]) < 2.0 * errors).all()
    page = (run_down["folder"] / "page" / "report.html").read_text("utf-8")
    assert "<td>critical speed</td><td>3000</td>" in page  # of the machine found


def test_friction_ends_the_rub_earlier_and_leads_to_dry_whip(study):
    found = study["found"].squeeze()
    radius = found.radius_max.values
    ends = [study["speeds"][np.flatnonzero(column > 2.0)[-1]] for column in radius.T[:4]]
    assert np.all(np.diff(ends) <= 0.0)
    assert ends[3] < ends[0]
    kinds = found.response.values.T
    assert np.all(kinds[:3] == RESPONSE["synchronous"])
    assert {RESPONSE["full_contact"], RESPONSE["bouncing"], RESPONSE["rolling"]} <= set(kinds[3])
    assert np.all(kinds[4] == RESPONSE["rolling"])


def test_every_point_of_the_study_lies_on_an_exact_response(study):
    assert np.nanmin(study["digits"]) > 9
    assert np.isfinite(study["digits"]).all()
