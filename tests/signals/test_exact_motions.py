"""Known answers of whole motions: run-ups, rests, filters, dry whip, halves of a rub."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Rotor,
    backward_whirl,
    centre_line,
    correct_probes,
    filtered_orbit,
    limit_cycle,
    orders,
    rest,
    run_up,
    signals_of,
    simulate,
    spectral_lines,
    subtract_runout,
    synchronous_response,
    whirl_ratio,
)

FROM_REST = (0.0, 0.0, 0.0, 0.0)
ON_SHAFT = {"zeta": 0.04, "delta0": 2.0, "shaft_stiffness": 0.04, "contact_exponent": 1.0,
            "friction": 0.1, "disc_radius": 20.0}  # fmt: skip


def run_up_at(rotor, rate, to, a_revolution=40):
    samples = round((to - rotor.omega) / rate * to / (2.0 * math.pi) * a_revolution)
    return run_up(rotor, start=FROM_REST, to=to, rate=rate, samples=samples, method="taylor")


def distance_from_exact(run, rotor, span):
    """Return the largest distance of 1X as a vector from the nearest exact whirl, and contacts."""
    found = orders(run).isel(order=0)
    found = found.isel(window=(found.speed.values > span[0]) & (found.speed.values < span[1]))
    given = {name: each for name, each in rotor.given.items() if name != "omega"}
    exact = synchronous_response(omega=found.speed.values, **given)
    exact = exact.squeeze(["zeta", "delta0"]).transpose("omega", "branch")
    whirls = exact.amplitude * np.exp(-1j * exact.phase_lag)
    tracked = found.forward_whirl_amplitude * np.exp(-1j * found.forward_phase_lag)
    apart = np.abs(whirls.values - tracked.values[:, None])
    nearest = np.nanargmin(apart, axis=1)[:, None]
    contact = np.take_along_axis(exact.in_contact.values, nearest, axis=1)
    return np.take_along_axis(apart, nearest, axis=1).max(), contact


@pytest.mark.parametrize(
    ("rotor", "to", "span", "contact"),
    [
        (Rotor(omega=0.2, zeta=0.2, delta0=10.0, shaft_stiffness=1.0), 2.0, (0.8, 1.9), 0),
        (Rotor(omega=0.2, zeta=0.1, delta0=1.5, shaft_stiffness=0.2), 1.0, (0.7, 0.95), 1),
    ],
    ids=["through resonance", "on the ring"],
)
def test_orders_of_run_ups_tend_to_the_exact_whirls_with_order_one_of_the_rate(
    rotor, to, span, contact
):
    """A whirl lags behind its quasi-static change by the rate times a bounded vector."""
    rates, errors = (0.002, 0.001), []
    for rate in rates:
        error, touching = distance_from_exact(run_up_at(rotor, rate, to), rotor, span)
        errors.append(error)
        assert (touching == contact).all()
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.05)


TIMES = np.arange(40_000) / 100.0
BAND = (4.0, 9.0)


def butterworth(frequency, band, step=0.01, poles=4):
    """Return the gain forwards and backwards in time, by the bilinear transform."""
    at, low, high = (np.tan(0.5 * step * np.abs(each)) for each in (frequency, *band))
    ratio = at / high if band[0] == 0.0 else (at**2 - low * high) / (at * (high - low))
    return 1.0 / (1.0 + ratio ** (2 * poles))


@pytest.mark.parametrize("band", [BAND, (0.0, 5.0)])
def test_a_band_has_the_gain_of_butterworths_filter_and_no_lag(band):
    """S. Butterworth, 1930: one over 1 + ratio**8; squared here, as the filter runs both ways."""
    frequencies = np.array([2.5, -3.7, 4.0, 6.0, -6.5, 9.0, -12.0])
    lines = np.exp(1j * np.outer(frequencies, TIMES))
    z = lines.sum(axis=0)
    found = filtered_orbit(xr.Dataset({"x": ("t", z.real), "y": ("t", z.imag)}, {"t": TIMES}),
                           band=band)  # fmt: skip
    expected = butterworth(frequencies, band) @ lines
    middle = slice(15_000, 25_000)  # transients at the ends have died away
    np.testing.assert_allclose((found.x + 1j * found.y)[middle], expected[middle], atol=1e-10)


def test_one_order_of_a_rub_is_its_exact_ellipse(rub_of_halves):
    """Of the lines of the exact cycle those of order 1, forward and backward."""
    cycle, run = rub_of_halves
    found = filtered_orbit(run, order=1, revolutions=2)
    forward, backward = (line_at(cycle, order) for order in (1.0, -1.0))
    radius = np.abs(found.x + 1j * found.y)
    assert radius.max() == pytest.approx(forward + backward, rel=1e-5)
    assert radius.min() == pytest.approx(forward - backward, rel=1e-5)
    assert backward > 0.01


def test_a_slow_rotor_lies_where_it_rests():
    """Its whirl is of the size omega**2, which moves the mean by its square at most."""
    for load in (0.03, 0.4):  # hangs on its shaft; lies on the ring
        rotor = Rotor(omega=0.02, zeta=0.2, delta0=1.0, shaft_stiffness=0.05, load=load)
        exact = rest(rotor)
        assert (exact.indentation > 0.0) == (load > 0.3)
        run = simulate(rotor, start=(0.0, exact.y.item(), 0.0, 0.0), duration=4000.0, samples=8001)
        found = centre_line(run).isel(window=slice(5, None))
        np.testing.assert_allclose(found.offset_y, exact.y, atol=4e-6)
        np.testing.assert_allclose(found.offset_x, 0.0, atol=4e-6)


def test_a_rub_lifts_the_mean_position_to_that_of_its_exact_cycle(rub_of_halves):
    cycle, run = rub_of_halves
    found = centre_line(run, revolutions=2)
    mean = np.hypot(found.offset_x, found.offset_y)
    np.testing.assert_allclose(mean, line_at(cycle, 0.0), rtol=1e-8)
    assert (mean < 0.5 * 0.06 / 0.04).all()


@pytest.fixture(scope="module")
def rub_of_halves():
    """Return the stable cycle of a partial rub every other revolution, and a run on it."""
    rotor = Rotor(omega=0.8, load=0.06, **ON_SHAFT)
    cycle = limit_cycle(rotor, start=(0.0, -1.0, 0.0, 0.0))
    start = [float(cycle[name][0]) for name in ("x", "y", "vx", "vy")]
    times = np.arange(20 * 1024 + 1) / 1024 * float(cycle.period)
    run = simulate(
        rotor, start=start, duration=times[-1], samples=times, method="taylor", rtol=1e-13
    )  # fmt: skip
    return cycle, run


def line_at(cycle, order):
    """Return the amplitude of the line of a cycle at a multiple of the speed."""
    place = np.abs(cycle.frequency.values / cycle.omega.item() - order).argmin()
    return cycle.whirl_amplitude.values[place]


def test_half_orders_of_a_rub_are_the_lines_of_its_exact_cycle(rub_of_halves):
    """Shooting, and a Fourier series over the exact period, know nothing of windows."""
    cycle, run = rub_of_halves
    assert cycle.period.item() == pytest.approx(4.0 * math.pi / 0.8, rel=1e-12)
    asked = [0.5, 1.0, 1.5, 2.0, 2.5]
    found = orders(run, asked)
    for place, order in enumerate(asked):
        ahead, back = (found[f"{way}_whirl_amplitude"][:, place] for way in ("forward", "backward"))
        np.testing.assert_allclose(ahead, line_at(cycle, order), atol=1e-8)
        np.testing.assert_allclose(back, line_at(cycle, -order), atol=1e-8)
    assert line_at(cycle, 0.5) > 0.1


def test_dry_whip_has_the_exact_backward_line_and_ratio():
    """In a machine s times as large unbalance is 1/s, and what it adds to the line is 1/s**2."""
    errors = []
    for size in (100.0, 1000.0):
        wide = ON_SHAFT | {"delta0": 2.0 * size, "disc_radius": 20.0 * size}
        rotor = Rotor(omega=0.9, **wide)
        whip = backward_whirl(rotor).isel(whirl=1)
        radius, speed = whip.amplitude.item(), whip.whirl_speed.item()
        run = simulate(rotor, start=(radius, 0.0, 0.0, radius * speed), duration=800.0,
                       samples=16_001, method="taylor")  # fmt: skip
        late = run.sel(t=slice(300.0, None))
        line = spectral_lines(late, count=2)
        line = line.isel(line=int(line.whirl_amplitude.values.argmax()))
        ratio = whirl_ratio(late, revolutions=20)
        assert (ratio.whirl_sense == -1).all()
        np.testing.assert_allclose(ratio.whirl_over_spin, speed / 0.9, atol=1.0 / size)
        errors.append([line.frequency.item() / speed - 1.0, line.whirl_amplitude / radius - 1.0])
    first, second = np.abs(errors)
    assert (second < 1e-6).all()
    np.testing.assert_allclose(first / second, 100.0, rtol=0.1)


def test_probes_gains_and_runout_of_a_run_up_on_the_ring_are_corrected():
    """The slow roll takes the bow away, and with it what the shaft whirls there: that is known."""
    given = {"zeta": 0.1, "delta0": 1.5, "shaft_stiffness": 0.2}
    rotor = Rotor(omega=0.2, **given)
    run = run_up_at(rotor, 0.004, 1.0)
    assert run.sizes["contact"] > 0
    slow = simulate(Rotor(omega=0.01, **given), start=FROM_REST, duration=4000.0, samples=8001)
    true, slow = signals_of(run), signals_of(slow).sel(t=slice(500.0, None))
    clean = subtract_runout(seen(true), seen(slow))
    left = (true.x - clean.x) + 1j * (true.y - clean.y)
    whirl = synchronous_response(omega=0.01, **given).isel(branch=0).squeeze()
    expected = whirl.amplitude.item() * np.exp(1j * (true.angle - whirl.phase_lag.item()))
    np.testing.assert_allclose(left, expected, atol=1e-9)
    steps = orders(clean).forward_whirl_amplitude - orders(true).forward_whirl_amplitude
    assert abs(steps).max() < 1.001 * whirl.amplitude


def seen(signals):
    """Return what probes at 45 and 135 degrees with gains of their own show, corrected for those.

    A bow of the shaft turns with it.
    """
    bow = 0.4 * np.exp(1j * (signals.angle + 1.0))
    z = signals.x + 1j * signals.y + bow
    first, second = (np.radians(each) for each in (45.0, 135.0))
    read = signals.assign(
        x=2.0 * (z.real * np.cos(first) + z.imag * np.sin(first)),
        y=3.0 * (z.real * np.cos(second) + z.imag * np.sin(second)),
    )
    return correct_probes(read, angles=(45, 135), gains=(2.0, 3.0))
