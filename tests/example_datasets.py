"""Small datasets: one of every kind that goes into an archive, and one with all it can hold."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps

import numpy as np
import xarray as xr

import rotor_ida
from rotor_ida import DimensionalRotor, Rotor
from rotor_ida.schema import labelled

CENTRED = Rotor(omega=1.7, zeta=0.07, delta0=0.0)
HELD = Rotor(omega=0.7, zeta=0.1, delta0=1.5, shaft_stiffness=0.1)
REST = (0.0, 0.0, 0.0, 0.0)
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=600.0
)


def computed_once(build: Callable[..., xr.Dataset]) -> Callable[..., xr.Dataset]:
    """Return what computes a dataset once, and gives a copy of it each time."""
    kept = cache(build)
    return wraps(build)(lambda *given, **named: kept(*given, **named).copy(deep=True))


@computed_once
def a_run(delta0: float = 2.0) -> xr.Dataset:
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=delta0)
    return rotor_ida.simulate(rotor, start=REST, duration=20.0, samples=41)


def a_run_with_more() -> xr.Dataset:
    """Return a run of a rotor with all that the paper's does not have."""
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0, shaft_stiffness=0.25, contact_exponent=1.0,
                  contact_damping=0.5, load=0.125)  # fmt: skip
    return rotor_ida.simulate(rotor, start=REST, duration=20.0, samples=41)


@computed_once
def a_system_run() -> xr.Dataset:
    """Return a run-up of a rotor system with all that may stand around it."""
    system = rotor_ida.RotorSystem(
        mass=np.eye(4), stiffness=2.0 * np.eye(4), damping=0.1 * np.eye(4),
        nodes={"disc": (0, 1), "end": (2, 3)},
    )  # fmt: skip
    stator = rotor_ida.Stator(mass=1.0, stiffness=2.0)
    race = rotor_ida.Race(radius=1.0, inertia=2.0)
    touch = {"node": "disc", "stiffness": 4.0, "friction": 0.1, "radius": 1.0}
    contacts = [
        rotor_ida.Contact(**touch, clearance=0.5, stator=stator),
        rotor_ida.Contact(**touch, clearance=0.7, stator="end", race=race),
    ]
    unbalance = [rotor_ida.Unbalance(node="disc", moment=1.0)]
    return rotor_ida.run_up(
        system, contacts=contacts, unbalance=unbalance, speed=1.0, to=1.5, rate=0.05, samples=41
    )


def a_system_of_run_ups() -> xr.Dataset:
    system = Rotor(omega=1.0, zeta=0.1, delta0=2.0, shaft_stiffness=1.0).system()
    return rotor_ida.run_ups(system, speed=0.3, to=1.6, rate=[0.1, 0.3], workers=1)


def a_system_sweep() -> xr.Dataset:
    """Return a sweep of one disc as a system, up and down."""
    system = Rotor(omega=1.0, zeta=0.3, delta0=0.5, shaft_stiffness=0.25).system()
    return rotor_ida.sweep(system, speed=[0.3, 1.2], direction="both")


def a_system_diagram(at: str = "extrema") -> xr.Dataset:
    """Return a bifurcation diagram of one disc as a system."""
    system = Rotor(omega=1.0, zeta=0.3, delta0=0.5, shaft_stiffness=0.25).system()
    return rotor_ida.bifurcation_diagram(system, speed=[0.3, 1.2], at=at, revolutions=4)


@computed_once
def a_system_cycle() -> xr.Dataset:
    """Return a limit cycle of one disc as a system."""
    system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    return rotor_ida.limit_cycle(system, speed=2.0)


@computed_once
def a_system_branch() -> xr.Dataset:
    """Return its branch, with a period doubling."""
    system = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
    return rotor_ida.continue_cycle(system, start=a_system_cycle(), limits=(1.7, 2.1))


def a_system_curve() -> xr.Dataset:
    """Return the curve of that period doubling."""
    system, special = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system(), a_system_branch()
    return rotor_ida.bifurcation_curve(
        system, start=special.isel(special=0), kind="period_doubling",
        limits=[(1.7, 1.9), (1.9, 2.1)],
    )  # fmt: skip


def over_speed(function: str) -> xr.Dataset:
    """Return a result of a rotor system over its speed."""
    system = rotor_ida.RotorSystem(
        mass=np.eye(4), stiffness=2.0 * np.eye(4), damping=0.1 * np.eye(4),
        nodes={"disc": (0, 1), "end": (2, 3)}, positions={"disc": 0.1, "end": 0.2},
    )  # fmt: skip
    stator = rotor_ida.Stator(mass=1.0, stiffness=2.0)
    contacts = [rotor_ida.Contact(node="disc", clearance=0.5, stiffness=4.0, stator=stator)]
    unbalance = [rotor_ida.Unbalance(node="disc", moment=1.0)]
    if function == "campbell":
        return rotor_ida.campbell(system, speed=[0.5, 1.0], contacts=contacts)
    given = {
        "synchronous_response": {"speed": [0.5, 1.0]},
        "special_speeds": {"limits": (0.5, 1.5), "points": 8},
        "clearance_report": {"speed": (2.0, 3.0), "probes": ["end"], "points": 8},
    }[function]
    return getattr(rotor_ida, function)(system, contacts=contacts, unbalance=unbalance, **given)


