import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgba

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    basin,
    basin_fractions,
    continue_attractors,
)
from rotor_ida.plot import plot_attractor_fractions, plot_attractor_map, plot_attractors, plot_basin
from rotor_ida.plot.figures import figure_of
from rotor_ida.plot.labels import LABELS
from rotor_ida.plot.palette import KIND_SHADES
from rotor_ida.schema import RESPONSE
from tests.plot.pictures import words_of


@pytest.fixture(scope="module")
def figure_7():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    return basin(rotor, x=np.linspace(-15, 15, 20), y=np.linspace(-14, 14, 15))


def colours_at(ax, dataset, x, y):
    (mesh,) = ax.collections
    places = [np.argmin(np.abs(dataset[name].values - at)) for name, at in (("x", x), ("y", y))]
    value = mesh.get_array()[places[1], places[0]]
    return mesh.cmap(mesh.norm(value))


def test_each_start_has_the_colour_of_its_attractor(figure_7):
    ax = plot_basin(figure_7)
    assert ax.get_aspect() == 1.0
    faces = [patch.get_facecolor() for patch in ax.get_legend().get_patches()]
    assert colours_at(ax, figure_7, 0.0, 0.0) == faces[0]
    assert colours_at(ax, figure_7, 10.0, 0.0) == faces[1]


def changed(name, place, value):
    """Return what changes one value of a basin."""

    def change(basin):
        other = basin.copy(deep=True)
        other[name][place] = value
        return other

    return change


@pytest.mark.parametrize(
    ("change", "first"),
    [
        (changed("label", 3, 0), ["synchronous response, $A = 1.88$"]),
        (changed("radius_min", 0, 1.0), [r"synchronous response, $1 \leq |z| \leq 1.88$"]),
        (changed("count", 0, 0), ["synchronous response, $A = 9.49$"]),
        # the radius of dry whip is not its part at the spin speed
        (changed("amplitude", 0, 0.3), ["synchronous response, $|z| = 1.88$"]),
    ],
    ids=["constant radius", "changing radius", "attractor without start", "not at the speed"],
)
def test_the_legend_names_kinds_and_amplitudes_or_radii_of_attractors(figure_7, change, first):
    shown = words_of(plot_basin(change(figure_7)))
    assert shown == list(dict.fromkeys([*first, "synchronous response, $A = 9.49$"]))


def test_what_is_not_known_is_told(figure_7):
    partly = figure_7.copy(deep=True)
    partly["label"][0, :] = -1
    partly["label"][1, :] = -2
    assert words_of(plot_basin(partly))[2:] == ["undecided", "not computed"]


def test_colours_differ():
    shades = [shade for family in KIND_SHADES.values() for shade in family]
    assert len(set(shades)) == len(shades)


def test_plane_of_unlike_coordinates_is_square_and_says_what_is_held():
    rotor = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
    plane = basin(rotor, x=np.linspace(-6, 6, 4), y=0.0, vx=-15.0, vy=np.linspace(-10, 10, 4))
    ax = plot_basin(plane)
    assert (ax.get_aspect(), ax.get_box_aspect()) == ("auto", 1.0)
    assert ax.get_title().endswith(LABELS["vx"].partition(" ")[2] + " $= -15$")


def test_other_data_are_refused(figure_7):
    with pytest.raises(InputError, match="at least 2 x 2 starts"):
        plot_basin(figure_7.isel(x=slice(1)))


@pytest.fixture(scope="module")
def grid():
    return continue_attractors(
        omega=[1.6, 2.0, 2.4], zeta=0.07, delta0=[0.5, 2.0], x=(-15, 15), y=(-15, 15), starts=40
    )


def test_shares_of_attractors_fill_the_panel(grid):
    ax = plot_attractors(grid.isel(delta0=[1]))
    tops = np.max(
        [path.vertices[:, 1].max() for each in ax.collections for path in each.get_paths()]
    )
    assert tops == pytest.approx(1.0)
    words = ax.get_legend_handles_labels()[1]
    assert "bouncing" in words
    assert len(words) == len(set(words))


