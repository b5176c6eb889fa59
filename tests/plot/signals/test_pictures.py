"""The plots practitioners read show the numbers of their datasets, in whatever units."""

import math

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    InputError,
    Rotor,
    backward_whirl,
    centre_line,
    dimensional,
    folds,
    full_spectrum,
    hopf_points,
    limit_cycle,
    orders,
    read_signals,
    run_up,
    signals_of,
    simulate,
    spectrogram,
    synchronous_response,
)
from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import (
    plot_bode,
    plot_cascade,
    plot_centre_line,
    plot_full_spectrum,
    plot_orbit,
    plot_orders,
    plot_polar,
    plot_spectrogram,
    plot_trace,
)
from rotor_ida.plot.signals import spectra
from rotor_ida.schema import flags_of, labelled_dataset
from tests.plot.pictures import check_nothing_cut_off, line_of, words_of

REST = (0.0, 0.0, 0.0, 0.0)
EVERY = (
    plot_bode, plot_polar, plot_orders, plot_orbit, plot_full_spectrum, plot_cascade,
    plot_spectrogram, plot_centre_line, plot_trace,
)  # fmt: skip


@pytest.fixture(scope="module")
def up():
    rotor = Rotor(omega=0.3, zeta=0.07, delta0=0.5)
    return run_up(rotor, start=REST, to=2.5, rate=0.005, samples=20_001)


@pytest.fixture(scope="module")
def exact():
    return response_curve(zeta=0.07, delta0=0.5, limits=(0.3, 2.5))


@pytest.fixture(scope="module")
def machine():
    return DimensionalRotor(
        mass=4.0, contact_stiffness=3.2e7, damping=89.1, eccentricity=10e-6, clearance=20e-6,
        speed=2000.0,
    )  # fmt: skip


@pytest.fixture(scope="module")
def cycle():
    return limit_cycle(
        Rotor(omega=2.0, zeta=0.07, delta0=2.0), start=(2.6, 0.75, 0.66, -1.65), period=4.5
    )


@pytest.fixture(scope="module")
def bouncing(cycle):
    start = [cycle[name].values[0] for name in ("x", "y", "vx", "vy")]
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    return simulate(rotor, start=start, duration=400.0, samples=8001)


def whirl(forward=1.0, backward=0.0, speed=2.0, noise=0.0, lag=0.0, time="1", length="1"):
    times = np.arange(8000) * 0.02
    turn = speed * times
    z = forward * np.exp(1j * (turn - lag)) + backward * np.exp(-1j * turn)
    rng = np.random.default_rng(3)
    z = z + noise * (rng.normal(size=times.size) + 1j * rng.normal(size=times.size))
    columns = {"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", turn)}
    found = labelled_dataset("Signals", columns, {"t": ("t", times)})
    for name, unit in (("t", time), ("x", length), ("y", length)):
        found[name].attrs["units"] = unit
    return found


def figure_of(drawn):
    return (drawn[0] if isinstance(drawn, list) else drawn).figure


@pytest.mark.parametrize("draw", EVERY)
def test_runs_and_signals_give_the_same_picture(draw, up):
    """A picture needs no more of a run than two probes and a keyphasor tell."""
    run = draw(up, keyphasor=True) if draw is plot_orbit else draw(up)
    seen = figure_of(draw(signals_of(up)))
    for here, there in zip(figure_of(run).axes, seen.axes, strict=True):
        assert here.get_xlabel() == there.get_xlabel()
        np.testing.assert_allclose(here.get_xlim(), there.get_xlim(), rtol=0.02, atol=0.05)
    check_nothing_cut_off(seen)


def test_bode_shows_amplitude_and_lag_of_a_known_whirl():
    upper, lower = plot_bode(whirl(forward=3.0, backward=0.5, lag=1.0)).axes
    np.testing.assert_allclose(line_of(upper, "1X forward").get_ydata(), 3.0, rtol=1e-9)
    np.testing.assert_allclose(lower.get_lines()[-1].get_ydata(), math.degrees(1.0), rtol=1e-9)
    backward, _ = plot_bode(whirl(forward=3.0, backward=0.5), sense="backward").axes
    np.testing.assert_allclose(line_of(backward, "1X backward").get_ydata(), 0.5, rtol=1e-8)


