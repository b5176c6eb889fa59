import math

import numpy as np
import pytest
from matplotlib.colors import to_rgba

from rotor_ida import (
    Contact,
    InputError,
    Rotor,
    RotorSystem,
    Unbalance,
    decode_flags,
    folds,
    hopf_points,
    plot,
    sweep,
    synchronous_response,
)
from rotor_ida.closed_forms import clearance_curve, response_curve
from rotor_ida.plot import panels, plot_amplitude, plot_phase, shared_legend
from rotor_ida.plot.figures import figure_of
from rotor_ida.plot.labels import KIND_WORDS
from rotor_ida.plot.responses import DOTS, KINDS
from rotor_ida.schema import RESPONSE
from tests.plot.pictures import line_of, lines_of, words_of

SHAFT = {"zeta": 0.2, "delta0": 1.0, "shaft_stiffness": 0.25}
SPEEDS = np.array([0.9, 1.1, 1.5])


def test_stable_unstable_and_neutral_whirls_differ_without_colour(exact):
    ax = plot_amplitude(exact)
    styles = {
        repr(line_of(ax, label)._unscaled_dash_pattern)
        for label in ("stable whirl", "unstable whirl", "contact-free whirl")
    }
    assert len(styles) == 3


def test_special_points_are_marked_where_they_are(exact, fold_points):
    given = {"zeta": 0.07, "delta0": 0.5, "contact_damping": 0.5}
    hopf = hopf_points(**given)
    damped = plot_amplitude(response_curve(**given, limits=(0.5, 3.0)), hopf_points=hopf)
    for ax, words, points, name in (
        (plot_amplitude(exact, fold_points=fold_points), "fold", fold_points, "fold"),
        (damped, "Hopf point", hopf, "hopf"),
    ):
        marks = line_of(ax, words)
        assert marks.get_linestyle() == "None"
        np.testing.assert_array_equal(marks.get_xdata(), points[f"{name}_omega"].values.ravel())
        np.testing.assert_array_equal(marks.get_ydata(), points[f"{name}_amplitude"].values.ravel())


def test_folds_lie_on_the_phase_curve(exact, fold_points):
    marks = line_of(plot_phase(exact, fold_points=fold_points), "fold")
    for omega, lag in zip(marks.get_xdata(), marks.get_ydata(), strict=True):
        assert 0.5 * math.pi < lag < math.pi
        on_curve = exact["phase_lag"].values[exact["omega"].values == omega]
        np.testing.assert_allclose(on_curve, lag, rtol=1e-7)


def test_lines_of_a_curve_meet_at_its_folds(exact, fold_points):
    """Each fold is the end of a stable and of an unstable line; pieces are apart."""
    ax = plot_amplitude(exact)
    for omega in fold_points["fold_omega"].values.ravel():
        for label in ("stable whirl", "unstable whirl"):
            x = line_of(ax, label).get_xdata()
            (place,) = np.flatnonzero(x == omega)
            assert np.isnan(x[np.clip([place - 1, place + 1], 0, x.size - 1)]).any() or place == 0
    free = line_of(ax, "contact-free whirl").get_ydata()
    assert np.nanmax(free) == 0.5


def test_whirls_at_given_speeds_are_marked(exact):
    whirls = synchronous_response(omega=[1.2, 1.7], zeta=0.07, delta0=0.5)
    marks = line_of(plot_amplitude(exact, whirls=whirls), "whirl at a given speed")
    shown = marks.get_ydata()
    np.testing.assert_array_equal(
        shown[np.isfinite(shown)], whirls.amplitude.values[whirls.amplitude.notnull()]
    )
    assert set(marks.get_xdata()) == {1.2, 1.7}


def test_responses_that_no_curve_shows_are_bars_over_their_radius(exact, simulated):
    ax = plot_amplitude(exact, simulated=simulated)
    bars = {each.get_label(): each for each in ax.collections}
    bouncing = bars["bouncing: range of $|z|$"].get_segments()[0]
    np.testing.assert_allclose(bouncing, [[1.5, 0.2], [1.5, 2.2]])
    words = {"full contact", "chaotic", "unresolved"}
    assert {f"{each}: range of $|z|$" for each in words} <= set(bars)


