"""What holds for every picture: its labels, its units, its place, and what it refuses."""

import inspect
import io
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

from rotor_ida import InputError, Rotor, basin, dimensional, limit_cycle, plot
from rotor_ida.plot import mixed_panels
from rotor_ida.plot.labels import IN_UNITS, LABELS
from tests.plot.pictures import BOUNCING, MACHINE, PICTURES, made

UNITS = {"length": "µm", "time": "ms", "velocity": "mm/s"}
# What each kind of quantity is written in then, and what a dimensionless 1 is.
WRITTEN = {
    "number": ("", 1.0),
    "length": ("µm", 1e6 * MACHINE.length_scale),
    "time": ("ms", 1e3 * MACHINE.time_scale),
    "velocity": ("mm/s", 1e3 * MACHINE.velocity_scale),
    "force": ("N", MACHINE.force_scale),
    "rate": ("1/s", 1.0 / MACHINE.time_scale),
    "natural": ("rad/ms", 1e-3 / MACHINE.time_scale),
}
# What arranges, labels and saves pictures, and draws none.
BESIDES = {
    "mixed_panels", "panels", "parameter_text", "save_figure", "save_orbit_film", "shared_legend",
    "style",
}  # fmt: skip
every_picture = pytest.mark.parametrize("picture", PICTURES, ids=str)


def in_units(dataset):
    return dimensional(dataset, MACHINE, units=UNITS)


@cache
def both(number):
    """Return a picture as drawn without dimensions and in SI units, for tests that only look."""
    return PICTURES[number].drawn(), PICTURES[number].drawn(in_units)


def lines_in_data(ax):
    """Return the points of each line that lies in the units of both axes."""
    return [
        np.ma.filled(np.ma.asarray(line.get_xydata(), float), np.nan)
        for line in ax.lines
        if line.get_transform() == ax.transData
    ]


@pytest.mark.parametrize("name", sorted({*plot.__all__} - BESIDES))
def test_a_plot_returns_the_axes_that_it_may_be_given_or_the_figure_of_several(name):
    plotted = inspect.signature(getattr(plot, name))
    ax = plotted.parameters.get("ax")
    if ax is None:
        assert plotted.return_annotation == "Figure"
    else:
        assert plotted.return_annotation == "Axes"
        assert ax.kind is ax.KEYWORD_ONLY


@every_picture
def test_axes_are_labelled_with_name_and_symbol_and_the_unit_of_the_dataset(picture):
    plain, si = both(PICTURES.index(picture))
    for shown, in_si, (name, kind) in (
        (plain.get_xlabel(), si.get_xlabel(), picture.across),
        (plain.get_ylabel(), si.get_ylabel(), picture.up),
    ):
        assert shown == LABELS[name]
        unit = WRITTEN[kind][0]
        plain_in_si = "spin speed [rpm]" if name == "omega" else LABELS[name]
        assert in_si == (f"{IN_UNITS[name]} [{unit}]" if unit else plain_in_si)


@every_picture
def test_a_dataset_in_si_units_is_drawn_to_scale(picture):
    plain, si = both(PICTURES.index(picture))
    scales = [WRITTEN[kind][1] for _, kind in (picture.across, picture.up)]
    lines, others = lines_in_data(si), lines_in_data(plain)
    assert len(lines) == len(others)
    for line, other in zip(lines, others, strict=True):
        np.testing.assert_allclose(line, other * scales, rtol=1e-9, atol=1e-9)
    assert len(si.collections) == len(plain.collections)
    assert lines or si.collections


@every_picture
def test_no_text_is_cut_off(picture):
    for drawn in both(PICTURES.index(picture)):
        figure = drawn.figure
        figure.draw_without_rendering()
        box = figure.get_tightbbox()
        assert box.x0 >= -0.02
        assert box.y0 >= -0.02
        assert box.x1 <= figure.get_figwidth() + 0.02
        assert box.y1 <= figure.get_figheight() + 0.02


def pixels(figure):
    """Return the colours of the dots of a figure, as `savefig` writes them."""
    with io.BytesIO() as file:
        figure.savefig(file, format="rgba")
        dots = np.frombuffer(file.getvalue(), np.uint8)
    return dots.reshape(round(figure.bbox.height), -1, 4)


WHIP = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
WIDE = np.linspace(-12.0, 12.0, 25)
FIGURES = {
    "run": lambda: plot.plot_run(made("run")),
    "run_up": lambda: plot.plot_run_up(made("run")),
    "machine": lambda: plot.plot_machine(in_units(made("run"))),
    "drawn_out": lambda: plot.plot_drawn_out(made("run")).figure,
    "drawn_out_in_si": lambda: plot.plot_drawn_out(in_units(made("run"))).figure,
    "surface": lambda: plot.plot_surface(made("field"), "potential").figure,
    "whip": lambda: plot.cycle_figure(limit_cycle(WHIP, start=(6.928, 0.0, 0.0, -10.0))),
    "wide_basin": lambda: plot.plot_basin(basin(BOUNCING, x=WIDE, y=WIDE)).figure,
} | {str(each): lambda each=each: each.drawn().figure for each in PICTURES}


@pytest.mark.parametrize("name", FIGURES)
def test_the_first_drawing_is_complete_and_the_same_as_the_second(name):
    figure = FIGURES[name]()
    first = pixels(figure)
    for edge in (first[0], first[-1], first[:, 0], first[:, -1]):
        assert (edge == 255).all()
    np.testing.assert_array_equal(pixels(figure), first)


@every_picture
def test_a_long_legend_hides_no_curve(picture):
    ax = both(PICTURES.index(picture))[0]
    ax.figure.draw_without_rendering()
    legend = ax.get_legend()
    if legend is not None and len(legend.get_texts()) > 4:
        assert legend.get_window_extent().y1 < ax.get_window_extent().y0


@every_picture
def test_is_drawn_on_the_axes_given(picture):
    ax = Figure().subplots()
    assert picture.drawn(ax=ax) is ax
    with pytest.raises(InputError, match="ax must be matplotlib Axes, got str"):
        picture.drawn(ax="here")


@every_picture
def test_other_things_are_refused(picture):
    with pytest.raises(InputError, match="it lacks"):
        picture.drawn(lambda each: each.drop_vars(list(each.data_vars)))
    with pytest.raises(InputError, match="must be a Dataset, got int"):
        picture.drawn(lambda _: 3)


def test_panels_are_lettered_and_solid_ones_are_where_they_are_wanted():
    figure, axes = mixed_panels(1, 2, solid=[0])
    assert [ax.name for ax in axes] == ["3d", "rectilinear"]
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["a", "b"]
    with pytest.raises(InputError, match="solid must contain numbers of panels below 2, got 2"):
        mixed_panels(1, 2, solid=[2])