@pytest.fixture(scope="module")
def half(tmp_path_factory):
    """Return the signals of a steady 1X of 20 with 1/2X of 6 about the mean 40 + 20j at 25 Hz."""
    times = np.arange(0.0, 4.0, 1 / 2048)
    turn = 50.0 * np.pi * times
    z = 40.0 + 20.0j + 20.0 * np.exp(1j * turn) + 6.0 * np.exp(0.5j * turn)
    path = tmp_path_factory.mktemp("half") / "half.csv"
    columns = np.stack([times, z.real, z.imag, np.cos(turn) > 0.9], axis=1)
    np.savetxt(path, columns, "%.6f", ",", header="t_s,x_um,y_um,keyphasor", comments="")
    return read_signals(path)


@pytest.mark.parametrize("fit", [{}, {"orders": [0.5]}, {"revolutions": 6}])
def test_a_steady_half_order_moves_neither_1x_nor_the_mean(half, fit):
    upper, _ = plot_bode(half, **fit).axes
    assert words_of(upper) == ["1X forward"]
    line, polar = line_of(upper, "1X forward"), line_of(plot_polar(half, **fit), "1X forward")
    for each in (line, polar):
        np.testing.assert_allclose(each.get_ydata(), 20.0, atol=0.3)
        assert each.get_marker() == "o"  # a line of one point cannot be seen
    centre = plot_centre_line(half, **fit)
    np.testing.assert_allclose(line_of(centre, "mean of each window").get_xdata(), 40.0, atol=0.3)
    assert np.ptp(centre.get_xlim()) > 10.0


def test_errors_that_are_not_small_are_a_band(half):
    upper, lower = plot_bode(half, revolutions=1).axes
    assert words_of(upper) == ["1X forward", "two standard errors"]
    for ax, truth in ((upper, 20.0), (lower, None)):
        (band,) = ax.collections
        low, high = band.get_paths()[0].get_extents().intervaly
        assert truth is None or low < truth < high


def test_a_lag_of_noise_alone_is_not_drawn(tmp_path):
    """Without a whirl below 20 Hz, and noise of 1 %, from 10 to 30 Hz; the lag is 1 above."""
    times = np.arange(0.0, 8.0, 1 / 2048)
    turn = 2.0 * np.pi * (10.0 * times + 1.25 * times**2)
    noise = np.random.default_rng(3).normal(size=(2, times.size))
    z = 20.0 * (times > 4.0) * np.exp(1j * (turn - 1.0)) + 0.2 * (noise[0] + 1j * noise[1])
    path = tmp_path / "noise.csv"
    columns = np.stack([times, z.real, z.imag, turn], axis=1)
    np.savetxt(path, columns, "%.9f", ",", header="t_s,x_um,y_um,angle_rad", comments="")
    upper, lower = plot_bode(read_signals(path), revolutions=2).axes
    across, lags = lower.get_lines()[-1].get_data()
    slow, fast = (across < 19.0 * 60.0), (across > 21.0 * 60.0)
    speeds, amplitude = line_of(upper, "1X forward").get_data()
    assert np.isfinite(amplitude[speeds < 19.0 * 60.0]).all()
    assert np.isnan(lags[slow]).mean() > 0.8
    np.testing.assert_allclose(lags[fast], math.degrees(1.0), atol=2.0)


def test_bode_lies_on_the_exact_curve_below_the_jump(up, exact):
    upper, lower = plot_bode(up, beneath=[exact, folds(zeta=0.07, delta0=0.5)]).axes
    assert words_of(upper) == ["stable whirl", "unstable whirl", "fold", "1X forward"]
    measured, stable = line_of(upper, "1X forward"), line_of(upper, "stable whirl")
    below = (measured.get_xdata() > 0.6) & (measured.get_xdata() < 1.3)
    on_curve = stable.get_xdata() < 1.34
    expected = np.interp(
        measured.get_xdata()[below], stable.get_xdata()[on_curve], stable.get_ydata()[on_curve]
    )
    # a run-up lags its steady curve in proportion to the rate
    np.testing.assert_allclose(measured.get_ydata()[below], expected, rtol=0.03)
    marks = line_of(upper, "fold")
    lags = line_of(lower, "fold")
    np.testing.assert_array_equal(marks.get_xdata(), lags.get_xdata())
    # sin(lag) = 2 zeta A/omega on every whirl of the paper's rotor
    sine = 0.14 * marks.get_ydata() / marks.get_xdata()
    np.testing.assert_allclose(np.sin(np.radians(lags.get_ydata())), sine, atol=0.02)