def test_legend_names_every_kind_and_direction_once(exact, simulated, fold_points):
    ax = plot_amplitude(exact, simulated=simulated, fold_points=fold_points)
    assert words_of(ax) == [
        "stable whirl",
        "unstable whirl",
        "contact-free whirl",
        "fold",
        "synchronous response",
        "contact-free response",
        "bouncing: range of $|z|$",
        "full contact: range of $|z|$",
        "touching ever more slightly",
        "chaotic: range of $|z|$",
        "unresolved: range of $|z|$",
        "speed going up",
        "speed going down",
        "clearance",
    ]


def test_panels_share_the_tallest_range_and_one_legend(exact):
    figure, axes = panels(1, 2)
    flat = response_curve(zeta=1.0, delta0=0.0, limits=(0.05, 3.0))
    plot_amplitude(exact, ax=axes[0])
    plot_amplitude(flat, ax=axes[1])
    shared_legend(figure, axes)
    assert axes[0].get_ylim()[1] > 13.2
    assert [ax.get_legend() for ax in axes] == [None, None]
    assert [ax.get_title(loc="left") for ax in axes] == ["a", "b"]
    assert len(figure.legends) == 1


def test_other_parameters_than_those_of_the_curve_are_refused(exact, simulated, shafted):
    given = {"zeta": 0.07, "delta0": 0.0}
    loaded = sweep(omega=[1.0, 2.0], load=0.3, method="taylor", **SHAFT)
    plain = synchronous_response(omega=[1.0], zeta=0.2, delta0=1.0)
    for curve, name, beside, words in (
        (exact, "simulated", simulated.assign_coords(zeta=[0.1]), r"zeta of exact, 0\.07"),
        (
            exact,
            "whirls",
            synchronous_response(omega=1.2, **given),
            r"delta0 of exact, 0\.5, got 0",
        ),
        (exact, "hopf_points", hopf_points(**given, friction=0.0), r"delta0 of exact, 0\.5, got 0"),
        (shafted, "whirls", plain, r"shaft_stiffness of exact, 0\.25, got 0\.0"),
        (shafted, "simulated", loaded, r"load of exact, 0\.0, got 0\.3"),
    ):
        with pytest.raises(InputError, match=f"{name} must have the {words}"):
            plot_amplitude(curve, **{name: beside})


def test_contacting_whirls_without_damping_are_not_called_contact_free():
    undamped = response_curve(zeta=0.0, delta0=0.5, limits=(0.05, 3.0))
    assert "neutral whirl" in words_of(plot_amplitude(undamped))
    assert "contact-free whirl" not in words_of(plot_amplitude(undamped))


@pytest.mark.parametrize(
    ("limits", "shown"), [((0.05, 3.0), 4), ((1.0, 1.5), 1)], ids=["all", "one of them"]
)
def test_folds_outside_the_range_of_speeds_are_not_marked(fold_points, limits, shown):
    exact = response_curve(zeta=0.07, delta0=0.5, limits=limits)
    omega = line_of(plot_amplitude(exact, fold_points=fold_points), "fold").get_xdata()
    assert omega.size == shown
    assert abs(omega - 1.3407).min() < 1e-3


@pytest.fixture(scope="module")
def whirls_over_clearance():
    return clearance_curve(omega=1.2, zeta=0.07, limits=(0.0, 3.0))


def test_over_clearance_every_whirl_is_on_a_line_of_its_stability(whirls_over_clearance):
    ax = plot_amplitude(whirls_over_clearance)
    lines = {}
    for line in ax.lines:
        lines.setdefault(line.get_label(), []).append(line.get_ydata())
    assert set(lines) == {"stable whirl", "unstable whirl", "contact-free whirl", "clearance"}
    unstable = whirls_over_clearance.amplitude.where(whirls_over_clearance.stability == 0).values
    assert np.isin(unstable[np.isfinite(unstable)], np.concatenate(lines["unstable whirl"])).all()


