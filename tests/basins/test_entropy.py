"""Basin entropy: closed forms of simple basins, and the same by hand from each box."""

import math

import numpy as np
import pytest

from rotor_ida import Rotor, basin, basin_fractions
from rotor_ida.basins.dataset import IN_BOX, WIDTH, grid_entropy, sample_entropy
from rotor_ida.basins.kernel import NOT_COMPUTED


def test_one_attractor_has_none():
    assert grid_entropy(np.zeros((20, 20), dtype=np.int16)) == (0.0, 0.0)
    states = np.random.default_rng(1).random((4, 400))
    assert sample_entropy(states, np.zeros(400, dtype=np.int16)) == (0.0, 0.0)


def test_each_box_is_as_by_hand():
    labels = np.random.default_rng(2).integers(0, 3, size=(25, 40)).astype(np.int16)
    by_hand = []
    for row in range(0, 25, WIDTH):
        for column in range(0, 40, WIDTH):
            box = labels[row : row + WIDTH, column : column + WIDTH].ravel().tolist()
            parts = [box.count(label) / IN_BOX for label in set(box)]
            by_hand.append(-sum(part * math.log(part) for part in parts))
    mean, boundary = grid_entropy(labels)
    assert mean == pytest.approx(np.mean(by_hand))
    assert boundary == pytest.approx(np.mean([one for one in by_hand if one > 0.0]))


def test_ends_by_chance_have_that_of_their_fractions():
    """Less by about ``1/(2 n)``, the bias of a box of n starts."""
    random = np.random.default_rng(3)
    labels = (random.random(25 * 1024) < 0.3).astype(np.int16)
    states = random.random((4, labels.size))
    expected = -0.3 * math.log(0.3) - 0.7 * math.log(0.7) - 0.5 / IN_BOX
    assert sample_entropy(states, labels)[0] == pytest.approx(expected, abs=0.01)


def test_a_smooth_border_is_in_few_boxes_and_a_fractal_one_is_not():
    random = np.random.default_rng(4)
    states = np.zeros((4, 25 * 256))
    states[:2] = random.random((2, states.shape[1]))
    smooth = (states[0] < 0.5).astype(np.int16)
    mean, boundary = sample_entropy(states, smooth)
    assert mean < 0.1
    assert boundary < math.log(2.0)
    mixed = random.integers(0, 3, size=smooth.size).astype(np.int16)
    assert sample_entropy(states, mixed)[1] > math.log(2.0)


def test_what_was_not_computed_says_nothing():
    labels = np.random.default_rng(5).integers(0, 2, size=(10, 10)).astype(np.int16)
    whole = grid_entropy(labels)
    wider = np.full((10, 15), NOT_COMPUTED, dtype=np.int16)
    wider[:, :10] = labels
    assert grid_entropy(wider) == pytest.approx(whole)


def test_too_few_starts_have_no_boxes():
    assert all(math.isnan(each) for each in grid_entropy(np.zeros((4, 30), dtype=np.int16)))
    states = np.random.default_rng(6).random((4, 10))
    assert all(math.isnan(each) for each in sample_entropy(states, np.zeros(10, dtype=np.int16)))


def test_grids_and_samples_say_it():
    rotor, axis = Rotor(omega=1.7, zeta=0.07, delta0=0.0), np.linspace(-15, 15, 30)
    grid = basin(rotor, x=axis, y=axis)
    expected = grid_entropy(grid.label.transpose("x", "y").values)
    assert (float(grid.basin_entropy), float(grid.boundary_entropy)) == expected
    sample = basin_fractions(rotor, x=(-15, 15), y=(-15, 15), starts=900)
    assert float(sample.basin_entropy) == pytest.approx(expected[0], abs=0.1)
