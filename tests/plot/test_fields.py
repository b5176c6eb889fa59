import numpy as np
import pytest
from matplotlib.figure import Figure

from rotor_ida import InputError
from rotor_ida.closed_forms import restoring_field
from rotor_ida.plot import mixed_panels, plot_cuts, plot_surface


@pytest.fixture(scope="module")
def field():
    line = np.linspace(-2.0, 2.0, 9)
    return restoring_field(x=line, y=line, delta0=[0.0, 0.5])


def test_surface_spans_the_force_and_names_its_axes(field):
    ax = plot_surface(field.sel(delta0=0.5), "restoring_x")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x$", "$y$")
    assert ax.get_title() == r"force $f_x$,  $\delta_0 = 0.5$"
    low, high = ax.get_zlim()
    assert low < float(field.restoring_x.sel(delta0=0.5).min()) < 0.0
    assert high > float(field.restoring_x.sel(delta0=0.5).max()) > 0.0


def test_sections_are_those_of_the_field(field):
    ax = plot_cuts(field.sel(delta0=0.5), "restoring_x", at=[0.0, 2.0])
    for line, y in zip(ax.lines, (0.0, 2.0), strict=True):
        np.testing.assert_array_equal(line.get_ydata(), field.restoring_x.sel(delta0=0.5, y=y))
    assert [line.get_label() for line in ax.lines] == ["$y = 0$", "$y = 2$"]
    assert ax.lines[0].get_linestyle() != ax.lines[1].get_linestyle()


def test_draws_on_the_axes_given(field):
    figure, (solid, flat) = mixed_panels(1, 2, solid=[0])
    assert plot_surface(field.sel(delta0=0.0), "potential", ax=solid) is solid
    assert plot_cuts(field.sel(delta0=0.0), "potential", at=[0.0], ax=flat) is flat
    assert [ax.get_title(loc="left") for ax in figure.axes] == ["a", "b"]


def test_what_cannot_be_drawn_is_refused(field):
    with pytest.raises(InputError, match="ax must be three-dimensional"):
        plot_surface(field.sel(delta0=0.0), "restoring_x", ax=Figure().subplots())
    with pytest.raises(InputError, match="field must hold one delta0, got 2"):
        plot_surface(field, "restoring_x")
    with pytest.raises(InputError, match="it lacks force"):
        plot_cuts(field, "force", at=[0.0])
    with pytest.raises(InputError, match="solid must hold numbers of panels below 2, got 2"):
        mixed_panels(1, 2, solid=[2])