def test_over_clearance_responses_off_the_whirls_are_bars(whirls_over_clearance, simulated):
    here = simulated.isel(omega=slice(0, 3), delta0=0, direction=[0], drop=True)
    moved = here.rename(omega="delta0").assign_coords(delta0=[0.4, 0.5, 0.6])
    moved = moved.expand_dims(omega=[1.2])
    ax = plot_amplitude(whirls_over_clearance, simulated=moved)
    (bars,) = ax.collections
    np.testing.assert_allclose(bars.get_segments()[0][:, 1], [0.2, 2.2])
    marks = [line for line in ax.lines if line.get_marker() == "s"]
    assert {line.get_label() for line in marks} == {"synchronous response", "contact-free response"}
    assert line_of(ax, "speed going up").get_marker() == "^"
    assert bars.get_label() == "bouncing: range of $|z|$"


def test_bars_that_reach_beyond_the_whirls_are_in_view(simulated):
    low = clearance_curve(omega=2.5, zeta=0.07, limits=(0.0, 3.0))
    here = simulated.isel(omega=[2], direction=[0]).assign_coords(omega=[2.5])
    ax = plot_amplitude(low, simulated=here)
    (bars,) = ax.collections
    assert ax.get_ylim()[1] > max(bars.get_segments()[0][:, 1]) > float(low.amplitude.max())


@pytest.fixture(scope="module")
def shafted():
    return response_curve(**SHAFT, limits=(0.5, 2.5))


def test_the_title_has_the_parameters_beyond_the_papers(shafted):
    ax = plot_amplitude(shafted, fold_points=folds(**SHAFT))
    assert ax.get_title() == r"$\zeta = 0.2$,  $\delta_0 = 1$,  $\kappa = 0.25$"
    over = clearance_curve(omega=1.2, zeta=0.2, limits=(0.0, 2.0), shaft_stiffness=0.25)
    title = plot_amplitude(over).get_title()
    assert title == r"$\omega = 1.2$,  $\zeta = 0.2$,  $\kappa = 0.25$"
    other = sweep(omega=1.2, zeta=0.2, delta0=[0.5, 1.0], method="taylor")
    with pytest.raises(InputError, match="simulated must have the shaft_stiffness of exact"):
        plot_amplitude(over, simulated=other)


@pytest.mark.parametrize("draw", [plot_amplitude, plot_phase])
def test_a_load_that_lays_the_rotor_on_the_stator_leaves_no_curve_and_the_title_says_so(draw):
    loaded = sweep(omega=[1.0, 2.0], load=0.3, method="taylor", **SHAFT)
    ax = draw(None, simulated=loaded)
    assert ax.get_title().splitlines() == [
        r"$\zeta = 0.2$,  $\delta_0 = 1$,  $\kappa = 0.25$",
        r"$\gamma = 0.3$: no linear response: at rest on the stator",
    ]
    assert "stable whirl" not in words_of(ax)
    with pytest.raises(InputError, match="exact must be a Dataset, or None beside simulated"):
        draw(None)


def test_under_a_load_the_linear_response_is_drawn_up_to_the_touch():
    """The exact line is the largest radius: it ends at the clearance, and a sweep lies on it."""
    rotor = {**SHAFT, "load": 0.15}
    exact = response_curve(**rotor, limits=(0.05, 3.0))
    swept = sweep(omega=[0.2, 3.0], method="taylor", **rotor)
    ax = plot_amplitude(exact, simulated=swept)
    assert ax.get_title().endswith(": linear up to the touch, limit_cycle beyond")
    (line,) = [each for each in ax.lines if each.get_label() == "stable whirl"]
    speeds, radii = line.get_data()
    whole = np.isfinite(speeds)
    assert np.nanmax(radii) == pytest.approx(1.0, rel=1e-12)  # the clearance
    rising = whole & (speeds < 0.5)
    drawn = np.interp(0.2, speeds[rising], radii[rising])
    assert drawn == pytest.approx(float(swept.radius_max.squeeze()[0]), rel=1e-4)


def test_each_kind_of_range_has_its_look():
    """Colour, line or filling: no two kinds are drawn alike, nor two ranges of one line."""
    looks = [(look.colour, look.filled, repr(look.dashes)) for look in KINDS.values()]
    assert len(set(looks)) == len(KINDS)
    assert KINDS.keys() == KIND_WORDS.keys()
    of_ranges = [(look.filled, repr(look.dashes)) for look in KINDS.values() if look.is_range]
    assert KINDS["rolling"].dashes not in ("-", DOTS)
    assert of_ranges.count((KINDS["rolling"].filled, repr(KINDS["rolling"].dashes))) == 1


