"""Basin fractions of random starts: repeatable, with an error that is the spread of repetitions."""

import numpy as np
import pytest

from rotor_ida import Rotor, basin_fractions
from rotor_ida.schema import RESPONSE
from rotor_ida.steady import grid

FIGURE_7 = Rotor(omega=1.7, zeta=0.07, delta0=0.0)


def test_the_seed_decides():
    arguments = {"x": (-15, 15), "y": (-15, 15), "starts": 300}
    one = basin_fractions(FIGURE_7, **arguments, seed=1)
    assert one.identical(basin_fractions(FIGURE_7, **arguments, seed=1))
    assert int(one["count"].sum()) == 300
    assert one.attrs["seed"] == 1
    assert one.attrs["range_x"].tolist() == [-15.0, 15.0]


def test_the_error_is_the_spread_of_repetitions():
    found = [
        basin_fractions(FIGURE_7, x=(-15, 15), y=(-15, 15), starts=400, seed=seed)
        for seed in range(20)
    ]
    spread = np.std([float(each.fraction[0]) for each in found], ddof=1)
    # the standard deviation of twenty is known to a sixth; three times that on either side
    assert 0.5 < spread / float(found[0].fraction_error[0]) < 1.5


def test_kinds_of_response_are_summed():
    found = basin_fractions(
        Rotor(omega=2.0, zeta=0.07, delta0=2.0), x=(-15, 15), y=(-15, 15), starts=400
    )
    by_kind = found.response_fraction
    assert float(by_kind.sum()) == pytest.approx(1.0)
    bouncing = found.fraction.where(found.kind == RESPONSE["bouncing"]).sum()
    assert float(by_kind.sel(response=RESPONSE["bouncing"])) == pytest.approx(float(bouncing))
    assert float(bouncing) > 0.5
    unknown = by_kind.sel(response=RESPONSE["unresolved"])
    assert float(unknown) == pytest.approx(float(found.undecided_fraction))


def test_numbers_stay_fixed():
    found = basin_fractions(FIGURE_7, x=0.0, y=0.0, vx=(-0.1, 0.1), starts=20)
    assert found["count"].values.tolist() == [20, 0]


def test_a_start_has_the_same_label_however_many_are_drawn(monkeypatch):
    """The tolerance too is chosen by the first ones: by some spread over all it would be looser."""
    rotor, box = Rotor(omega=1.695, zeta=0.07, delta0=2.0), dict.fromkeys(("x", "y"), (-15.0, 15.0))
    chosen = []

    def stops(_, jobs, **options):
        chosen.extend(job.labeller.rtol for job in jobs)
        raise KeyboardInterrupt

    monkeypatch.setattr(grid, "run_all", stops)
    for count in (8, 12):
        basin_fractions(rotor, **box, starts=count)
    assert chosen == [1e-11, 1e-11]
