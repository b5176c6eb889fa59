"""The gallery: the scenarios, run as `rotor-ida reproduce` runs them, as sources of sphinx-gallery.

Each becomes a script whose docstring shows the figures with what they show, and whose last lines
run it from a notebook. The words and archives are those that `reproduce` puts on its own page.
"""

import ast
import re
import shutil
from pathlib import Path

from matplotlib.figure import Figure
from sphinx.errors import ExtensionError
from sphinx_gallery.scrapers import figure_rst
from sphinx_gallery.sorting import FileNameSortKey

from rotor_ida.paper.gallery import caption_of, read_entries
from rotor_ida.paper.reproduction import is_of_paper, reproduce, scenario_scripts

HERE = Path(__file__).parents[1]
RESULTS, SCRIPTS = HERE / "results", HERE / "scenario_scripts"
TITLES = {
    "": (
        "Gallery",
        "Every figure of the paper, and studies beyond it, each with the script that computes it.",
    ),
    "paper": ("The paper's figures", "What the paper shows, and the corrected result."),
    "studies": ("Beyond the paper", "Further studies."),
}
# Tutorials in the order in which they are shown; the scenarios follow by name.
TUTORIALS = (
    *("pump", "compressor", "run_down", "basins_and_branches"),
    *("own_study", "choose_clearance", "through_resonance"),
)
GUARD = 'if __name__ == "__main__":'
RUN = """
# %%
# To run it here, coarse but quick, into a folder of its own; without ``--quick`` in full.

run_script(
    main, description="", script="{name}.py", arguments=["--quick", "--force", "--out", "tried"]
)
"""


def write_scripts(app, _config):
    """Run what is not up to date, and write the sources of the gallery."""
    if reproduce(RESULTS, studies=True, quick=app.tags.has("quick")):
        raise ExtensionError("a scenario failed: see above")
    shutil.rmtree(SCRIPTS, ignore_errors=True)
    for folder, (title, words) in TITLES.items():
        place = SCRIPTS / folder
        place.mkdir(parents=True)
        line = ("=" if not folder else "-") * len(title)
        (place / "GALLERY_HEADER.rst").write_text(f"{title}\n{line}\n\n{words}\n", encoding="utf-8")
    for name, script in scenario_scripts().items():
        folder = SCRIPTS / ("paper" if is_of_paper(name) else "studies")
        text = gallery_source(name, script.read_text(encoding="utf-8"))
        (folder / f"{name}.py").write_text(text, encoding="utf-8")


def gallery_source(name, source):
    """Return the source of one page of the gallery."""
    docstring = ast.get_docstring(ast.parse(source))
    title, _, words = escaped(docstring).partition("\n")
    title = title.rstrip(".")
    body = source.split('"""', 2)[2].partition(GUARD)[0].strip()
    shown = "".join(figure(name, entry) for entry in read_entries(RESULTS / name))
    first = read_entries(RESULTS / name)[0].figure
    return (
        f'r"""\n{title}\n{"=" * len(title)}\n{words}\n\n{shown}"""\n\n'
        f"# sphinx_gallery_thumbnail_path = 'results/{name}/{first}.png'\n\n"
        f"{body}\n{RUN.format(name=name)}"
    )


def figure(name, entry):
    """Return a figure with its words and its files."""
    at = f"/results/{name}"
    files = [f"{entry.figure}.png", f"{entry.figure}.svg", *entry.archives]
    links = ", ".join(f":download:`{file} <{at}/{file}>`" for file in files)
    rows = {"Paper": escaped(entry.paper), "Here": escaped(entry.found), "Files": links}
    title = caption_of(name, entry.figure)
    lines = [
        title, "-" * len(title), "",
        f".. figure:: {at}/{entry.figure}.png", f"   :alt: {entry.shows}", "",
        f"   {escaped(entry.shows)}", "",
        *(f":{row}: {words}" for row, words in rows.items() if words),
    ]  # fmt: skip
    return "\n".join(lines) + "\n\n"


def escaped(words):
    """Return plain words so that reStructuredText shows them as they are."""
    for mark in "\\|*`":
        words = words.replace(mark, f"\\{mark}")
    return words.replace("_ ", "\\_ ")


def figures_of_block(_block, block_vars, gallery_conf):
    """Return the figure that a block of a tutorial ends with, or that of its axes."""
    last = block_vars["example_globals"].get("___")
    shown = getattr(last, "figure", last)  # of axes their figure
    if not isinstance(shown, Figure) or getattr(shown, "is_on_the_site", False):
        return ""
    shown.is_on_the_site = True
    path = next(block_vars["image_path_iterator"])
    shown.savefig(path, dpi=150)
    words = "; ".join(f"{ax.get_ylabel()} over {ax.get_xlabel()}" for ax in shown.axes)
    words = unmarked(words)
    return figure_rst([path], gallery_conf["src_dir"], words)


def unmarked(words):
    """Return words without the marks of TeX, for screen readers: ``omega`` for its letter."""
    plain = re.sub(r"\\(?:mathrm|mathdefault|[,;])", "", words.replace("\\times", "times"))
    return re.sub(r"[$\\_^{}]", "", plain)


class InOrder(FileNameSortKey):
    """Sort tutorials as listed, and all else by name."""

    def __call__(self, filename):
        """Return the key of a script."""
        name = Path(filename).stem
        return (TUTORIALS.index(name) if name in TUTORIALS else len(TUTORIALS), name)


def setup(app):
    """Run before sphinx-gallery looks for its sources."""
    app.connect("config-inited", write_scripts, priority=1)
    return {"parallel_read_safe": True}