@pytest.mark.parametrize("lag", [0.3, 2.8])
def test_a_jump_breaks_the_lines_and_a_window_that_spans_it_is_left_out(up, lag):
    tracks = orders(up).isel(window=slice(0, 60))
    smooth = 1.0 + 0.01 * np.arange(60)
    smooth[40:] = 0.2
    smooth[40] = 0.9  # half of the window before the jump, half of it behind
    tracks["forward_whirl_amplitude"][:, 0] = smooth
    tracks["forward_phase_lag"][:, 0] = np.where(smooth > 1.0, 0.1, lag)
    speeds = tracks.speed.values
    upper, lower = plot_bode(tracks).axes
    polar = plot_polar(tracks)
    for line in (upper.get_lines()[0], lower.get_lines()[0]):
        across, up_to = line.get_data()
        drawn = np.isfinite(across) & np.isfinite(up_to)
        np.testing.assert_array_equal(across[drawn], np.delete(speeds, 40))
        assert np.isnan(across[39:43]).any()  # no line leads over it
    radii = polar.get_lines()[0].get_data()[1]
    assert 0.9 not in radii
    assert np.isnan(radii).any()


def test_one_window_is_drawn(up):
    one = orders(up).isel(window=slice(3, 4))
    assert len(plot_bode(one).axes[0].get_lines()[0].get_xdata()) == 1
    plot_polar(one)


def test_a_resonance_that_is_passed_in_few_windows_is_one_line(up):
    fast = run_up(Rotor(omega=0.3, zeta=0.07, delta0=0.5), start=(0, 0, 0, 0), to=1.6, rate=0.02)
    for line in (ax.get_lines()[0] for ax in plot_bode(fast).axes):
        assert np.isfinite(line.get_data()).all()


def test_stable_and_unstable_whirls_and_hopf_points_are_told_apart(up):
    damped = up.assign_coords(contact_damping=0.1)
    speeds = [1.2, 1.7]
    whirls = synchronous_response(omega=speeds, zeta=0.07, delta0=0.5, contact_damping=0.1)
    points = hopf_points(zeta=0.07, delta0=0.5, contact_damping=0.1)
    upper, _ = plot_bode(damped, beneath=[whirls, points]).axes
    marks = [line for line in upper.get_lines() if line.get_marker() == "s"]
    assert sorted(line.get_markerfacecolor() for line in marks) == ["#1a1a1a", "white"]
    # the Hopf point is at 7.4, beyond the picture
    assert words_of(upper) == ["exact whirl", "1X forward"]


def test_up_and_down_are_told_apart():
    there_and_back = run_up(
        Rotor(omega=0.3, zeta=0.3, delta0=0.5), start=REST,
        speeds=[(0, 0.3), (200, 2.0), (400, 0.3)], samples=8001,
    )  # fmt: skip
    upper, _ = plot_bode(there_and_back).axes
    assert words_of(upper) == ["1X forward: speed going up", "1X forward: speed going down"]
    assert plot_cascade(there_and_back).get_ylabel() == "time $t$"
    assert plot_cascade(there_and_back, over="speed").get_ylabel() == r"spin speed $\omega$"


def test_polar_angle_is_the_lag_clockwise(up, exact):
    ax = plot_polar(whirl(forward=2.0, lag=0.7))
    line = line_of(ax, "1X forward")
    np.testing.assert_allclose(line.get_xdata(), 0.7, rtol=1e-9)
    np.testing.assert_allclose(line.get_ydata(), 2.0, rtol=1e-9)
    assert ax.get_theta_direction() == -1
    assert "clockwise" in ax.get_xlabel()
    marked = plot_polar(up, beneath=exact)
    told = {float(text.get_text()) for text in marked.texts}
    # at low speeds marks lie too close to each other for numbers
    assert {1.2, 1.6, 2.0} <= told
    assert 0.6 not in told
    assert "stable whirl" in words_of(marked)


