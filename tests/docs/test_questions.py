"""Functions for each rotor: the table in the docs is what the functions do."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import Contact, DimensionalRotor, InputError, Rotor, RotorSystem, Unbalance
from tests.example_datasets import a_branch

PAGE = Path(__file__).parents[2] / "docs" / "questions.md"
KINDS = {"disc": "one disc", "machine": "machine in SI", "system": "rotor system"}
# Functions with a rotor among their arguments that ask nothing of it.
NO_QUESTION = {"dimensional", "save_machine", "concat"}
REST = (0.0, 0.0, 0.0, 0.0)
DISC = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
RUBBING = Rotor(omega=0.63, zeta=0.1, delta0=1.0, friction=0.2, disc_radius=10.0)
LOADED = Rotor(omega=2.0, zeta=0.07, delta0=2.0, load=3.0)
# The scales of the machines below.
LENGTH, RATE, MASS = 1e-6, 500.0, 4.0


def in_si(rotor: Rotor) -> DimensionalRotor:
    """Return a rotor as a machine, with a reference frequency of 500 rad/s."""
    stiffness, force = MASS * RATE**2, MASS * RATE**2 * LENGTH
    return DimensionalRotor(
        mass=MASS, contact_stiffness=stiffness / np.sqrt(LENGTH), eccentricity=LENGTH,
        damping=2.0 * MASS * RATE * rotor.zeta, clearance=LENGTH * rotor.delta0,
        speed=RATE * rotor.omega, load=force * rotor.load, friction=rotor.friction,
        disc_radius=None if rotor.disc_radius is None else LENGTH * rotor.disc_radius,
    )  # fmt: skip


@cache
def two_discs() -> RotorSystem:
    """Return a system of two nodes and two contacts, which no disc is."""
    stiffness = np.kron([[2.0, -1.0], [-1.0, 2.0]], np.eye(2))
    contacts = [Contact(node=name, clearance=clearance, stiffness=3.0, exponent=1.0)
                for name, clearance in (("one", 3.0), ("two", 0.8))]  # fmt: skip
    return RotorSystem(
        mass=np.eye(4), stiffness=stiffness, damping=0.1 * stiffness, contacts=contacts,
        nodes={"one": (0, 1), "two": (2, 3)}, unbalance=[Unbalance(node="one", moment=0.4)],
        units="1",
    )  # fmt: skip


@dataclass(frozen=True)
class Asked:
    """A question: the function, and small valid arguments for each kind of rotor.

    `refused` has for each kind that the function does not take the words of the table and the
    beginning of the message.
    """

    verb: str
    words: str
    disc: dict[str, Any] = field(default_factory=dict)
    machine: dict[str, Any] = field(default_factory=dict)
    system: dict[str, Any] = field(default_factory=dict)
    refused: dict[str, tuple[str, str]] = field(default_factory=dict)
    rotor: Rotor = DISC

    def rotor_of(self, kind: str) -> Rotor | DimensionalRotor | RotorSystem:
        """Return a rotor of a kind."""
        return {"disc": self.rotor, "machine": in_si(self.rotor), "system": two_discs()}[kind]


def of_disc(verb: str, why: str) -> dict[str, tuple[str, str]]:
    """Return the refusal of a rotor system by a function whose rotor must be given."""
    return {"system": (why, f"{verb} takes a Rotor or DimensionalRotor first")}


def of_parameters(why: str) -> dict[str, tuple[str, str]]:
    """Return the same of one whose parameters may be given without a rotor."""
    return {"system": (why, "rotor must be a Rotor, got")}


def doubling() -> xr.Dataset:
    """Return a period doubling on a branch of one disc."""
    return a_branch().isel(special=0)


def fold_of_two_discs() -> xr.Dataset:
    """Return a fold on a branch of two discs."""
    branch = rotor_ida.continue_cycle(two_discs(), speed=1.5, limits=(1.47, 1.52), points=12)
    return branch.isel(special=0)


def signals(kind: str) -> xr.Dataset:
    """Return signals of a run-up."""
    if kind == "system":
        run = rotor_ida.run_up(two_discs(), speed=0.3, to=0.9, rate=0.005, samples=2001)
        return rotor_ida.signals_of(run, node="two")
    if kind == "disc":
        run = rotor_ida.run_up(DISC, to=2.6, rate=0.01, samples=5001)
    else:
        run = rotor_ida.run_up(in_si(DISC), to=1300.0, rate=2500.0, samples=5001)
    return rotor_ida.signals_of(run)


ONE_DISC = "no: a closed form of one disc; "
FEW = {"starts": [REST], "workers": 1}
QUESTIONS = [
    Asked("simulate", "motion from a start", {"duration": 9.0}, {"duration": 0.02},
          {"speed": 1.5, "duration": 9.0}),
    Asked("run_up", "motion while the speed changes", {"to": 2.2, "rate": 0.1},
          {"to": 1100.0, "rate": 25e3}, {"speed": 1.0, "to": 1.2, "rate": 0.1}),
    Asked("run_ups", "many run-ups, and how each ends",
          {"to": 2.2, "rate": [0.1]}, {"to": 1100.0, "rate": [25e3]},
          {"speed": 0.8, "to": 0.9, "rate": [0.1]}),
    Asked("sweep", "settled motion at each speed", {"workers": 1}, {"workers": 1},
          {"speed": [0.9, 1.1]}),
    Asked("bifurcation_diagram", "settled motions: extrema, or states once a revolution",
          {**FEW, "at": "revolution", "revolutions": 3}, FEW,
          {"speed": 1.5, "at": "revolution", "revolutions": 3}),
    Asked("poincare_section", "one motion once a revolution, at events or at peaks",
          {"revolutions": 3}, {"revolutions": 3, "at": "peak"},
          {"speed": 1.5, "revolutions": 3, "at": "entry", "contact": "two"}),
    Asked("lyapunov_exponent", "Lyapunov exponents: is it chaotic?",
          {"transient": 5.0, "duration": 40.0, "batches": 4},
          {"transient": 0.01, "duration": 0.1, "batches": 4},
          {"speed": 1.5, "transient": 5, "revolutions": 80, "batches": 4, "exponents": 1}),
    Asked("limit_cycle", "limit cycle", {}, {}, {"speed": 1.5}),
    Asked("continue_cycle", "branch of limit cycles over a parameter",
          {"limits": (1.98, 2.02), "points": 3}, {"limits": (990.0, 1010.0), "points": 3},
          {"speed": 1.5, "limits": (1.48, 1.52), "points": 3}),
    Asked("bifurcation_curve", "bifurcation of limit cycles over two parameters",
          {"start": doubling, "kind": "period_doubling", "limits": [(1.75, 1.85), (1.95, 2.05)],
           "points": 3},
          {"start": doubling, "kind": "period_doubling", "parameters": ("speed", "clearance"),
           "limits": [(875.0, 925.0), (1.95e-6, 2.05e-6)], "points": 3},
          {"start": fold_of_two_discs, "kind": "fold", "limits": [(1.4, 1.55), (2.9, 3.1)],
           "points": 3}),
    Asked("synchronous_response", "every synchronous whirl; response to unbalance", {}, {},
          {"speed": [0.9, 1.1]}),
    Asked("special_speeds",
          "speeds at which a rotor grows unstable, and whirls fold, oscillate or graze",
          {"limits": (0.5, 2.5), "points": 20}, {"limits": (250.0, 1250.0), "points": 20},
          {"limits": (0.5, 1.5), "points": 20}),
    Asked("folds", "folds of the whirl", refused=of_parameters(
        ONE_DISC + "`special_speeds` finds the folds of a system")),
    Asked("hopf_points", "Hopf points of the whirl", rotor=RUBBING,
          refused=of_parameters(ONE_DISC + "`special_speeds` finds the Hopf points of a system")),
    Asked("backward_whirl", "backward whirl: dry whip and dry whirl", rotor=RUBBING,
          refused=of_disc("backward_whirl", ONE_DISC + "`sweep` finds dry whip as `rolling`")),
    Asked("rest", "equilibrium under a load", rotor=LOADED, refused=of_disc(
        "rest", ONE_DISC + '`simulate(..., start="rest")` begins there')),
    Asked("campbell", "whirl speeds and damping ratios over the speed",
          {"speed": [0.5, 1.0]}, {"speed": [250.0, 500.0]}, {"speed": [0.5, 1.0]}),
    Asked("clearance_report", "unbalance response at close clearances",
          {"speed": (2.0, 3.0), "points": 8, "vibration_limit": 1.0},
          {"speed": (1000.0, 1500.0), "points": 8},
          {"speed": (2.0, 3.0), "points": 8, "vibration_limit": 1.0}),
    Asked("drop", "drop on touchdown bearings",
          {"speed": 2.0, "duration": 5.0}, {"speed": 1000.0, "duration": 0.01},
          {"speed": 2.0, "duration": 5.0}),
    Asked("drop_ensemble", "many drops, with statistics",
          {"speed": 2.0, "duration": 5.0, "drops": 2, "workers": 1},
          {"speed": 1000.0, "duration": 0.01, "drops": 2, "workers": 1},
          {"speed": 2.0, "duration": 5.0, "drops": 2, "workers": 1}),
    Asked("basin", "basins of attraction on a plane of starts",
          {"x": (-1.0, 1.0), "y": [0.0], "workers": 1},
          {"x": (-1e-6, 1e-6), "y": [0.0], "workers": 1},
          {"speed": 1.5, "node": "two", "x": (-1.0, 1.0), "y": [0.0], "workers": 1}),
    Asked("basin_fractions", "fractions of starts that settle on each motion",
          {"x": (-1.0, 1.0), "y": 0.0, "starts": 4, "workers": 1},
          {"x": (-1e-6, 1e-6), "y": 0.0, "starts": 4, "workers": 1},
          {"speed": 1.5, "node": "two", "x": (-1.0, 1.0), "y": 0.0, "starts": 4, "workers": 1}),
    Asked("continue_attractors", "the same fractions over parameters",
          {"x": (-1.0, 1.0), "y": 0.0, "starts": 4, "workers": 1},
          {"x": (-1e-6, 1e-6), "y": 0.0, "starts": 4, "workers": 1},
          {"speed": [1.5, 1.6], "node": "two", "x": (-1.0, 1.0), "starts": 4, "workers": 1}),
    Asked("touchdown_report", "what each settled motion does to the machine",
          {"x": (-1.0, 1.0), "starts": 4, "shocks": 0, "workers": 1},
          {"x": (-1e-6, 1e-6), "starts": 4, "shocks": 0, "workers": 1},
          {"speed": 1.5, "node": "two", "x": (-1.0, 1.0), "starts": 4, "shocks": 0, "workers": 1}),
    Asked("fit", "parameters fitted to signals of probes",
          {"signals": lambda: signals("disc"), "unknown": ["zeta"]},
          {"signals": lambda: signals("machine"), "unknown": ["damping"]},
          {"signals": lambda: signals("system"), "unknown": ["damping"], "start": "rest"}),
    Asked("impact", "rebound from one contact", {"entry_speed": 1.0},
          refused={"machine": ("no: dimensionless only",
                               "rotor must be a Rotor, got DimensionalRotor"),
                   "system": ("no: one contact alone", "rotor must be a Rotor, got RotorSystem")}),
]  # fmt: skip


def row_of(asked: Asked) -> str:
    """Return the row of a question in the table."""
    cells = [asked.refused.get(kind, ("yes", ""))[0] for kind in KINDS]
    return f"| {asked.words} | `{asked.verb}` | {' | '.join(cells)} |"


def test_the_page_has_the_table_of_this_list():
    rows = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    head = f"| question | function | {' | '.join(KINDS.values())} |"
    assert rows == [head, "|---|---|---|---|---|", *map(row_of, QUESTIONS)]


def test_every_function_that_takes_a_rotor_is_in_the_table():
    def takes_rotor(function: Any) -> bool:
        parameters = inspect.signature(function).parameters.values()
        return any(re.search(r"\bRotor\w*|DimensionalRotor", str(each.annotation))
                   for each in parameters)  # fmt: skip

    functions = {name for name in rotor_ida.__all__
                 if inspect.isfunction(function := getattr(rotor_ida, name))
                 and takes_rotor(function)}  # fmt: skip
    assert functions - NO_QUESTION == {each.verb for each in QUESTIONS}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("asked", QUESTIONS, ids=lambda each: each.verb)
def test_each_cell_works_or_is_refused_in_one_line(asked: Asked, kind: str):
    refused = asked.refused.get(kind)
    asking = asked.disc if refused else getattr(asked, kind)
    given = {name: each() if callable(each) else each for name, each in asking.items()}
    verb, rotor = getattr(rotor_ida, asked.verb), asked.rotor_of(kind)
    name = "machine" if "machine" in inspect.signature(verb).parameters else None
    rotors, more = ([], {name: rotor}) if name else ([rotor], {})
    if refused is None:
        assert verb(*rotors, **more, **given).attrs["result_kind"]
        return
    with pytest.raises(InputError, match=re.escape(refused[1])) as told:
        verb(*rotors, **more, **given)
    assert "\n" not in str(told.value)