def given_for_drops() -> dict[str, object]:
    """Return the arguments of a drop with friction, a race and a support that stays."""
    system = rotor_ida.RotorSystem(
        mass=np.eye(4), stiffness=0.1 * np.eye(4), nodes={"disc": (0, 1), "end": (2, 3)}
    )
    touch = rotor_ida.Contact(
        node="disc", clearance=0.5, stiffness=4.0, damping=0.2, friction=0.1, radius=1.0,
        race=rotor_ida.Race(radius=1.0, inertia=2.0),
    )  # fmt: skip
    supports = [rotor_ida.Support(node=node, stiffness=2.0) for node in ("disc", "end")]
    unbalance = [rotor_ida.Unbalance(node="disc", moment=0.01)]
    return {"system": system, "contacts": [touch], "supports": supports, "failing": ["disc"],
            "unbalance": unbalance, "speed": 3.0, "duration": 5.0, "inertia": 5.0}  # fmt: skip


@computed_once
def a_cycle() -> xr.Dataset:
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    return rotor_ida.limit_cycle(rotor, start=(2.6, 0.75, 0.66, -1.65), period=4.5)


@computed_once
def a_branch() -> xr.Dataset:
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    return rotor_ida.continue_cycle(rotor, start=a_cycle(), limits=(1.7, 2.1))


def a_curve() -> xr.Dataset:
    rotor, branch = Rotor(omega=2.0, zeta=0.07, delta0=2.0), a_branch()
    return rotor_ida.bifurcation_curve(
        rotor, start=branch.isel(special=0), kind="period_doubling", limits=[(1.7, 1.9), (1.9, 2.1)]
    )


@computed_once
def an_unbalance_response() -> xr.Dataset:
    """Return the response of a system whose bearing is stiffer along x than along y."""
    stiff = rotor_ida.Bearing(node="end", stiffness=[[3.0, 0.0], [0.0, 1.0]], damping=0.2)
    system = rotor_ida.RotorSystem(
        mass=np.eye(4), stiffness=np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2)), units="1",
        nodes={"disc": (0, 1), "end": (2, 3)}, bearings=[stiff],
        contacts=[rotor_ida.Contact(node="disc", clearance=0.5, stiffness=4.0)],
        unbalance=[rotor_ida.Unbalance(node="disc", moment=1.0)],
    )  # fmt: skip
    return rotor_ida.synchronous_response(system, speed=np.linspace(0.1, 2.5, 25))


@computed_once
def a_sweep(direction: str = "up") -> xr.Dataset:
    return rotor_ida.sweep(omega=[1.2, 1.3], zeta=0.07, delta0=[0.0, 0.5], direction=direction)


