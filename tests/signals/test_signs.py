"""Signs of a rub: lines, crest and floor of records made of known whirls and noise."""

import math

import numpy as np
import pytest
import xarray as xr

from rotor_ida import InputError, rub_signs

TURN, TURNS, SPEED = 50, 101.3, 314.0


def record(turns=TURNS, noise=0.0, change=0.0, per=TURN, **lines):
    """Return a record with 1X of 1 and lines of orders and amplitudes, as ``x0_47=0.5``."""
    angle = 2.0 * math.pi * np.arange(round(turns * per)) / per
    angle = angle + change * angle**2
    z = np.exp(1j * angle)
    for name, amplitude in lines.items():
        order = float(name[1:].replace("_", ".").replace("m", "-"))
        z = z + amplitude * np.exp(1j * order * angle)
    draw = np.random.default_rng(1).normal(size=(2, z.size))
    z = z + noise * (draw[0] + 1j * draw[1])
    t = np.arange(z.size) * 2.0 * math.pi / (per * SPEED)
    return xr.Dataset({"x": ("t", z.real), "y": ("t", z.imag), "angle": ("t", angle)}, {"t": t})


@pytest.mark.parametrize(
    ("lines", "order", "words"),
    [
        ({"x0_47": 0.3}, 0.47, "as in oil whirl; a rub under a load has both"),
        ({"xm1_23": 0.5}, -1.23, "An annular or partial rub has such a line"),
        ({"xm1_23": 1.7}, -1.23, "backwards, at 1.23 times its speed, as in dry whirl"),
        ({"x0_333333333": 0.2, "xm0_333333333": 0.19}, 1 / 3, "repeats after 3 revolutions"),
        ({"xm0_333333333": 0.2, "x0_333333333": 0.15}, -1 / 3, "repeats after 3 revolutions"),
        ({"x1_6": 0.2}, 1.6, "A line at 1.600X has 0.20 of 1X."),
        ({"x2": 0.5, "x0_47": 0.3}, 2.0, "as in oil whirl"),
        ({"x3": 0.5}, 3.0, "3X has 0.50 of 1X. A rub once a revolution"),
        ({"xm1": 0.4, "x0_47": 0.3}, -1.0, "has both. The orbit is an ellipse, with 0.40 of 1X"),
        ({"xm0_5": 1.5, "x0_5": 1.4}, -0.5, "repeats after 2 revolutions"),
        ({"xm2_05": 5.0}, -2.05, "backwards, at about 2 times its speed, as in dry whirl"),
        ({"xm2": 5.0}, -2.0, "backwards, at about 2 times its speed, as in dry whirl"),
        ({"xm1": 1.4}, -1.0, "The orbit turns backwards once a revolution"),
        ({"x0_47": 0.01}, 0.47, "Nothing stands out beside 1X"),
    ],
)  # fmt: skip
def test_the_line_is_found_and_told_also_in_noise(lines, order, words):
    strongest = next(iter(lines.values()))
    for noise in (0.0, 0.02):
        found = rub_signs(record(noise=noise, **lines))
        assert found["line_order"].item() == pytest.approx(order, abs=1e-4 + 0.05 * noise)
        assert found["line_amplitude"].item() == pytest.approx(strongest, rel=2e-3 + 5.0 * noise)
        assert words in found.attrs["sentence"]


def test_a_line_beside_minus_1x_makes_no_ellipse():
    """The flank of a strong line at -1.065X covers -1X, where there is no line."""
    found = rub_signs(record(turns=100, xm1_06506=0.06, x0_312=2.0))
    assert found["backward_whirl_amplitude"].item() < 1e-4
    assert "ellipse" not in found.attrs["sentence"]


def test_slow_changes_are_no_lines():
    """A speed that drifts, a 1X that grows and shrinks, and a mean that jumps."""
    whole, t = record(), record()["t"].values
    slow = np.cos(0.03 * whole["angle"].values)
    modulated = whole.assign({name: whole[name] * (1.0 + 0.3 * slow) for name in ("x", "y")})
    jumping = whole.assign(x=whole["x"] + 0.5 * (whole["t"] > t.mean()))
    for signals in (record(turns=60_000, change=2.3e-9, per=12), modulated, jumping):
        said = rub_signs(signals).attrs["sentence"]
        assert said.startswith("Nothing stands out beside 1X, as far as lines more than")


def test_a_probe_that_stays_still_has_no_crest_and_a_whirl_without_1x_is_told():
    still = record(turns=60).assign(y=("t", np.zeros(60 * TURN)))
    assert rub_signs(still)["least_crest"] == pytest.approx(1.0, rel=1e-3)
    whirl = record(turns=60, x0_47=1.0)
    alone = whirl - record(turns=60).drop_vars("angle")
    said = rub_signs(alone.assign(angle=whirl["angle"])).attrs["sentence"]
    assert said.startswith("A forward line at 0.470X without a backward one is there without 1X")


def test_noise_alone_is_no_line_and_a_floor_only_if_it_is_broad():
    quiet, loud = (rub_signs(record(noise=each)) for each in (0.02, 0.6))
    assert math.isnan(quiet["line_order"])
    assert quiet["line_amplitude"] == 0.0
    assert quiet.attrs["sentence"].startswith("Nothing stands out")
    assert "and so has noise" in loud.attrs["sentence"]


def test_the_crest_is_that_of_the_clipped_side():
    """A wave that is cut at half its height: its crest follows from the integrals of the parts."""
    signals = record(turns=100)
    y = np.maximum(signals["y"].values, -0.5)
    cut = math.asin(0.5)
    mean = (math.cos(cut) - 0.5 * (math.pi / 2 - cut)) / math.pi
    half = math.pi / 2 - cut
    square = 0.5 - (half + 0.5 * math.sin(2 * cut) - 0.5 * half) / (2.0 * math.pi)
    found = rub_signs(signals.assign(y=("t", y)))
    expected = (0.5 + mean) / math.sqrt(2.0 * (square - mean**2))
    assert found["least_crest"].item() == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize(
    ("signals", "message"),
    [
        (record(turns=20), "signals must last at least 48 revolutions, got 20"),
        (record(change=1e-3), "signals must be at one known speed"),
        (record().drop_vars("angle"), "signals must be at one known speed"),
        ((0.0 * record()).assign(angle=record()["angle"]), "signals must move, got x and y that"),
    ],
)  # fmt: skip
def test_records_without_signs_are_refused(signals, message):
    with pytest.raises(InputError, match=message):
        rub_signs(signals)
