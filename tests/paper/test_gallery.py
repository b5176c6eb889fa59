"""The gallery shows every figure with its words and links, and nothing from elsewhere."""

from html.parser import HTMLParser

import pytest
from matplotlib.figure import Figure

from rotor_ida import InputError
from rotor_ida.paper.gallery import Entry, add_entry, read_entries, write_gallery
from rotor_ida.paper.scenario import Settings

WORDS = {"shows": "What <b> it shows & more", "paper": "printed", "found": "0.5"}


class Links(HTMLParser):
    """Everything that a page points at."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.targets += [value for name, value in attrs if name in {"href", "src"}]
        if tag not in {"meta", "img", "link"}:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture
def results(tmp_path):
    """Two scenarios: one with words, one that only left a picture."""
    scripts = {}
    for name, text in (("fig01_told", '"""A told figure.\n\nMore."""'), ("fig02_untold", "x = 1")):
        scripts[name] = tmp_path / f"{name}.py"
        scripts[name].write_text(text)
        (tmp_path / "out" / name).mkdir(parents=True)
        (tmp_path / "out" / name / f"{name}.py").write_text(text)
    told = Settings(tmp_path / "out" / "fig01_told", True, 1, False)
    told.show(Figure(figsize=(1, 1)), "one", archives=["data"], **WORDS)
    (told.folder / "data.nc").touch()
    for name in ("two.png", "two.svg"):
        (tmp_path / "out" / "fig02_untold" / name).touch()
    return tmp_path / "out", scripts


def test_every_link_of_the_page_leads_to_a_file(results):
    root, scripts = results
    page = write_gallery(root, scripts)
    links = Links(page.read_text(encoding="utf-8"))
    assert links.open == []
    files = [target for target in links.targets if not target.startswith("#")]
    assert {"fig01_told/one.png", "fig01_told/one.svg", "fig01_told/data.nc",
            "fig01_told/fig01_told.py", "fig02_untold/two.png"} <= set(files)  # fmt: skip
    assert all((root / target).is_file() for target in files)
    assert not any("//" in target for target in files)


def test_words_are_shown_and_escaped(results):
    root, scripts = results
    text = write_gallery(root, scripts).read_text(encoding="utf-8")
    assert "What &lt;b&gt; it shows &amp; more" in text
    assert "<h2>A told figure</h2>" in text
    assert 'name="viewport"' in text
    assert "The script failed" not in text
    # else a link to a figure would lead astray while the pictures above it load
    assert 'width="200" height="200" loading="lazy"' in text
    text = write_gallery(root, {**scripts, "gone": root / "gone.py"}, failed=["gone"])
    assert "The script failed" in text.read_text(encoding="utf-8")


def test_entry_of_a_figure_drawn_again_replaces_the_old_one(tmp_path):
    first = Entry(figure="a", archives=("a.nc",), shows="first", paper="", found="")
    second = Entry(figure="a", archives=("a.nc",), shows="second", paper="", found="")
    for entry in (first, second):
        add_entry(tmp_path, entry)
    assert read_entries(tmp_path) == [second]


def test_damaged_record_is_refused(tmp_path):
    (tmp_path / "figures.json").write_text("[{}]")
    with pytest.raises(InputError, match="the record of figures must be one"):
        read_entries(tmp_path)


def test_table_says_what_becomes_of_what_the_paper_says(results):
    root, scripts = results
    assert '<section id="summary">' not in write_gallery(root, scripts).read_text(encoding="utf-8")
    told = Settings(root / "fig01_told", True, 1, True)
    told.show(Figure(figsize=(1, 1)), "fig04_periods", archives=[], verdict="Wrong: δ₀².",
              **WORDS)  # fmt: skip
    text = write_gallery(root, scripts).read_text(encoding="utf-8")
    assert "<td>Wrong: δ₀².</td>" in text
    assert '<a href="#fig01_told-fig04_periods">Fig. 4, periods</a>' in text
    places = [target[1:] for target in Links(text).targets if target.startswith("#")]
    assert all(f'id="{place}"' in text for place in places)