@pytest.mark.parametrize("kind", ["rolling", "quasi_periodic"])
def test_rolling_and_quasi_periodic_responses_have_bars_marks_and_a_legend(simulated, kind):
    flag = RESPONSE[kind]
    seen = simulated.assign(
        response=simulated["response"].copy(data=np.full((7, 1, 1, 1, 2), flag))
    )
    seen = seen.assign(radius_min=seen["radius_max"] - 0.5)
    ax = plot_amplitude(None, simulated=seen)
    words = f"{KIND_WORDS[kind]}: range of $|z|$"
    assert words in words_of(ax)
    (bars,) = (each for each in ax.collections if each.get_label() == words)
    np.testing.assert_allclose(bars.get_colors()[0], to_rgba(KINDS[kind].colour))
    ends = np.array([segment[:, 1] for segment in bars.get_segments()])
    np.testing.assert_allclose(ends[:, 1] - ends[:, 0], 0.5)
    assert {each.get_marker() for each in ax.lines if each.get_color() != "none"} >= {"^", "v"}


def test_a_sweep_along_friction_is_drawn_over_friction_by_direction():
    rotor = Rotor(omega=1.6, zeta=0.07, delta0=0.5, friction=0.0, disc_radius=10.0)
    frictions, high = [0.0, 0.02, 0.05], [(6.0, 0.0, 0.0, 6.0)]
    both = sweep(rotor, friction=frictions, starts=high, direction="both", method="taylor")
    (ax,) = figure_of(both).axes
    assert ax.get_xlabel() == r"friction $\mu$"
    up, down = (
        np.concatenate([line.get_xydata() for line in ax.lines if line.get_marker() == marker])
        for marker in "^v"
    )
    for drawn, way in ((up, 1), (down, -1)):
        points = np.column_stack([frictions, both.amplitude.sel(direction=way).squeeze()])
        assert {tuple(row) for row in points} <= {tuple(row) for row in drawn}
    assert line_of(ax, "friction going up").get_marker() == "^"
    whirls = synchronous_response(rotor, friction=frictions).amplitude.values
    dots = np.concatenate([each.get_ydata() for each in ax.lines if each.get_marker() == "o"])
    assert np.isin(whirls[np.isfinite(whirls)], dots).all()


def two_discs(stiffer=1.0):
    stiffness = np.kron([[2.0, -1.0], [-1.0, 2.0]], np.diag([1.0, stiffer]))
    system = RotorSystem(
        mass=np.eye(4), stiffness=stiffness, damping=0.1 * stiffness,
        nodes={"one": (0, 1), "two": (2, 3)}, units="1",
    )  # fmt: skip
    contacts = [Contact(node=name, clearance=clearance, stiffness=3.0, exponent=1.0)
                for name, clearance in (("one", 3.0), ("two", 0.8))]  # fmt: skip
    around = {"contacts": contacts, "unbalance": [Unbalance(node="one", moment=0.4)]}
    return system, around


@pytest.fixture(scope="module")
def swept():
    system, around = two_discs()
    found = sweep(system, **around, speed=SPEEDS, direction="up")
    words = decode_flags(found.response).values.ravel().tolist()
    assert words == ["contact_free", "synchronous", "bouncing"]
    return found


def test_steady_responses_are_marks_and_others_bars_over_their_range(swept):
    ax = plot.plot_amplitude(None, simulated=swept, contact=1)
    assert ax.get_title() == "contact 1 at two"
    assert ax.get_xlabel() == r"spin speed $\omega$"
    seen = np.concatenate([line.get_xydata() for line in ax.lines if line.get_marker() == "^"])
    amplitude = swept.amplitude.isel(contact=1).values.ravel()
    for number in (0, 1):
        assert [SPEEDS[number], amplitude[number]] in seen.tolist()
    (bar,) = ax.collections[0].get_segments()
    low, high = (swept[name].isel(contact=1).values.ravel()[2] for name in
                 ("radius_min", "radius_max"))  # fmt: skip
    assert bar.tolist() == [[1.5, low], [1.5, high]]
    assert "bouncing: range of $|z|$" in words_of(ax)
    with pytest.raises(InputError, match="contact must be one of 0 to 1, got 2"):
        plot.plot_amplitude(None, simulated=swept, contact=2)


