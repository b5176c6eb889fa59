import re

import pytest
from matplotlib import pyplot

from rotor_ida import InputError, load
from rotor_ida.paper import reproduction
from rotor_ida.paper.reproduction import reproduce
from rotor_ida.paper.scenario import Settings, run_script
from rotor_ida.plot import panels

# It starts processes as a sweep does, which fails where a script is not run as a script.
WORKING = '''
"""A small sweep."""
import sys
from rotor_ida import save, sweep
from rotor_ida.paper.scenario import progress_bar, run_script

def main(settings):
    with progress_bar("sweep") as progress:
        found = sweep(omega=[1.0, 1.2], zeta=1.0, delta0=0.0, workers=settings.workers,
                      progress=progress)
    save(found, settings.folder / "found.nc", overwrite=settings.force)

if __name__ == "__main__":
    sys.exit(run_script(main, description=__doc__, script=__file__))
'''
# It writes what it is, without importing anything heavy.
LIGHT = '''
"""A light one."""
import sys
from pathlib import Path

folder = Path(sys.argv[sys.argv.index("--out") + 1]) / Path(__file__).stem
folder.mkdir(parents=True, exist_ok=True)
(folder / "found.txt").write_text("1")
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


def test_the_papers_figures_are_run_and_studies_on_request(light, tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(reproduction, "OF_PAPER", ("c_", "a_"))
    light["b_fails"].write_text(LIGHT)
    assert reproduce(tmp_path / "results", workers=1) == 0
    shown = capfd.readouterr().out
    assert re.findall(r"\[(./2)\] ._works done in \d+ s", shown) == ["1/2", "2/2"]
    assert "b_fails" not in shown
    assert reproduce(tmp_path / "results", studies=True, workers=1) == 0
    shown = capfd.readouterr().out
    assert "up to date: a_works, c_works" in shown
    assert "[1/1] b_fails done" in shown


def test_goes_on_when_one_fails_and_says_which(scripts, tmp_path, capfd):
    out = tmp_path / "results"
    scripts["c_works"].write_text(LIGHT)
    assert reproduce(out, studies=True, quick=True, workers=2) == 1
    assert load(out / "a_works" / "found.nc").sizes["omega"] == 2
    assert (out / "c_works" / "found.txt").is_file()
    shown = capfd.readouterr()
    assert "b_fails failed after 0 s with exit status 3" in shown.err
    assert "1 of 3 failed: b_fails" in shown.err


@pytest.fixture
def light(scripts):
    """The same three, of which the first and the last are light."""
    for name in ("a_works", "c_works"):
        scripts[name].write_text(LIGHT)
    return scripts


def test_figures_of_all_are_on_one_page_and_failures_said(light, tmp_path):
    out = tmp_path / "results"
    assert reproduce(out, only=["c_"], workers=1) == 0
    assert reproduce(out, only=["a_works", "b"], workers=2) == 1
    text = (out / "index.html").read_text(encoding="utf-8")
    assert [f'id="{name}"' in text for name in light] == [True, True, True]
    assert text.count("The script failed") == 1
    assert (out / "a_works" / "a_works.py").read_text() == LIGHT


def test_scenario_that_failed_is_run_again(light, tmp_path):
    out = tmp_path / "results"
    light["b_fails"].write_text(LIGHT + "raise SystemExit(1)")
    assert reproduce(out, only=["b_fails"], workers=1) == 1
    assert reproduce(out, only=["b_fails"], workers=1) == 1
    light["b_fails"].write_text(LIGHT)
    assert reproduce(out, only=["b_fails"], workers=1) == 0


def test_a_file_is_no_folder_for_results(light, tmp_path):
    (tmp_path / "taken").write_text("mine")
    for place in ("taken", "taken/deeper"):
        with pytest.raises(InputError, match=f"out must be a folder, got '.*{place}'"):
            reproduce(tmp_path / place, studies=True, workers=1)


def test_results_that_are_there_are_not_touched(light, tmp_path):
    kept = tmp_path / "results" / "c_works" / "found.txt"
    kept.parent.mkdir(parents=True)
    kept.write_text("mine")
    with pytest.raises(InputError, match="c_works' contains results already"):
        reproduce(tmp_path / "results", studies=True, workers=1)
    assert kept.read_text() == "mine"
    assert not (tmp_path / "results" / "a_works").exists()
    assert reproduce(tmp_path / "results", only=["c_works"], workers=1, force=True) == 0
    assert kept.read_text() == "1"


def test_unknown_scenario_is_refused(scripts, tmp_path):
    for word in ("d", ""):
        with pytest.raises(InputError, match=rf"scenario must be one of a_works, .* got '{word}'"):
            reproduce(tmp_path, only=[word])


def test_a_scenario_leaves_no_figure_open(tmp_path):
    def draws(settings):
        figure, _ = panels(1, 1)
        figure.savefig(settings.folder / "drawn.png")

    arguments = ["--out", str(tmp_path)]
    assert run_script(draws, description="", script="fig.py", arguments=arguments) == 0
    assert (tmp_path / "fig" / "drawn.png").stat().st_size > 1000
    assert pyplot.get_fignums() == []


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