def test_speed_marks_lie_on_the_way(up):
    tracks = orders(up)
    ax = plot_polar(tracks)
    place = next(text.xy for text in ax.texts if text.get_text() == "1.2")
    one = tracks.isel(order=0)
    near = int(np.abs(one.speed.values - 1.2).argmin())
    assert place[1] == pytest.approx(one.forward_whirl_amplitude[near].item(), rel=0.05)
    assert place[0] == pytest.approx(one.forward_phase_lag[near].item(), abs=0.1)


def test_orders_have_a_line_for_each_sense(up):
    ax = plot_orders(up, orders=[1, 0.5, 2], logarithmic=True)
    assert words_of(ax)[:2] == ["1X forward", "1X backward"]
    assert ax.get_yscale() == "log"
    looks = {
        (line.get_linestyle(), str(line._dash_pattern), line.get_marker())
        for line in ax.get_lines()
    }
    # told apart without colour too
    assert len(looks) == 6


def test_speeds_are_in_rpm_and_frequencies_in_hertz():
    seen = whirl(speed=100.0 * np.pi / 50.0, time="s", length="um")
    upper, lower = plot_bode(seen).axes
    assert lower.get_xlabel() == "spin speed [rpm]"
    assert upper.get_ylabel() == "whirl amplitude, zero to peak $|c|$ [µm]"
    np.testing.assert_allclose(line_of(upper, "1X forward").get_xdata(), 60.0, rtol=1e-9)
    ax = plot_full_spectrum(seen)
    assert ax.get_xlabel() == "frequency [Hz]"
    forward = line_of(ax, "forward")
    highest = forward.get_xdata()[np.argmax(forward.get_ydata())]
    assert highest == pytest.approx(1.0, abs=0.01)
    assert any(label.endswith("Hz") for label in words_of(ax))
    assert plot_spectrogram(seen).get_xlabel() == "frequency [Hz]"


def test_exact_results_take_the_units_of_the_signals(machine):
    rotor = machine.rotor()
    run = simulate(rotor, start=REST, duration=200.0, samples=8001)
    whirls = synchronous_response(omega=rotor.omega, zeta=rotor.zeta, delta0=rotor.delta0)
    micro = dimensional(run, machine, units={"length": "µm", "time": "ms"})
    for beneath in (whirls, dimensional(whirls, machine)):
        ax, _ = plot_bode(micro, beneath=beneath).axes
        (mark,) = (line for line in ax.get_lines() if line.get_label() == "exact whirl")
        expected = whirls.amplitude.values.ravel() * machine.length_scale * 1e6
        expected = expected[np.isfinite(expected)]
        assert mark.get_ydata()[0] == pytest.approx(expected[0], rel=1e-12)
        assert mark.get_xdata()[0] == pytest.approx(2000.0 * 30.0 / np.pi, rel=1e-12)


def test_measured_signals_need_exact_results_with_units(exact, machine):
    measured = whirl(time="s", length="um")
    with pytest.raises(InputError, match=r"beneath must be in units as the signals.*um"):
        plot_bode(measured, beneath=exact)
    assert len(plot_bode(measured, beneath=dimensional(exact, machine)).axes) == 2
    with pytest.raises(InputError, match="beneath must be dimensionless"):
        plot_bode(whirl(), beneath=dimensional(exact, machine))


def test_the_spectrum_of_a_cycle_lies_in_its_exact_lines(bouncing, cycle):
    ax = plot_full_spectrum(bouncing, beneath=cycle)
    heights = {line.get_label(): line for line in ax.get_lines()}
    frequency = np.append(heights["backward"].get_xdata(), heights["forward"].get_xdata())
    height = np.append(heights["backward"].get_ydata(), heights["forward"].get_ydata())
    marks = [line for line in ax.get_lines() if line.get_marker() == "D"]
    assert len(marks) > 6
    for mark in marks:
        near = abs(frequency - mark.get_xdata()[0]) < 0.05
        assert height[near].max() == pytest.approx(mark.get_ydata()[0], rel=0.01)