def test_the_exact_whirls_beneath_are_those_of_the_system(swept):
    first, second = figure_of(swept).axes
    assert first.get_title() == "contact 0 at one"
    lines = lines_of(second)
    stable = lines["stable whirl"].get_xydata()
    system, around = two_discs()
    exact = synchronous_response(system, **around, speed=stable[:4, 0])
    np.testing.assert_allclose(stable[:4, 1], exact.amplitude[:, 0, 1], rtol=1e-12)
    assert "unstable whirl" in lines


def test_without_axial_symmetry_the_linear_response_is_beneath():
    """Without contact a sweep reaches as far as the ellipse by unbalance."""
    system, around = two_discs(stiffer=1.2)
    found = sweep(system, **around, speed=[0.2, 0.3])
    assert decode_flags(found.response).values.ravel().tolist() == ["contact_free"] * 2
    beneath = [line for line in figure_of(found).axes[0].lines
               if line.get_label() == "stable whirl"]  # fmt: skip
    ends = np.sort(np.concatenate([line.get_ydata() for line in beneath]))[[0, -1]]
    np.testing.assert_allclose(ends, np.sort(found.radius_max.isel(contact=0).values.ravel()),
                               rtol=1e-6)  # fmt: skip


def test_under_weight_all_responses_are_ranges_of_the_distance_from_the_centre():
    mass, damping, stiffness, moment, weight = 2.0, 0.3, 4.0, 0.4, 2.0
    system = RotorSystem(
        mass=mass * np.eye(2), stiffness=stiffness * np.eye(2), damping=damping * np.eye(2),
        nodes={"disc": (0, 1)}, contacts=[Contact(node="disc", clearance=2.0, stiffness=3.0)],
        unbalance=[Unbalance(node="disc", moment=moment)], gravity=(0.0, -weight), units="1",
    )  # fmt: skip
    found = sweep(system, speed=[0.5, 1.5])
    assert decode_flags(found.response).values.ravel().tolist() == ["contact_free", "bouncing"]
    ax = plot.plot_amplitude(None, simulated=found)
    assert ax.get_ylabel() == "radius $|z|$"
    (free,), (rub,) = (bars.get_segments() for bars in ax.collections)
    sag = mass * weight / stiffness
    whirl = abs(moment * 0.5**2 / (stiffness - mass * 0.5**2 + 0.5j * damping))
    np.testing.assert_allclose(free[:, 1], [sag - whirl, sag + whirl], rtol=1e-6)
    assert rub[1, 1] > 2.0 > free[1, 1]
    assert {word for word in words_of(ax) if "range" in word} == {
        "contact-free response: range of $|z|$", "bouncing: range of $|z|$"
    }  # fmt: skip


def whipping(radius):
    """Return a sweep of a disc with one dry whip of a radius; not a simulation."""
    found = sweep(omega=[1.0, 1.5, 2.0], **SHAFT, method="taylor")
    found.response[0] = RESPONSE["rolling"]
    found.radius_max[0], found.radius_min[0] = radius, radius
    return found


def test_one_far_response_does_not_hide_the_rest_and_is_told():
    ax = plot_amplitude(None, simulated=whipping(200.0))
    others = whipping(200.0).radius_max.values.ravel()[1:].max()
    assert ax.get_ylim()[1] < 1.2 * others
    (mark,) = [line for line in ax.lines if "off the axis" in line.get_label()]
    assert mark.get_label() == "rolling (dry whip): off the axis, 200"
    assert mark.get_xdata() == [1.0]
    near = plot_amplitude(None, simulated=whipping(2.0 * others))
    assert near.get_ylim()[1] > 2.0 * others
    assert not [line for line in near.lines if "off the axis" in line.get_label()]


def test_the_axis_of_speeds_is_that_of_the_sweep_and_the_clearance_is_a_line():
    loaded = sweep(omega=[1.0, 1.5, 2.0], load=0.3, method="taylor", **SHAFT)
    ax = plot_amplitude(None, simulated=loaded)
    assert 0.9 < ax.get_xlim()[0] < 1.0
    assert 2.0 < ax.get_xlim()[1] < 2.1
    assert set(line_of(ax, "clearance").get_ydata()) == {1.0}
