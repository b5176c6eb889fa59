"""Where branches end: at a doubling, a Hopf point, a graze, or as the period grows for ever."""

import math

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    SimulationError,
    bifurcation_curve,
    continue_cycle,
    hopf_points,
    limit_cycle,
    synchronous_response,
)
from rotor_ida.closed_forms import eigenvalues
from rotor_ida.cycles import branch as branch_module
from rotor_ida.model.equations import rotating_jacobian
from rotor_ida.schema import SPECIAL
from tests.cycles.known import specials, state_of

# Rotors whose whirl turns into a cycle at a Hopf point.
RUB = Rotor(omega=1.2, zeta=0.07, delta0=0.5, friction=0.1, disc_radius=10.0)
DAMPED = {"zeta": 0.07, "delta0": 0.5, "contact_damping": 0.5}


@pytest.fixture(scope="module")
def doubled():
    """Cycles of twice the period of others, inside the narrow window about omega 1.38."""
    rotor = Rotor(omega=1.38, zeta=0.07, delta0=1.0, contact_damping=0.0058)
    return limit_cycle(rotor, start=(1.5, -0.25, 0.0, 0.0))


@pytest.mark.parametrize("begin", [0.00581, 0.0059])
def test_doubled_cycles_come_back_to_the_branch_that_they_left_from_wherever(doubled, begin):
    """Two curves cross there, and beside the crossing rounding may let no step be taken."""
    near = Rotor(omega=1.38, zeta=0.07, delta0=1.0, contact_damping=begin)
    cycle = limit_cycle(near, start=state_of(doubled), period=doubled.period.item())
    branch = continue_cycle(
        near, start=cycle, parameter="contact_damping", limits=(0.005, 0.008), direction="forward"
    )
    assert branch.attrs["last_end"] == "halved"
    assert branch.special_kind.values.tolist() == [SPECIAL["period_doubling"]]
    end = branch.isel(special=-1)
    assert float(end.special_value) == pytest.approx(0.00646003608, abs=1e-10)
    assert float(branch.period[0] / branch.period[-1]) == pytest.approx(2.0, abs=1e-3)
    # a cycle of half the period there has the multiplier -1
    there = Rotor(omega=1.38, zeta=0.07, delta0=1.0, contact_damping=float(end.special_value))
    half = limit_cycle(there, start=state_of(end, "special_"), period=float(end.special_period))
    assert np.abs(half.multiplier_real.values + 1.0).min() < 1e-7


@pytest.fixture(scope="module")
def born():
    """A rotor, its Hopf point, and a cycle just born on the eigenvector of the crossing pair."""
    found = hopf_points(**DAMPED)
    omega, frequency = (float(found[f"hopf_{each}"].max()) for each in ("omega", "frequency"))
    speed = omega + 4e-4
    whirls = synchronous_response(omega=speed, **DAMPED)
    place = int(np.nanargmin(np.abs(whirls.amplitude.values - float(found.hopf_amplitude.max()))))
    amplitude, lag = (whirls[each].values.ravel()[place] for each in ("amplitude", "phase_lag"))
    z = amplitude * np.exp(-1j * lag)
    whirl = np.array([z.real, z.imag, *((1j * speed * z).real, (1j * speed * z).imag)])
    rotor = Rotor(omega=speed, **DAMPED)
    values, vectors = np.linalg.eig(rotating_jacobian(whirl, rotor))
    aside = vectors[:, int(np.abs(values - 1j * frequency).argmin())].real
    start = whirl + 0.02 * np.linalg.norm(whirl) * aside / np.linalg.norm(aside)
    return rotor, found, limit_cycle(rotor, start=start, period=2.0 * math.pi / frequency)


@pytest.mark.parametrize(
    ("parameter", "direction"),
    [("omega", "backward"), ("friction", "backward")],
)
def test_a_branch_begins_at_the_hopf_point_of_a_whirl(parameter, direction):
    """To rounding, as the closed form has it; with the amplitude and the period there."""
    limits = {"omega": (1.0, 1.3), "friction": (0.0, 0.11)}[parameter]
    branch = continue_cycle(
        RUB, start=(3.0, 1.0, 0.0, 0.0), parameter=parameter, limits=limits, direction=direction
    )
    assert "hopf" in {branch.attrs["first_end"], branch.attrs["last_end"]}
    place = specials(branch, "hopf").isel(special=0)
    here = {"zeta": 0.07, "friction": 0.1, "omega": 1.2} | {parameter: float(place.special_value)}
    points = hopf_points(zeta=here["zeta"], delta0=0.5, friction=here["friction"])
    points = points.isel(zeta=0, delta0=0)
    nearest = int(np.nanargmin(np.abs(points.hopf_omega.values - here["omega"])))
    known = points.isel(hopf=nearest)
    assert known.hopf_omega == pytest.approx(here["omega"], rel=1e-11)
    middle = 0.5 * (place.special_radius_min + place.special_radius_max)
    assert middle == pytest.approx(known.hopf_amplitude.item(), rel=1e-11)
    assert place.special_period == pytest.approx(
        2.0 * np.pi / known.hopf_frequency.item(), rel=1e-11
    )
    # and the cycles born there are followed from it
    again = continue_cycle(RUB, start=place, parameter=parameter, limits=limits, points=4)
    assert "hopf" in {again.attrs["first_end"], again.attrs["last_end"]}
    assert specials(again, "hopf").special_value.item() == pytest.approx(
        place.special_value.item(), rel=1e-11
    )


