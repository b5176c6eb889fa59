"""Results are fresh while script, options and files are what they were."""

import pytest

from rotor_ida.paper import freshness


@pytest.fixture
def made(tmp_path):
    script, folder = tmp_path / "fig.py", tmp_path / "fig"
    script.write_text("one")
    folder.mkdir()
    (folder / "data.nc").write_text("data")
    freshness.record(folder, freshness.origin_of(script, ["--quick"]))
    return script, folder


def test_nothing_changed(made):
    script, folder = made
    assert freshness.is_fresh(folder, freshness.origin_of(script, ["--quick"]))
    assert freshness.is_ours(folder)


def test_other_options_or_script_are_another_origin(made):
    script, folder = made
    assert not freshness.is_fresh(folder, freshness.origin_of(script, []))
    script.write_text("two")
    assert not freshness.is_fresh(folder, freshness.origin_of(script, ["--quick"]))
    assert freshness.is_ours(folder)


def test_sources_and_versions_are_part_of_the_origin(made, monkeypatch):
    script, _ = made
    before = freshness.origin_of(script, [])
    monkeypatch.setattr(freshness, "version", lambda name: "99")
    assert freshness.origin_of(script, []) != before


@pytest.mark.parametrize("name", ["model.py", "core/model.c"])
def test_sources_in_python_and_in_c_are_part_of_the_origin(tmp_path, monkeypatch, name):
    package, script = tmp_path / "package", tmp_path / "fig.py"
    (package / "core").mkdir(parents=True)
    script.touch()
    monkeypatch.setattr(freshness, "__file__", str(package / "paper" / "freshness.py"))
    before = freshness.origin_of(script, [])
    (package / name).touch()
    assert freshness.origin_of(script, []) != before


@pytest.mark.parametrize("change", ["edit", "remove", "add"])
def test_files_that_were_touched_are_not_fresh_and_not_ours(made, change):
    script, folder = made
    if change == "edit":
        (folder / "data.nc").write_text("mine")
    elif change == "remove":
        (folder / "data.nc").unlink()
    else:
        (folder / "notes.txt").write_text("mine")
    assert not freshness.is_fresh(folder, freshness.origin_of(script, ["--quick"]))
    assert not freshness.is_ours(folder)


@pytest.mark.parametrize("text", ["", "[]", '{"origin": 1}', "{"])
def test_damaged_digest_is_none(made, text):
    _, folder = made
    (folder / "digest.json").write_text(text)
    assert not freshness.is_ours(folder)


def test_run_that_broke_off_can_be_redone(made):
    script, folder = made
    freshness.begin(folder)
    (folder / "half.nc").write_text("half")
    assert freshness.is_ours(folder)
    assert not freshness.is_fresh(folder, "")
    assert not freshness.is_fresh(folder, freshness.origin_of(script, ["--quick"]))