def test_noise_floor_and_bandwidth_are_those_of_the_spectrum():
    lines = full_spectrum(whirl(noise=0.01))
    ax = plot_full_spectrum(lines)
    (floor,) = (line for line in ax.get_lines() if line.get_label().startswith("noise floor"))
    assert floor.get_ydata()[0] == lines.noise_floor.item()
    (bar,) = (line for line in ax.get_lines() if line.get_label().startswith("bandwidth"))
    assert np.diff(bar.get_xdata())[0] == pytest.approx(lines.bandwidth.item())


def test_a_full_spectrum_shows_multiples_of_the_largest_speed_of_a_run_up(up):
    np.testing.assert_allclose(plot_full_spectrum(up, span=2.0).get_xlim(), (-5, 5), rtol=0.01)


def test_order_lines_of_a_cascade_are_multiples_of_the_speed(up):
    ax = plot_cascade(up, orders=[-1, 0.5, 1, 2])
    slopes = [np.polyfit(line.get_ydata(), line.get_xdata(), 1)[0] for line in ax.get_lines()[:4]]
    np.testing.assert_allclose(slopes, [-1.0, 0.5, 1.0, 2.0], rtol=1e-9)
    assert [text.get_text() for text in ax.texts[:4]] == ["−1X", "½X", "1X", "2X"]


def test_a_cascade_keeps_the_largest_of_the_segments_that_share_a_row(up, monkeypatch):
    monkeypatch.setattr(spectra, "ROWS", 10)
    seen = spectrogram(up, segment=512, overlap=0.9)
    spiked = seen.copy(deep=True)
    line = int(np.abs(seen.frequency.values + 2.0).argmin())
    spiked.whirl_amplitude[101, line] = 99.0
    ax = plot_cascade(spiked)
    (rows,) = ax.collections
    frequency = spiked.frequency.values[line]
    assert len(rows.get_paths()) == 10
    # without the corners below the picture
    lines = [path.vertices[:-3] for path in rows.get_paths()]
    here = [line[np.isclose(line[:, 0], frequency), 1].max() - line[:, 1].min() for line in lines]
    # the others hold next to nothing there, and the spike is the tallest of all
    assert sorted(here)[-2] < 0.05 * max(here)
    assert max(here) == max(np.ptp(line[:, 1]) for line in lines)
    assert "50 zero to peak" in {text.get_text() for text in ax.texts}


def test_segments_suit_the_rate_of_the_speed(up):
    """The line of a chirp of rate a in a Hann window of length T is a T or 3 pi/T wide."""
    from rotor_ida.signals.record import record_of
    from rotor_ida.signals.spectra import segment_for

    record = record_of(up)
    length = segment_for(record) * record.equal_step()
    assert length == pytest.approx(math.sqrt(3.0 * math.pi / 0.005), rel=0.01)


def test_a_spectrogram_darkens_with_the_amplitude_in_grey(up):
    from matplotlib import colormaps

    shades = colormaps[spectra.COLOURS](np.linspace(0.0, 1.0, 256))[:, :3]
    grey = shades @ [0.299, 0.587, 0.114]
    assert (np.diff(grey) < 0.002).all()
    assert grey[0] - grey[-1] > 0.6
    ax = plot_spectrogram(up)
    assert "whirl amplitude, zero to peak $|c|$" in [each.get_ylabel() for each in ax.figure.axes]


def test_dry_whip_is_marked_at_its_speed_backwards():
    rotor = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
    whirls = backward_whirl(rotor)
    run = simulate(rotor, start=(0.5, 0, 0, 0), duration=100.0, samples=2001)
    ax = plot_full_spectrum(run, beneath=whirls)
    assert {"exact dry whip", "exact slipping whirl"} <= set(words_of(ax))
    mark = line_of(ax, "exact dry whip")
    assert mark.get_xdata()[0] == whirls.whirl_speed[1].item()
    orbit = plot_orbit(signals_of(run), beneath=whirls)
    circle = line_of(orbit, "exact dry whip")
    radius = np.hypot(circle.get_xdata(), circle.get_ydata())
    np.testing.assert_allclose(radius, whirls.amplitude[1].item())