def test_each_shade_is_named(grid):
    """One of a kind by its kind, several by numbers, and those that share a shade once."""
    line = grid.isel(delta0=[1])
    kinds = ["contact_free", *["bouncing"] * 6]
    parts = np.full((3, 1, 1, 7), 1.0 / 7.0)
    made = line[["fraction", "kind"]].isel(attractor=[0] * 7).assign_coords(attractor=range(7))
    made = made.assign(
        fraction=(line.fraction.dims, parts),
        kind=(line.kind.dims, np.broadcast_to([RESPONSE[kind] for kind in kinds], parts.shape)),
    )
    made["kind"].attrs, made.attrs = line.kind.attrs, line.attrs
    ax = plot_attractors(made)
    words = ax.get_legend_handles_labels()[1]
    assert words == ["contact-free response", "bouncing 1", "bouncing 2", "bouncing 3",
                     "bouncing 4 and others"]  # fmt: skip
    shades = {tuple(each.get_facecolor()[0]) for each in ax.collections}
    assert len(shades) == len(words)


def test_a_map_shows_the_likeliest_response(grid):
    ax = plot_attractor_map(grid)
    (mesh,) = [each for each in ax.collections if each.get_array() is not None]
    shown = mesh.get_array().reshape(2, 3)
    kinds = list(KIND_SHADES)
    for row, delta0 in enumerate(grid.delta0.values):
        for column, omega in enumerate(grid.omega.values):
            here = grid.sel(omega=omega, delta0=delta0).squeeze()
            number = int(here.kind[int(np.nanargmax(here.fraction.values))])
            assert kinds[int(shown[row, column])] in RESPONSE
            assert RESPONSE[kinds[int(shown[row, column])]] == number


def test_a_map_of_forces_follows_the_exponent_of_the_contact(grid):
    (mesh,) = (
        each
        for each in plot_attractor_map(
            grid.assign_coords(contact_exponent=1.0), by="force"
        ).collections
        if isinstance(each, QuadMesh)
    )
    likeliest = grid.isel(attractor=grid.fraction.fillna(-1.0).argmax("attractor"))
    depth = (likeliest.radius_max - likeliest.delta0).fillna(0.0).clip(min=0.0).squeeze().T
    np.testing.assert_allclose(mesh.get_array().reshape(depth.shape), depth, rtol=1e-12)


def test_a_line_is_no_map_and_a_map_no_line(grid):
    with pytest.raises(InputError, match="over one parameter to be drawn, got 2"):
        plot_attractors(grid)
    with pytest.raises(InputError, match="over two parameters to be mapped, got 1"):
        plot_attractor_map(grid.isel(delta0=[1]))
    with pytest.raises(InputError, match="by must be one of 'kind', 'force', 'shock', got 'col"):
        plot_attractor_map(grid, by="colour")
    with pytest.raises(InputError, match="must have been computed with shocks to be mapped by"):
        plot_attractor_map(grid, by="shock")


def test_a_map_of_the_smallest_shocks_shows_where_there_is_none():
    shocked = continue_attractors(
        omega=[2.0, 2.4], zeta=0.07, delta0=[0.5, 2.0], x=(-15, 15), y=(-15, 15), starts=20,
        shocks=32,
    )  # fmt: skip
    ax = plot_attractor_map(shocked, by="shock")
    (mesh,) = (each for each in ax.collections if isinstance(each, QuadMesh))
    nowhere = shocked.assign(velocity_shock=np.nan * shocked.velocity_shock)
    alone = plot_attractor_map(nowhere, by="shock")
    assert alone.get_legend_handles_labels()[1] == ["no shock was found"]
    alone.figure.draw_without_rendering()
    likeliest = shocked.fraction.fillna(-1.0).argmax("attractor")
    expected = shocked.velocity_shock.min("target").isel(attractor=likeliest).squeeze().T
    drawn = np.ma.filled(mesh.get_array(), np.nan).reshape(expected.shape)
    np.testing.assert_array_equal(drawn, expected)
    assert np.isfinite(drawn).any()
    assert ("no shock was found" in ax.get_legend_handles_labels()[1]) == np.isnan(drawn).any()


