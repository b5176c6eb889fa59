"""How the site is built: `python docs/build.py`, or `sphinx-build -W -n docs site`.

Nothing is fetched: the inventories of other projects lie in `inventories/`, formulas are MathML,
and the theme brings its own fonts.
"""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))

project = "rotor_ida"
author = "The rotor_ida authors"
copyright = "2026, the rotor_ida authors"  # noqa: A001 - Sphinx wants it so
release = version = version_of("rotor-ida")

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.intersphinx",
    "numpydoc",
    "myst_parser",
    "sphinx_design",
    "sphinx_gallery.gen_gallery",
    "sphinx_copybutton",
    "reference",
    "scenarios",
    "notation",
]
exclude_patterns = [
    *("_extensions", "_templates", "inventories"),
    *("results", "scenario_scripts", "tutorial_scripts"),
    "api/used_by",
    "categories.md",  # a part of datasets.md
    "site",
    "**/sg_execution_times.rst",
]
templates_path = ["_templates"]
source_suffix = {".rst": "restructuredtext", ".md": "markdown"}
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 3
html_math_renderer = "mathml"
default_role = "name"

# References: numpydoc's words say what a parameter is; annotations would say it twice.
autodoc_typehints = "none"
autosummary_generate = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = True
numpydoc_xref_ignore = "all"
numpydoc_xref_aliases = {
    "Dataset": "xarray.Dataset",
    "DataArray": "xarray.DataArray",
    "ndarray": "numpy.ndarray",
    "Axes": "matplotlib.axes.Axes",
    "Figure": "matplotlib.figure.Figure",
    "Path": "pathlib.Path",
    "InputError": "rotor_ida.InputError",
    "SimulationError": "rotor_ida.SimulationError",
    "ArchiveError": "rotor_ida.ArchiveError",
    "InvariantError": "rotor_ida.InvariantError",
    "InstallationError": "rotor_ida.InstallationError",
    "Rotor": "rotor_ida.Rotor",
    "DimensionalRotor": "rotor_ida.DimensionalRotor",
}
# Cut down to what the pages may link to.
intersphinx_mapping = {
    name: (address, str(HERE / "inventories" / f"{name}.inv"))
    for name, address in {
        "python": "https://docs.python.org/3/",
        "numpy": "https://numpy.org/doc/stable/",
        "xarray": "https://docs.xarray.dev/en/stable/",
        "matplotlib": "https://matplotlib.org/stable/",
    }.items()
}

sphinx_gallery_conf = {
    "examples_dirs": ["tutorial_scripts", "scenario_scripts"],
    "gallery_dirs": ["tutorials", "gallery"],
    # the scenarios have run already, each in a process of its own
    "filename_pattern": "/tutorial_scripts/",
    "doc_module": ("rotor_ida",),
    "reference_url": {"rotor_ida": None},
    "backreferences_dir": "api/used_by",
    "image_scrapers": ("scenarios.figures_of_block",),
    "capture_repr": ("_repr_html_", "__repr__"),
    "ignore_repr_types": r"matplotlib\.",
    "abort_on_example_error": True,
    "run_stale_examples": True,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 10_000,
    "download_all_examples": False,
    "write_computation_times": False,
    "within_subsection_order": "scenarios.InOrder",
    "first_notebook_cell": "%matplotlib inline",
}

# The copy button leaves out prompts and output.
copybutton_prompt_text = r">>> |\.\.\. "
copybutton_prompt_is_regexp = True

html_theme = "pydata_sphinx_theme"
html_title = f"rotor_ida {release}"
html_favicon = "../rotor_ida/explorer/page/icon.svg"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "show_prev_next": False,
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": []}