def test_an_exact_orbit_far_outside_is_named_and_leaves_the_axes_to_the_motion(bouncing, cycle):
    part, far = signals_of(bouncing.sel(t=slice(0, 40))), cycle.copy(deep=True)
    far["x"], far["y"] = 40.0 * far["x"], 40.0 * far["y"]
    ax = plot_orbit(part, beneath=far)
    (words,) = [text for text in words_of(ax) if text.startswith("exact cycle, outside")]
    radius = float(np.hypot(far.x, far.y).max())
    assert float(words.partition("radius ")[2]) == pytest.approx(radius, rel=5e-3)
    assert ax.get_ylim()[1] < 4.0 * float(np.hypot(part.x, part.y).max())


def test_an_exact_cycle_lies_under_its_orbit(bouncing, cycle):
    ax = plot_orbit(signals_of(bouncing.sel(t=slice(0, 40))), beneath=cycle)
    under, orbit = line_of(ax, "exact cycle"), line_of(ax, "orbit")
    exact_z = under.get_xdata() + 1j * under.get_ydata()
    simulated = orbit.get_xdata() + 1j * orbit.get_ydata()
    inside = np.isfinite(simulated)
    distance = abs(simulated[inside][::25, None] - exact_z[None]).min(axis=1)
    assert distance.max() < 0.02


def test_dots_of_the_keyphasor_stand_once_a_revolution_after_a_gap():
    seen = whirl(forward=2.0, lag=0.5)
    ax = plot_orbit(seen)
    dots = line_of(ax, "pulse of the keyphasor")
    z = dots.get_xdata() + 1j * dots.get_ydata()
    # 8000 steps of 0.02 at the speed 2 are 50.9 revolutions: 51 pulses, the first at once
    assert z.size == 51
    np.testing.assert_allclose(z, 2.0 * np.exp(-0.5j), atol=2e-3)
    orbit = line_of(ax, "orbit")
    gone = np.isnan(orbit.get_xdata())
    turns = (seen.angle.values / (2.0 * np.pi)) % 1.0
    np.testing.assert_array_equal(gone, turns > 0.97)


def test_under_a_run_up_whirls_may_be_of_several_speeds(up):
    whirls = synchronous_response(omega=[1.2, 1.7], zeta=0.07, delta0=0.5)
    ax = plot_orbit(up.sel(t=slice(0, 100)), beneath=whirls)
    circles = [line for line in ax.get_lines() if line.get_label() == "exact whirl"]
    assert len(circles) == int((whirls.stability == flags_of(whirls.stability)["stable"]).sum())


def test_runs_have_dots_only_when_asked(up):
    part = up.sel(t=slice(0, 100))
    assert "pulse of the keyphasor" not in words_of(plot_orbit(part))
    assert "pulse of the keyphasor" in words_of(plot_orbit(part, keyphasor=True))


def test_the_orbit_of_a_part_has_the_events_and_contacts_of_that_part(bouncing):
    """What came before neither is drawn nor turns contact into flight."""
    late = bouncing.sel(t=slice(300.0, 310.0))
    ax = plot_orbit(late)
    assert "entry" in words_of(ax)
    inside = (bouncing.event_time >= 300.0) & (bouncing.event_time <= 310.0)
    entries = line_of(ax, "entry").get_xdata()
    assert entries.size == int((inside & (bouncing.event_kind == 1)).sum())
    contact = line_of(ax, "contact")
    radius = np.hypot(contact.get_xdata(), contact.get_ydata())
    assert np.nanmin(radius) > 2.0 - 1e-6


def test_noise_of_the_keyphasor_is_no_change_of_direction():
    rng = np.random.default_rng(5)
    speeds = np.linspace(1.0, 4.0, 300) * (1.0 + 0.04 * rng.normal(size=300))
    tracks = orders(whirl()).isel(window=np.zeros(300, dtype=int)).drop_vars("window")
    upper, _ = plot_bode(tracks.assign_coords(speed=("window", speeds))).axes
    assert words_of(upper) == ["1X forward"]


