"""What does not know friction yet refuses it in one line: nothing is computed as if it were 0."""

from __future__ import annotations

from collections.abc import Callable

import pytest

import rotor_ida
from rotor_ida import InputError, Rotor, simulate
from rotor_ida.simulation.dataset import rotor_of

RUBBING = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.3, disc_radius=0.6)
START = (1.0, 0.0, 0.0, 0.0)

UNKNOWN: dict[str, Callable[[Rotor], object]] = {
    "exponents": lambda rotor: rotor_ida.lyapunov_exponent(rotor, start=START),
    "a cycle": lambda rotor: rotor_ida.limit_cycle(rotor, start=START),
    "a branch": lambda rotor: rotor_ida.continue_cycle(rotor, start=START, limits=(1.0, 2.0)),
    "a curve": lambda rotor: rotor_ida.bifurcation_curve(
        rotor,
        start=START,
        kind="fold",
        parameters=("omega", "delta0"),
        limits=((1.0, 2.0), (0.1, 1.0)),
    ),
    "rest": rotor_ida.rest,
}


@pytest.mark.parametrize("what", UNKNOWN)
def test_friction_is_refused_where_it_is_not_known(what: str):
    with pytest.raises(InputError, match=r"^friction must be 0 for .*, which does not know it yet"):
        UNKNOWN[what](RUBBING)


def test_a_run_with_friction_is_kept_verified_and_summed_up(tmp_path):
    run = simulate(RUBBING, start=(0.3, 0.1, 0.2, 0.1), duration=20.0, samples=101)
    path = tmp_path / "run.nc"
    rotor_ida.save(run, path)
    kept = rotor_ida.load(path)
    for name in run.variables:
        assert kept[name].equals(run[name]), name
    assert rotor_of(kept) == RUBBING
    assert {2, -2, 3} <= set(kept.event_kind.values.tolist())
    assert kept.event_kind.attrs["flag_meanings"] == "exit entry roll slip reverse"
    assert rotor_ida.contact_summary(kept).contact_count == kept.contact.size