KINDS: dict[str, Callable[[], xr.Dataset]] = {
    "run": a_run,
    "run_without_contact": lambda: a_run(delta0=9.0),
    "run_with_more": a_run_with_more,
    "run_without_times": lambda: a_run().drop_vars("t"),
    "system_run": a_system_run,
    "system_sweep": a_system_sweep,
    "system_run_ups": a_system_of_run_ups,
    "system_cycle": a_system_cycle,
    "system_branch": a_system_branch,
    "system_curve": a_system_curve,
    "system_whirls": lambda: over_speed("synchronous_response"),
    "unbalance_response": an_unbalance_response,
    "special_speeds": lambda: over_speed("special_speeds"),
    "campbell": lambda: over_speed("campbell"),
    "clearance_report": lambda: over_speed("clearance_report"),
    "drop": lambda: rotor_ida.drop(
        **given_for_drops(),
        samples=41,
        clearances={"end": 2.0},  # type: ignore[arg-type]
    ),
    "drop_ensemble": lambda: rotor_ida.drop_ensemble(
        **given_for_drops(),
        drops=3,
        friction=(0.1, 0.2),
        workers=1,  # type: ignore[arg-type]
    ),
    "runs_by_name": lambda: xr.concat([a_run(), a_run()], xr.Variable("machine", ["a", "b"])),
    "run_in_si_units": lambda: rotor_ida.dimensional(a_run(), MACHINE),
    "sweep": a_sweep,
    "sweep_both_ways": lambda: a_sweep("both"),
    "run_ups": lambda: rotor_ida.run_ups(
        omega=0.3, to=1.6, rate=[0.1, 0.3], zeta=0.1, delta0=[1.0, 2.0], shaft_stiffness=1.0
    ),
    "comparison": lambda: rotor_ida.compare(a_sweep()),
    "whirls": lambda: rotor_ida.synchronous_response(omega=[1.2, 1.7], zeta=0.07, delta0=0.5),
    "folds": lambda: rotor_ida.folds(zeta=[0.07, 0.1], delta0=0.0),
    "basin": lambda: rotor_ida.basin(CENTRED, x=np.linspace(-5, 5, 4), y=[0.0, 1.0], workers=1),
    "basin_fractions": lambda: rotor_ida.basin_fractions(
        CENTRED, x=(-5, 5), y=(-5, 5), starts=20, workers=1
    ),
    "atlas": lambda: rotor_ida.continue_attractors(
        omega=[1.6, 1.7], zeta=0.07, delta0=0.0, x=(-5, 5), y=(-5, 5), starts=20, workers=1
    ),
    "system_atlas": lambda: rotor_ida.continue_attractors(
        HELD.system(), speed=[0.7, 0.9], node="disc", x=(-3, 3), y=(-3, 3), starts=4, workers=1
    ),
    "system_touchdown": lambda: rotor_ida.touchdown_report(
        HELD.system(), speed=0.7, node="disc", x=(-3, 3), y=(-3, 3), starts=4, shocks=0, workers=1
    ),
    "contact_summary": lambda: rotor_ida.contact_summary(a_run()),
    "rotating": lambda: rotor_ida.rotating(a_run()),
    "contact_forces": lambda: rotor_ida.contact_forces(a_run()),
    "poincare_section": lambda: rotor_ida.poincare_section(CENTRED, start=REST, revolutions=5),
    "system_section": lambda: rotor_ida.poincare_section(
        Rotor(omega=2.0, zeta=0.07, delta0=2.0).system(), speed=2.0, revolutions=5, at="entry"
    ),
    "lyapunov_exponent": lambda: rotor_ida.lyapunov_exponent(
        CENTRED, start=REST, transient=5.0, duration=40.0, batches=4
    ),
    "limit_cycle": a_cycle,
    "limit_cycles": lambda: rotor_ida.limit_cycle(
        Rotor(omega=2.0, zeta=0.07, delta0=2.0), omega=[2.0, 2.1], workers=1
    ),
    "system_cycles": lambda: rotor_ida.limit_cycle(
        Rotor(omega=2.0, zeta=0.07, delta0=2.0).system(), speed=[2.0, 2.1], workers=1
    ),
    "no_limit_cycle": lambda: rotor_ida.limit_cycle(CENTRED, start=REST),
    "branch": a_branch,
    "bifurcation_curve": a_curve,
    "bifurcation_diagram": lambda: rotor_ida.bifurcation_diagram(
        omega=[1.2], zeta=0.2, delta0=0.0, starts=1, extrema_time=20.0
    ),
    "stroboscopic_diagram": lambda: rotor_ida.bifurcation_diagram(
        omega=[1.2], zeta=0.2, delta0=0.0, starts=1, at="revolution", revolutions=4
    ),
    "system_diagram": a_system_diagram,
    "system_stroboscopic_diagram": lambda: a_system_diagram("revolution"),
}
KINDS = {name: computed_once(build) for name, build in KINDS.items()}


def a_dataset(samples: int = 50, seed: int = 0) -> xr.Dataset:
    """Return a dataset with all that an archive can hold: numbers, flags, texts, nothing."""
    motion = np.random.default_rng(seed)
    radius = motion.normal(size=(samples, 2))
    radius[3:5, 1] = [np.nan, -0.0]
    return xr.Dataset(
        {
            "x": ("t", motion.normal(size=samples), {"long_name": "displacement", "units": "1"}),
            "radius_max": (("t", "start"), radius),
            "response": labelled("response", "start", np.array([1, -1], dtype=np.int8)),
            "message": ("start", np.array(["", "gave up at t = 3 — naïvely"])),
            "event_time": labelled("event_time", "event", np.zeros(0)),
            "event_kind": labelled("event_kind", "event", np.zeros(0, dtype=np.int8)),
            "note": ("event", np.zeros(0, dtype="U4")),
            "starts_in_contact": labelled("starts_in_contact", (), np.int8(1)),
            "title_of_run": ((), "one run"),
        },
        coords={
            "t": labelled("t", "t", np.linspace(0, 9, samples)),
            "omega": labelled("omega", (), 1.7),
            "label": ("start", np.array(["rest", "far"])),
        },
        attrs={
            "title": "a run",
            "empty": "",
            "greek": "ω₀ = √(k√D/m)\n",
            "rtol": 1e-10,
            "samples": samples,
            "nothing": np.nan,
            "small": np.int8(-3),
            "start": np.array([0.0, np.inf, -0.0, np.nan]),
            "none_of_them": np.zeros(0, dtype=np.int16),
        },
    )
