import os
import subprocess
import sys

import matplotlib as mpl
import pytest

from rotor_ida import InputError
from rotor_ida.plot import (
    panels,
    plot_amplitude,
    plot_run,
    plot_trace,
    save_figure,
    style,
)

IN_A_PROCESS = """
import sys
import rotor_ida.plot
barred = ("sksundae", "rotor_ida.simul", "rotor_ida.steady", "matplotlib.pyplot")
print([name for name in sys.modules if name.startswith(barred)])
from rotor_ida.closed_forms import folds, response_curve
from rotor_ida.plot import panels, plot_amplitude, save_figure
from rotor_ida.plot.appearance import without_pyplot
with without_pyplot(): panels(1, 1)
print("matplotlib.pyplot" in sys.modules)
exact = response_curve(zeta=0.07, delta0=0.5, limits=(0.05, 3.0))
ax = plot_amplitude(exact, fold_points=folds(zeta=0.07, delta0=0.5))
save_figure(ax.figure, sys.argv[1], formats=("png", "svg", "pdf"))
print("matplotlib.pyplot" in sys.modules)
"""


def test_files_are_the_same_to_the_byte_in_another_process(tmp_path, exact, fold_points):
    """There no solver is imported, and pyplot only for a figure that a user makes."""
    shown = subprocess.run(
        [sys.executable, "-c", IN_A_PROCESS, str(tmp_path / "first")], capture_output=True,
        text=True, check=True, env={**os.environ, "PYTHONHASHSEED": "1"},
    )  # fmt: skip
    assert shown.stdout.split() == ["[]", "False", "True"]
    figure = plot_amplitude(exact, fold_points=fold_points).figure
    for second in save_figure(figure, tmp_path / "second", formats=("png", "svg", "pdf")):
        assert (tmp_path / f"first{second.suffix}").read_bytes() == second.read_bytes()
    assert second.read_bytes().startswith(b"%PDF")
    assert b"CreationDate" not in second.read_bytes()


def test_layout_solved_anew_does_not_show_in_the_file(tmp_path, run):
    # solving it again moves the axes by some 1e-16 of the figure, on some processors and not on
    # others: here they are moved by hand
    figure = plot_run(run)
    first = save_figure(figure, tmp_path / "a")
    engine = figure.get_layout_engine()
    solve = engine.execute

    def solve_and_move(figure):
        solve(figure)
        for ax in figure.axes:
            left, bottom, width, height = ax.get_position(original=True).bounds
            ax.set_position([left + 2e-16, bottom, width - 1e-16, height], which="original")
            ax.set_in_layout(True)

    engine.execute = solve_and_move
    second = save_figure(figure, tmp_path / "b")
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_writes_png_at_200_dots_per_inch_and_svg_without_a_date(tmp_path):
    figure, _ = panels(1, 1, width=2.0, height=1.0)
    png, svg = save_figure(figure, tmp_path / "v1.5")
    assert [png.name, svg.name] == ["v1.5.png", "v1.5.svg"]
    # width and height stand in the header of a PNG
    assert int.from_bytes(png.read_bytes()[16:20], "big") == 400
    assert "dc:date" not in svg.read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["v1.5.png", "v1.5.svg"]


def test_existing_files_are_kept_unless_asked(tmp_path):
    figure, _ = panels(1, 1, width=1.0, height=1.0)
    (tmp_path / "kept.svg").write_text("mine")
    with pytest.raises(InputError, match=r"kept\.svg' already exists; pass overwrite=True"):
        save_figure(figure, tmp_path / "kept")
    assert (tmp_path / "kept.svg").read_text() == "mine"
    save_figure(figure, tmp_path / "kept", overwrite=True)
    assert (tmp_path / "kept.svg").read_text() != "mine"


def test_folder_must_exist(tmp_path):
    figure, _ = panels(1, 1, width=1.0, height=1.0)
    with pytest.raises(InputError, match="folder that exists"):
        save_figure(figure, tmp_path / "none" / "stem")
    with pytest.raises(InputError, match="must be a matplotlib Figure, got str"):
        save_figure("figure", tmp_path / "stem")


def test_style_of_the_user_is_left_alone(exact):
    before = dict(mpl.rcParams)
    with mpl.rc_context({"axes.labelsize": 40.0, "font.size": 30.0}):
        ax = plot_amplitude(exact)
        assert mpl.rcParams["font.size"] == 30.0
    assert ax.xaxis.label.get_fontsize() == 10.0
    assert dict(mpl.rcParams) == before
    with style():
        pass
    assert dict(mpl.rcParams) == before


def test_formats_are_those_asked_for(tmp_path):
    figure, _ = panels(1, 1, width=1.0, height=1.0)
    written = save_figure(figure, tmp_path / "one", formats=("pdf", "png"))
    assert [path.name for path in written] == ["one.pdf", "one.png"]
    with pytest.raises(InputError, match="formats must be one of 'png', 'svg', 'pdf', got 'gif'"):
        save_figure(figure, tmp_path / "two", formats="gif")


@pytest.mark.parametrize("draw", [plot_trace, lambda run: panels(1, 1)])
def test_pyplot_knows_a_figure_that_a_user_makes(run, draw):
    from matplotlib import pyplot

    draw(run)
    assert len(pyplot.get_fignums()) == 1
    assert pyplot.gcf().axes


def test_pyplot_saves_a_figure_in_its_own_style(tmp_path, run):
    from matplotlib import pyplot

    ax = plot_trace(run)
    with mpl.rc_context({"xtick.labelsize": 30.0, "font.family": "monospace"}):
        pyplot.savefig(tmp_path / "by_pyplot.pdf")
    assert (tmp_path / "by_pyplot.pdf").stat().st_size > 5000
    for text in (ax.xaxis.label, *ax.get_xticklabels()):
        assert text.get_fontfamily() == ["STIXGeneral", "DejaVu Sans"]
    assert ax.get_xticklabels()[0].get_fontsize() == 9.0
