"""What a basin and fractions say of how they were labelled is what was done."""

import numpy as np
import pytest

from rotor_ida import Rotor, basin, basin_fractions
from rotor_ida.basins import attractors, fates, known
from rotor_ida.basins.disc import RTOL, Disc
from rotor_ida.basins.following import tighter_than
from rotor_ida.basins.known import known_from_closed_forms

FIGURE_7 = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
FOLDED = Rotor(omega=1.7, zeta=0.07, delta0=2.0)
BOX = {"x": (-15, 15), "y": (-15, 15)}
AXIS = np.linspace(-15.0, 15.0, 24)
GOING = np.zeros(1, np.uint8)


def told_by(found, prefix):
    return {
        name.removeprefix(prefix): value
        for name, value in found.attrs.items()
        if name.startswith(prefix)
    }


@pytest.mark.parametrize("rtol", [1e-6, 1e-9])
def test_the_tolerances_told_are_those_of_the_kernel(monkeypatch, rtol):
    """First the labels, then some of them again."""
    seen, follow = [], known.follow

    def watched(*given):
        seen.append(given[-2])
        follow(*given)

    monkeypatch.setattr(known, "follow", watched)
    found = basin(FIGURE_7, x=AXIS, y=AXIS, rtol=rtol, workers=1)
    told = [found.attrs["labelling_rtol"], found.attrs["agreement_rtol"]]
    assert told == [rtol, tighter_than(rtol)]
    assert list(dict.fromkeys(seen)) == told
    assert found.attrs["labelling_method"] == "dop853"


def test_the_confirmation_told_is_the_one_that_was_made(monkeypatch):
    seen, follow = [], attractors.settle_disc

    def watched(rotor, start, options, **how):
        seen.append(options.attributes())
        return follow(rotor, start, options, **how)

    monkeypatch.setattr(attractors, "settle_disc", watched)
    found = basin_fractions(FIGURE_7, **BOX, starts=50)
    assert seen
    assert all(each == told_by(found, "confirmation_") for each in seen)
    assert found.confirmed.values.tolist() == [1, 1]
    assert not {"method", "flight", "backend", "rtol", "atol"} & set(found.attrs)


def test_orbits_left_over_are_followed_as_told(monkeypatch):
    seen, follow = [], fates.settle_disc

    def watched(rotor, start, options, **how):
        seen.append((options.method, options.rtol))
        return follow(rotor, start, options, **how)

    monkeypatch.setattr(fates, "settle_disc", watched)
    states = np.array([[3.0], [1.0], [0.0], [0.0]])
    batch = fates.Batch(known_from_closed_forms(FIGURE_7, GOING), states, RTOL, GOING)
    fates.fate_of(batch, 0)
    found = basin(FIGURE_7, x=[0.0, 1.0], y=[0.0, 1.0])
    assert seen == [(found.attrs["left_over_method"], found.attrs["left_over_rtol"])]


def test_labels_of_a_loose_tolerance_do_not_all_agree():
    """Where basins are folded; with a small error they do, and the part is about that of all."""
    loosely, closely = (
        basin_fractions(FOLDED, **BOX, starts=starts, rtol=rtol)
        for starts, rtol in ((256, 1e-4), (64, 1e-11))
    )
    assert float(closely.agreement) == 1.0
    count = int(loosely.agreement_count)
    assert (count, int(closely.agreement_count)) == (22, 6)  # one of 12 of a batch
    states = np.zeros((4, 150))
    states[:2] = np.random.default_rng(0).uniform(-15.0, 15.0, (2, 150))
    disc = Disc.of(FOLDED, 1e-8, GOING)
    known_ = disc.with_cycles(states, GOING).known
    labels = [known_.follow(states.copy(), 350.0, rtol, GOING)[0] for rtol in (1e-4, 1e-8)]
    held = (labels[0] >= 0) & (labels[1] >= 0)
    part = float((labels[0] == labels[1])[held].mean())
    assert part < 0.9
    error = np.sqrt(part * (1.0 - part) / count)
    assert abs(float(loosely.agreement) - part) < 3.0 * error


def test_a_wrong_label_is_counted_as_one(monkeypatch):
    """One of 12 starts of a batch is followed again, here to the other attractor."""
    true = Disc.label

    def mistaken(disc, states, stop):
        found = true(disc, states, stop)
        return found._replace(again=lambda chosen: (1 - found.labels[chosen]).astype(np.int16))

    monkeypatch.setattr(Disc, "label", mistaken)
    found = basin(FIGURE_7, x=AXIS, y=AXIS)
    assert (int(found.agreement_count), float(found.agreement)) == (43, 0.0)


def test_starts_that_reach_no_known_attractor_again_are_not_counted(monkeypatch):
    true = Disc.label

    def open_again(disc, states, stop):
        found = true(disc, states, stop)
        return found._replace(again=lambda chosen: np.full(chosen.size, -1, np.int16))

    monkeypatch.setattr(Disc, "label", open_again)
    assert int(basin(FIGURE_7, x=AXIS, y=AXIS).agreement_count) == 0
