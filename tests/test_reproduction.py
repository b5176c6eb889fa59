import pytest

from rotor_ida import InputError, load, reproduction
from rotor_ida.reproduction import reproduce, scenario_scripts
from rotor_ida.scenario import Settings, run_script

# It starts processes as a sweep does, which fails where a script is not run as a script.
WORKING = '''
"""A small sweep."""
import sys
from rotor_ida import save, sweep
from rotor_ida.scenario import progress_bar, run_script

def main(settings):
    with progress_bar("sweep") as progress:
        found = sweep(omega=[1.0, 1.2], zeta=1.0, delta0=0.0, workers=settings.workers,
                      progress=progress)
    save(found, settings.folder / "found.nc", overwrite=settings.force)

if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
'''
FAILING = "raise SystemExit(3)\n"


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """Three scenarios, of which the second fails."""
    folder = tmp_path / "scripts"
    folder.mkdir()
    texts = {"a_works": WORKING, "b_fails": FAILING, "c_works": WORKING}
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(text)
    found = {name: folder / f"{name}.py" for name in texts}
    monkeypatch.setattr(reproduction, "scenario_scripts", lambda: found)
    return found


def test_scenarios_of_the_clone_are_found():
    assert scenario_scripts()["fig10_11_amplitude"].is_file()


def test_goes_on_when_one_fails_and_says_which(scripts, tmp_path, capfd):
    out = tmp_path / "results"
    assert reproduce(out, quick=True, workers=2) == 1
    assert load(out / "a_works" / "found.nc").sizes["omega"] == 2
    assert (out / "c_works" / "found.nc").is_file()
    shown = capfd.readouterr()
    assert "b_fails failed after 0 s with exit status 3" in shown.err
    assert "1 of 3 failed: b_fails" in shown.err


def test_runs_only_what_was_asked(scripts, tmp_path):
    assert reproduce(tmp_path / "results", only=["c_works"], workers=1) == 0
    assert [path.name for path in (tmp_path / "results").iterdir()] == ["c_works"]


def test_results_that_are_there_are_not_touched(scripts, tmp_path):
    kept = tmp_path / "results" / "c_works" / "found.nc"
    kept.parent.mkdir(parents=True)
    kept.write_text("mine")
    with pytest.raises(InputError, match="c_works' holds results already"):
        reproduce(tmp_path / "results", workers=1)
    assert kept.read_text() == "mine"
    assert not (tmp_path / "results" / "a_works").exists()
    assert reproduce(tmp_path / "results", only=["c_works"], workers=1, force=True) == 0
    assert load(kept).sizes["omega"] == 2


def test_unknown_scenario_is_refused(scripts, tmp_path):
    with pytest.raises(InputError, match=r"scenario must be one of a_works, .* got 'd'"):
        reproduce(tmp_path, only=["d"])


def test_script_gets_its_settings(tmp_path, capsys):
    seen: list[Settings] = []
    arguments = ["--quick", "--out", str(tmp_path), "--workers", "3"]
    assert run_script(seen.append, description="", script="x/fig.py", arguments=arguments) == 0
    assert seen == [Settings(tmp_path / "fig", True, 3, False)]
    assert seen[0].folder.is_dir()


def test_script_refuses_what_is_there_and_bad_numbers(tmp_path, capsys):
    (tmp_path / "fig").mkdir()
    (tmp_path / "fig" / "old.nc").touch()
    out = ["--out", str(tmp_path)]

    def run(*arguments):
        return run_script(lambda _: None, description="", script="fig.py", arguments=arguments)

    assert run(*out) == 2
    assert capsys.readouterr().err.startswith("fig: ")
    assert run(*out, "--force") == 0
    assert run(*out, "--force", "--workers", "0") == 2
    assert "workers must be at least 1, got 0" in capsys.readouterr().err


def test_script_that_fails_has_status_one(tmp_path, capsys):
    def full(settings):
        raise OSError("no space left")

    arguments = ["--out", str(tmp_path)]
    assert run_script(full, description="", script="fig.py", arguments=arguments) == 1
    assert capsys.readouterr().err == "fig: no space left\n"
