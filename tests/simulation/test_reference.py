"""The plain-Python reference: it moves by DESIGN's equation, and agrees with the core."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.lib.recfunctions import structured_to_unstructured

from rotor_ida import Rotor, SimulationError, simulate
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run
from tests.test_reference_events import CASES
from tests.test_reference_events import reference as exact_events

integration = pytest.importorskip(
    "rotor_ida.simulation.witness.integration", reason="scikit-sundae is not installed"
)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REST = (0.0, 0.0, 0.0, 0.0)


# Three times what was measured, 25 to 27 rtol of t + K.
@pytest.mark.parametrize(
    ("case", "method", "rtol", "allowed"),
    [
        *((case, "adams", 1e-12, 75.0) for case in CASES[::2]),
        # the loop is the same for all; these take three times as long
        *((case, method, 1e-10, 80.0) for method in ("bdf", "ida") for case in CASES[::16]),
    ],
    ids=lambda value: value["name"] if isinstance(value, dict) else None,
)
def test_its_events_are_those_of_the_table(case, method, rtol, allowed):
    if (case.get("shallowest") or np.inf) < 1e2 * rtol:
        pytest.skip("below what this tolerance tells")
    rotor = Rotor(**{name: case[name] for name in ("omega", "zeta", "delta0")})
    found = simulate(
        rotor, start=tuple(case["start"]), duration=case["duration"], samples=2,
        rtol=rtol, atol=1e-2 * rtol, method=method, backend="python",
    )  # fmt: skip
    kinds, times, sensitivity = exact_events(case)
    assert found.starts_in_contact == case["starts_in_contact"]
    assert found.event_kind.values.tolist() == kinds
    error = np.abs(found.event_time.values - times)
    assert (error <= allowed * rtol * (times + sensitivity)).all()
    assert (error <= found.event_time_error.values).all()


@pytest.mark.parametrize("delta0", [0.0, 1.0])
def test_a_solver_that_gives_up_raises_with_time_and_state(monkeypatch, delta0):
    true_solver = integration.CVODE

    class GivesUp:
        def __init__(self, *given, **options):
            self.solver, self.steps = true_solver(*given, **options), 0

        def init_step(self, *given):
            return self.solver.init_step(*given)

        def step(self, *given):
            self.steps += 1
            if self.steps < 20:
                return self.solver.step(*given)
            return SimpleNamespace(success=False, message="corrector failed\n")

    monkeypatch.setattr(integration, "CVODE", GivesUp)
    rotor = Rotor(omega=0.0, zeta=0.0, delta0=delta0)
    with pytest.raises(SimulationError, match=r"corrector failed \(at t = .*, state") as caught:
        simulate(rotor, start=(2.0, 0, 0, 0), duration=1.0, backend="python")
    assert 0.0 < caught.value.time < 1.0
    assert caught.value.state == pytest.approx((2.0, 0.0, 0.0, 0.0), abs=0.5)


@pytest.mark.parametrize(
    ("found", "message"),
    [((0.0, 1.0), "time no longer advances"), ((1.0, np.nan), "the state is no longer finite")],
)
def test_a_solver_that_gets_nowhere_is_given_up(monkeypatch, found, message):
    class Idle:
        def __init__(self, *given, **options):
            pass

        def init_step(self, *given):
            pass

        def step(self, *given):
            return SimpleNamespace(success=True, t=found[0], y=np.full(5, found[1]), nfev=1)

    monkeypatch.setattr(integration, "CVODE", Idle)
    with pytest.raises(SimulationError, match=message):
        run(BOUNCING, REST, 1.0, np.empty(0), Options(backend="python"))


def test_it_can_be_asked_to_stop():
    with pytest.raises(SimulationError, match="interrupted"):
        run(BOUNCING, REST, 1e6, np.empty(0), Options(backend="python"), stop=np.ones(1, np.uint8))


def test_it_labels_contacts_and_extrema_as_the_core_does():
    ways = [Options(rtol=1e-11, backend="python"), Options(method="taylor", rtol=1e-13)]
    times = np.linspace(0.0, 60.0, 61)
    own, core = (run(BOUNCING, REST, 60.0, times, way, extrema=True) for way in ways)
    for rows in ("contacts", "extrema"):
        one, other = (structured_to_unstructured(getattr(each, rows)) for each in (own, core))
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-7)
    np.testing.assert_allclose(own.states, core.states, rtol=0, atol=1e-7)
    np.testing.assert_allclose(own.end, core.end, rtol=0, atol=1e-7)


@pytest.mark.parametrize("method", ["adams", "ida"])
def test_an_event_at_the_end_of_a_run_belongs_to_it(method):
    free = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    touching = simulate(free, start=(0, 0, 0.5, 0), duration=2.0, method=method, backend="python")
    assert touching.event_kind.values.tolist() == [1]
    assert touching.event_time.item() == pytest.approx(2.0, abs=1e-8)
    assert touching.peak_indentation.item() == 0.0


def test_a_rotor_at_rest_on_the_ring_stays_there():
    free = Rotor(omega=0.0, zeta=0.0, delta0=1.0)
    assert simulate(free, start=(1, 0, 0, 0), duration=9.0, backend="python").sizes["event"] == 0