def test_pulses_measured_as_such_are_where_the_dots_are():
    seen = whirl()
    pulses = 2.0 * np.pi / 2.0 * np.arange(1, 50)
    by_pulses = seen.drop_vars("angle").assign(keyphasor=("pulse", pulses))
    ax = plot_orbit(by_pulses)
    dots = line_of(ax, "pulse of the keyphasor")
    np.testing.assert_allclose(dots.get_xdata(), 1.0, atol=1e-3)
    # no samples are known before the first pulse and after the last, which lie between samples
    assert dots.get_xdata().size == 47


def test_the_centre_line_lies_in_the_ring_of_the_clearance(machine):
    heavy = Rotor(omega=0.3, zeta=0.2, delta0=2.0, shaft_stiffness=0.5, load=0.3)
    up = run_up(heavy, start=(0, -0.6, 0, 0), to=0.6, rate=0.002, samples=8001)
    held = centre_line(up)
    ax = plot_centre_line(held)
    line = line_of(ax, "centre line")
    np.testing.assert_array_equal(line.get_ydata(), held.offset_y)
    ring = line_of(ax, "clearance")
    np.testing.assert_allclose(np.hypot(ring.get_xdata(), ring.get_ydata()), 2.0)
    measured = plot_centre_line(whirl(time="s", length="um"), clearance=5.0)
    ring = line_of(measured, "clearance")
    np.testing.assert_allclose(np.hypot(ring.get_xdata(), ring.get_ydata()), 5.0)
    assert measured.get_xlabel() == "mean displacement $x$ [µm]"


def test_a_trace_shades_the_contacts_of_a_run(bouncing):
    part = bouncing.sel(t=slice(0, 40))
    ax = plot_trace(part, names=("radius",))
    (bars,) = ax.collections
    edges = np.array([path.vertices[[0, 2], 0] for path in bars.get_paths()])
    inside = np.hypot(part.x, part.y).values > 2.0
    shaded = (
        (part.t.values[:, None] >= edges[:, 0]) & (part.t.values[:, None] <= edges[:, 1])
    ).any(1)
    assert (inside == shaded).mean() > 0.995
    assert not plot_trace(signals_of(part)).collections


def unknown(run):
    """Return a run without anything that tells the angle."""
    return run.drop_vars(["angle", "omega"])


@pytest.mark.parametrize(
    ("draw", "words"),
    [
        (lambda up: plot_bode(up, sense="up"), "sense must be one of"),
        (lambda up: plot_bode(orders(up), order=2), r"signals must have the order 2, got \[1.0\]"),
        (lambda up: plot_bode(up, order=-1), "orders must be positive, got -1.0"),
        (lambda up: plot_bode(up, axes=[]), "axes must be two matplotlib Axes, got 0"),
        (lambda up: plot_polar(up, ax=plot_trace(up)), "ax must be polar"),
        (lambda up: plot_bode(up, beneath=3), "beneath must be a Dataset or several in a list"),
        (lambda up: plot_bode(up, beneath=[3]), "beneath must be a Dataset, got int"),
        (lambda up: plot_cascade(up, frequencies=[3]), "frequencies must be a mapping such as"),
        (lambda up: plot_cascade(up, frequencies={"a": "b"}), "a frequency must be a finite real"),
        (lambda up: plot_bode([]), "signals must be a Dataset, got list"),
        (lambda up: plot_bode(up, beneath=up), "beneath must be a response curve"),
        (lambda up: plot_cascade(up, beneath=up), "beneath must be a limit cycle"),
        (lambda up: plot_orbit(up, beneath=up), "beneath must be a limit cycle"),
        (lambda up: plot_cascade(up, over="omega"), "over must be one of"),
        (lambda up: plot_cascade(unknown(up), over="speed"), "over must be 't'"),
        (lambda up: plot_cascade(up, span=-1.0), "span must be positive"),
        (lambda up: plot_trace(up, names=("z",)), "names must be of x, y, radius"),
        (lambda up: plot_trace(up, clearance=-1.0), "clearance must"),
        (
            lambda up: plot_bode(up, beneath=folds(zeta=0.1, delta0=0.5)),
            "beneath must have the zeta of the signals, 0.07, got 0.1",
        ),
        (
            lambda up: plot_bode(up, order=2, beneath=folds(zeta=0.07, delta0=0.5)),
            "beneath goes under the order 1 forward, got 2 forward",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_refused(draw, words, up):
    with pytest.raises(InputError, match=words):
        draw(up)