@pytest.fixture(scope="module")
def fractions():
    rotor = Rotor(omega=0.62962981, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    return basin_fractions(rotor, x=(-5, 5), y=(-5, 5), vx=(-6, 6), vy=(-6, 6), starts=12)


def test_fractions_of_one_rotor_are_bars_with_their_errors(fractions):
    ax = plot_attractor_fractions(fractions)
    names = [text.get_text() for text in ax.get_yticklabels()]
    widths = [patch.get_width() for patch in ax.patches]
    assert widths == sorted(widths)
    assert sum(widths) == pytest.approx(1.0)
    assert np.sort(fractions["fraction"].values).tolist() == widths[-fractions.sizes["attractor"] :]
    rolling = next(
        place for place, name in enumerate(names) if name.startswith("rolling (dry whip)")
    )
    assert ax.patches[rolling].get_facecolor() == to_rgba(KIND_SHADES["rolling"][0])
    assert ax.get_xlabel() == "fraction of starts"
    assert r"$\mu = 0.2$" in ax.get_title()


def test_starts_that_are_not_decided_have_a_bar_of_their_own(fractions):
    some = fractions.assign(fraction=0.5 * fractions["fraction"])
    ax = plot_attractor_fractions(some)
    names = [text.get_text() for text in ax.get_yticklabels()]
    assert ax.patches[names.index("undecided")].get_width() == pytest.approx(0.5)


@pytest.fixture(scope="module")
def of_system():
    """Starts of one of two nodes, beside its clearance circle."""
    system = RotorSystem(
        mass=10.0 * np.eye(4), stiffness=1e7 * np.kron([[2.0, -1.0], [-1.0, 1.4]], np.eye(2)),
        damping=1e3 * np.eye(4), nodes={"disc": (0, 1), "seal": (2, 3)},
        contacts=[Contact(node="disc", clearance=9e-4, stiffness=5e9),
                  Contact(node="seal", clearance=3e-5, stiffness=5e9)],
        unbalance=[Unbalance(node="disc", moment=2e-4)],
    )  # fmt: skip
    given = {"speed": 1150.0, "node": "seal", "start": "settled"}
    plane = {"x": np.linspace(-4e-5, 1e-5, 4), "y": np.linspace(-3e-5, 3e-5, 3)}
    fractions = basin_fractions(system, **given, x=(-4e-5, 1e-5), y=(-3e-5, 3e-5), starts=8)
    return basin(system, **given, **plane), fractions


def test_a_basin_of_a_rotor_system_has_its_units_its_node_and_the_circle_of_that(of_system):
    found, _ = of_system
    ax = plot_basin(found)
    assert ax.get_xlabel() == "displacement $X$ [µm]"
    assert ax.get_title() == "node seal,  10,982 rpm"
    named = [f"$A = {1e6 * size:#.3g}$ µm" for size in found.amplitude.values[:, 1]]
    assert [each.split(", ")[1] for each in words_of(ax)[:-1]] == named
    assert words_of(ax)[-1] == "clearance"
    (ring,) = ax.lines
    np.testing.assert_allclose(np.hypot(ring.get_xdata(), ring.get_ydata()), 30.0)
    assert ax.get_xlim()[1] < 25.0  # not as far as the circle reaches
    offset = ("contact", [0.0, 2e-6], found.centre_x.attrs)
    (ring,) = plot_basin(found.assign_coords(centre_x=offset)).lines
    np.testing.assert_allclose(np.hypot(ring.get_xdata() - 2.0, ring.get_ydata()), 30.0)


def test_a_circle_beyond_the_starts_is_not_drawn(of_system):
    found, _ = of_system
    far = found.assign_coords(clearance=("contact", [9e-4, 9e-4], found.clearance.attrs))
    assert not plot_basin(far).lines


def test_fractions_of_a_rotor_system_are_bars_with_the_amplitudes_of_its_node(of_system):
    _, fractions = of_system
    ax = plot_attractor_fractions(fractions)
    assert ax.get_title() == "node seal,  10,982 rpm"
    assert all(text.get_text().endswith("µm") for text in ax.get_yticklabels())
    figure = figure_of(fractions)
    assert figure.axes[0].get_title() == ax.get_title()
