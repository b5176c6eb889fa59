"""What holds for every picture: its labels, its units, its place, and what it refuses."""

import inspect
import io

import numpy as np
import pytest
from matplotlib.figure import Figure

from rotor_ida import InputError, Rotor, basin, dimensional, limit_cycle, plot
from rotor_ida.plot import mixed_panels
from rotor_ida.plot.labels import IN_UNITS, LABELS
from tests.plot.pictures import BOUNCING, MACHINE, PICTURES, check_nothing_cut_off, made

UNITS = {"length": "µm", "time": "ms", "velocity": "mm/s"}
# What each kind of quantity is written in then, and what a dimensionless 1 is.
WRITTEN = {
    "number": ("", 1.0),
    "length": ("µm", 1e6 * MACHINE.length_scale),
    "time": ("ms", 1e3 * MACHINE.time_scale),
    "velocity": ("mm/s", 1e3 * MACHINE.velocity_scale),
    "force": ("N", MACHINE.force_scale),
    "rate": ("1/s", 1.0 / MACHINE.time_scale),
}


# Axes of parameters, whose ticks alone are in units.
IN_FIELD = {"omega": "spin speed [rpm]", "delta0": "clearance [µm]"}


def in_units(dataset):
    return dimensional(dataset, MACHINE, units=UNITS)


def lines_in_data(ax):
    """Return the points of each line that lies in the units of both axes."""
    return [
        np.ma.filled(np.ma.asarray(line.get_xydata(), float), np.nan)
        for line in ax.lines
        if line.get_transform() == ax.transData
    ]


@pytest.mark.parametrize("name", [name for name in dir(plot) if name.startswith("plot_")])
def test_a_plot_returns_the_axes_that_it_may_be_given_or_the_figure_of_several(name):
    plotted = inspect.signature(getattr(plot, name))
    ax = plotted.parameters.get("ax")
    if ax is None:
        assert plotted.return_annotation == "Figure"
    else:
        assert plotted.return_annotation == "Axes"
        assert ax.kind is ax.KEYWORD_ONLY


# Dots per inch: enough, as any shift of what is drawn changes the shades of edges.
DOTS = 80


def pixels(figure):
    """Return the colours of the dots of a figure, as `savefig` writes them."""
    with io.BytesIO() as file:
        figure.savefig(file, format="rgba", dpi=DOTS)
        dots = np.frombuffer(file.getvalue(), np.uint8)
    return dots.reshape(round(DOTS * figure.get_figheight()), -1, 4)


def check_first_drawing(figure):
    """It is complete, with nothing at the edges, and the same as the second."""
    first = pixels(figure)
    for edge in (first[0], first[-1], first[:, 0], first[:, -1]):
        assert (edge == 255).all()
    np.testing.assert_array_equal(pixels(figure), first)


def check_labels(plain, si, picture):
    """Axes have name and symbol, and the unit of the dataset."""
    for shown, in_si, (name, kind) in (
        (plain.get_xlabel(), si.get_xlabel(), picture.across),
        (plain.get_ylabel(), si.get_ylabel(), picture.up),
    ):
        assert shown == LABELS[name]
        unit = WRITTEN[kind][0]
        plain_in_si = IN_FIELD.get(name, LABELS[name])
        assert in_si == (f"{IN_UNITS[name]} [{unit}]" if unit else plain_in_si)


def check_scales(plain, si, picture):
    """A dataset in SI units is drawn to scale."""
    scales = [WRITTEN[kind][1] for _, kind in (picture.across, picture.up)]
    lines, others = lines_in_data(si), lines_in_data(plain)
    assert len(lines) == len(others)
    for line, other in zip(lines, others, strict=True):
        np.testing.assert_allclose(line, other * scales, rtol=1e-9, atol=1e-9)
    assert len(si.collections) == len(plain.collections)
    assert lines or si.collections


def check_legend(ax):
    """A long one hides no curve."""
    legend = ax.get_legend()
    if legend is not None and len(legend.get_texts()) > 4:
        assert legend.get_window_extent().y1 < ax.get_window_extent().y0


@pytest.mark.parametrize("picture", PICTURES, ids=str)
def test_a_picture_is_labelled_to_scale_and_complete(picture):
    plain, si = picture.drawn(), picture.drawn(in_units)
    check_first_drawing(plain.figure)
    check_labels(plain, si, picture)
    check_scales(plain, si, picture)
    check_nothing_cut_off(si.figure)
    check_legend(plain)


@pytest.mark.parametrize("picture", PICTURES, ids=str)
def test_a_picture_is_drawn_on_the_axes_given_and_of_its_dataset_alone(picture):
    ax = Figure().subplots()
    assert picture.drawn(ax=ax) is ax
    with pytest.raises(InputError, match="ax must be matplotlib Axes, got str"):
        picture.drawn(ax="here")
    with pytest.raises(InputError, match="it lacks"):
        picture.drawn(lambda each: each.drop_vars(list(each.data_vars)))
    with pytest.raises(InputError, match="must be a Dataset, got int"):
        picture.drawn(lambda _: 3)


WHIP = Rotor(omega=1.0, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
WIDE = np.linspace(-12.0, 12.0, 25)
FIGURES = {
    "run": lambda: plot.plot_run(made("run")),
    "run_up": lambda: plot.plot_run_up(made("run")),
    "machine": lambda: plot.plot_run(in_units(made("run"))),
    "whip": lambda: plot.cycle_figure(limit_cycle(WHIP, start=(6.928, 0.0, 0.0, -10.0))),
    "wide_basin": lambda: plot.plot_basin(basin(BOUNCING, x=WIDE, y=WIDE)).figure,
}


@pytest.mark.parametrize("name", FIGURES)
def test_the_first_drawing_of_a_figure_is_complete_and_the_same_as_the_second(name):
    check_first_drawing(FIGURES[name]())


def test_panels_are_lettered_and_solid_ones_are_where_they_are_wanted():
    figure, axes = mixed_panels(1, 2, solid=[0])
    assert [ax.name for ax in axes] == ["3d", "rectilinear"]
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["a", "b"]
    with pytest.raises(InputError, match="solid must contain numbers of panels below 2, got 2"):
        mixed_panels(1, 2, solid=[2])