def test_a_branch_that_contact_damping_brings_begins_at_its_hopf_point(born):
    """There its swing vanishes, and beyond it would come back along itself."""
    rotor, known, cycle = born
    branch = continue_cycle(
        rotor, start=cycle, limits=(0.99 * rotor.omega, 1.01 * rotor.omega), direction="backward"
    )
    assert branch.attrs["first_end"] == "hopf"
    assert branch.special_kind.values.tolist() == [SPECIAL["hopf"]]
    assert branch.special_value.item() == pytest.approx(known.hopf_omega.item(), rel=1e-11)
    swing = (branch.radius_max - branch.radius_min).values
    assert (np.diff(swing) > 0.0).all()
    assert swing[0] < 1e-6 * branch.radius_max.values[0]


def test_a_branch_ends_where_its_period_grows_without_bound(born):
    """It comes to a saddle whirl, whose closed form tells how neighbours part, and how it nears.

    A homoclinic orbit [Shilnikov]: the speed comes to its last value as exp(-s T), and the largest
    multiplier grows as exp((u - s) T), with u and -s the eigenvalues of the whirl nearest 0.
    """
    rotor, _, cycle = born
    branch = continue_cycle(
        rotor, start=cycle, limits=(0.5 * rotor.omega, 2.0 * rotor.omega), direction="forward"
    )
    assert branch.attrs["last_end"] == "too_unstable"
    reason = "neighbouring orbits separate by a factor of 1e+07 in a period of"
    assert reason in branch.attrs["last_reason"]
    last = branch.isel(point=slice(-60, None, 20))
    whirls = synchronous_response(omega=float(last.omega[-1]), **DAMPED).amplitude.values.ravel()
    saddle = float(whirls[np.nanargmin(np.abs(whirls - float(last.radius_max[-1])))])
    assert float(last.radius_max[-1]) == pytest.approx(saddle, rel=1e-3)
    rates = eigenvalues(saddle, omega=float(last.omega[-1]), **DAMPED)
    parting, nearing = (rates[rates.imag == 0.0].real[k] for k in (0, 1))
    assert parting > 0.0 > nearing
    largest = np.abs(last.multiplier_real.values).max(axis=-1)
    periods = last.period.values
    grows = np.log(largest[-1] / largest[-2]) / (periods[-1] - periods[-2])
    assert grows == pytest.approx(parting + nearing, rel=0.05)
    apart = np.diff(last.omega.values)
    falls = np.log(apart[-1] / apart[-2]) / (periods[-1] - periods[-2])
    assert falls == pytest.approx(nearing, rel=0.05)


def test_a_curve_that_ends_at_the_graze_of_a_linear_contact_says_so():
    """There stiffness begins at once: M changes like a root, and the curve of folds has a corner.

    On the cycle that it ends at, an extremum of the radius lies at the ring.
    """
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=1.0, contact_exponent=1.0)
    curve = bifurcation_curve(
        rotor, start=(0, 0, 0, 0), kind="fold", parameters=("omega", "delta0"),
        limits=((1.9, 3.2), (0.8, 1.1)),
    )  # fmt: skip
    assert curve.attrs["first_end"] == "step_too_small"
    assert "a graze of a linear contact the curve has a corner" in curve.attrs["first_reason"]
    last = curve.isel(point=0)
    there = Rotor(
        omega=float(last.omega), zeta=0.07, delta0=float(last.delta0), contact_exponent=1.0
    )
    cycle = limit_cycle(there, start=state_of(last), period=float(last.period))
    radius = np.hypot(cycle.x.values, cycle.y.values)
    turns = radius[1:-1][np.diff(np.sign(np.diff(radius))) != 0]
    assert np.abs(turns - there.delta0).min() < 1e-4


def test_a_branch_that_ends_keeps_the_reason(monkeypatch):
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    true_step = branch_module.Curve.step

    def stuck(self, last, length, earlier=()):
        if last.unknowns[5] > 2.05:
            raise SimulationError("no step can be taken: the curve bends too much")
        return true_step(self, last, length, earlier)

    monkeypatch.setattr(branch_module.Curve, "step", stuck)
    branch = continue_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), limits=(1.9, 2.2))
    assert (branch.attrs["first_end"], branch.attrs["last_end"]) == ("limits", "step_too_small")
    assert branch.attrs["first_reason"] == ""
    assert branch.attrs["last_reason"] == "no step can be taken: the curve bends too much"


def test_limits_are_told_only_where_they_are_reached(monkeypatch):
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)

    def lost(self, last, point, place, value):
        raise SimulationError("Newton's method does not converge to the curve")

    monkeypatch.setattr(branch_module.Curve, "crossing", lost)
    branch = continue_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), limits=(1.9, 2.2))
    assert branch.attrs["last_end"] == "step_too_small"
    assert "does not converge" in branch.attrs["last_reason"]
