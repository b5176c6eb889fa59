"""Many run-ups of a rotor system over first speed, rate, phase of the unbalance and start."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import xarray as xr

from rotor_ida.arrays import Stop
from rotor_ida.checks import (
    check_between,
    check_distinct,
    check_progress,
    check_real,
    check_vector,
)
from rotor_ida.errors import InputError
from rotor_ida.model.assembly import assemble
from rotor_ida.model.few_modes import in_modes
from rotor_ida.model.rotor_system import RotorSystem, SystemParameters, changed_system
from rotor_ida.model.varied import Varied
from rotor_ida.parallel import Progress, choose, shows_progress
from rotor_ida.results.contact_facts import columns_of_contact, run_up_facts
from rotor_ida.results.provenance import provenance
from rotor_ida.results.question import QUESTION, Question
from rotor_ida.results.studies.results import Folder
from rotor_ida.results.system_units import with_system_units
from rotor_ida.schema import ENDING, labelled
from rotor_ida.simulation.course import SYSTEM_LIMITS, course_of
from rotor_ida.simulation.systems.flow import SettlingProblem, SystemFlow
from rotor_ida.simulation.systems.simulate import LOOSEST_RTOL, TIGHTEST_RTOL, run_of_cases
from rotor_ida.simulation.systems.starts import Start, start_of, state_at_end
from rotor_ida.steady.drop import with_unbalance_at
from rotor_ida.steady.grid import (
    EXPECTED,
    Array,
    Rows,
    Task,
    check_size,
    form_of,
    reason_of,
    run_study,
)
from rotor_ida.steady.members import Member, Members, as_they_are, lost, row_of
from rotor_ida.steady.response import CONTACT_FREE, UNRESOLVED
from rotor_ida.steady.run_up_outcome import RUB, WHIP
from rotor_ida.steady.run_ups import labelled_run_ups
from rotor_ida.steady.system_motion import SettledSystem, settle
from rotor_ida.steady.system_sweep import (
    OF_CONTACT,
    OF_NODE,
    check_slowest,
    checked_starts,
    fill,
    point_of,
)

# What is known of the ramp, by contact.
OF_RAMP = (
    "largest_radius", "largest_radius_speed", "largest_force", "largest_force_speed",
    "first_touch_speed", "last_exit_speed", "first_roll_speed", "contact_time", "total_heat",
    "total_contact_loss",
)  # fmt: skip


@shows_progress
def run_ups_system(
    system: RotorSystem,
    *,
    speed: npt.ArrayLike,
    to: float,
    rate: npt.ArrayLike,
    phase: npt.ArrayLike = 0.0,
    starts: Sequence[Start | xr.Dataset] | xr.Dataset = (None,),
    modes: int | None = None,
    rtol: float = 1e-10,
    workers: int | None = None,
    executor: str = "auto",
    study: Folder | None = None,
    progress: Progress | bool | None = None,
    **changed: Unpack[SystemParameters],
) -> xr.Dataset:
    """Run a rotor system up or down at every rate and phase, and classify the endings.

    Parameters
    ----------
    system : RotorSystem
        The rotor.
    modes, rtol : optional
        As in `simulate`.
    contacts, unbalance, supports, gravity, static_force : optional
        In place of those of the system, as in `simulate`.
    speed : float or array_like, shape (n,)
        Speeds at time 0.
    to : float
        Speed at the end of the ramps, not 0.
    starts : sequence of (q, velocity), "settled", "rest", None or Dataset; or Dataset
        Starts at time 0, as in `sweep`.

    Returns
    -------
    Dataset
        On ``(speed, rate, phase, start)`` the same as of one disc, but that what happens on the
        ramp is on ``contact`` too: ``largest_radius`` from the centre of the stator,
        ``largest_force``, ``first_touch_speed`` and so on; and so are ``amplitude``,
        ``phase_lag``, ``radius_min`` and ``radius_max`` at the last speed. On ``node``:
        ``node_largest_radius`` on the ramp and, at the last speed, ``node_amplitude``,
        ``node_phase_lag``, ``node_radius_min`` and ``node_radius_max``. On ``component``:
        ``final_state`` at the end of the ramp, where the unbalance is at ``end_angle``.
        ``horizon`` is the time up to which the start determines the ramp.

    Notes
    -----
    Each ramp is followed as by `run_up`. A largest radius without contact is that of the samples,
    32 in each revolution. `total_contact_loss` is that of complete contacts. A run-up ends in
    ``whip`` if a contact with friction stays closed and whirls backwards.

    Examples
    --------
    >>> from rotor_ida import Rotor, decode_flags
    >>> system = Rotor(omega=1.0, zeta=0.1, delta0=2.0, shaft_stiffness=1.0).system()
    >>> found = run_ups_system(system, speed=0.3, to=1.6, rate=[0.003, 0.3])
    >>> decode_flags(found.ending).values.ravel().tolist()
    ['rub', 'contact_free']
    >>> found.largest_force.values.ravel().round(3), found.first_touch_speed.values.ravel().round(3)
    (array([11.969,  0.   ]), array([0.848,   nan]))
    """
    system = changed_system(run_ups_system, system, changed)
    progress = check_progress(progress)
    chosen = choose(executor, workers, compiled=True)
    given = {"speed": speed, "rate": rate, "phase": phase}
    axes = {name: check_distinct(name, check_vector(name, each)) for name, each in given.items()}
    begun = checked_starts(starts)
    if modes is not None and any(isinstance(each, xr.Dataset) for each in begun):
        raise InputError(f"starts must be (q, velocity) with modes, got a result and {modes!r}")
    grid = Varied({**axes, "start": np.arange(len(begun))})
    check_size(grid, study)
    case: dict[str, Any] = {
        "system": system, "to": check_real("to", to), "modes": modes,
        "rtol": check_between("rtol", rtol, TIGHTEST_RTOL, LOOSEST_RTOL),
    }  # fmt: skip
    if case["to"] == 0.0:
        raise InputError("to must not be 0 in run-ups of a rotor system, got 0.0")
    for first, change in product(axes["speed"].tolist(), axes["rate"].tolist()):
        course_of(first, {"to": case["to"], "rate": change}, None, SYSTEM_LIMITS)
    problem = SettlingProblem.of(assemble(in_modes(system, modes, begun[0])[0]), case["rtol"])
    check_slowest(problem, np.array([case["to"]]))
    case["starts"] = [state_at_end(problem.assembly, each) for each in begun]
    for each in case["starts"]:
        start_of(problem.assembly, in_modes(system, modes, each)[1], float(axes["speed"][0]))
    question = Question("run_ups", {
        "rotor": system, **axes, "to": case["to"], "starts": case["starts"], "modes": modes,
        "rtol": case["rtol"],
    })  # fmt: skip
    point = _point(problem)
    task = Task(follow_system_run_up, lost, as_they_are, form_of("run-up", "run_ups", point), point)
    columns = run_study(
        Members(case, grid, point), task, question, study=study, workers=chosen, progress=progress
    ).points
    return _dataset(grid, columns, problem, case, question)


def _point(problem: SettlingProblem) -> np.dtype[np.void]:
    """Return the columns of a run-up: those of the settled response, and of the ramp."""
    contacts, nodes = len(problem.assembly.contacts), len(problem.assembly.system.nodes)
    settled = [each for each in point_of(problem).descr if each[0] not in ("touched", *OF_RAMP)]
    return np.dtype([
        *settled, ("ending", np.int8), ("end_angle", np.float64), ("horizon", np.float64),
        *((name, np.float64, (contacts,)) for name in OF_RAMP),
        ("contact_count", np.int64, (contacts,)), ("node_largest_radius", np.float64, (nodes,)),
    ])  # fmt: skip


def follow_system_run_up(job: Member, stop: Stop) -> Rows:
    """Follow a rotor system along its ramp, and on at the last speed until it has settled."""
    at, case, facts = job.varied, job.case, {}
    course = course_of(at["speed"], {"to": case["to"], "rate": at["rate"]}, None, SYSTEM_LIMITS)
    try:
        turned = with_unbalance_at(case["system"], at["phase"])
        system, start = in_modes(turned, case["modes"], case["start"])
        run = run_of_cases(
            [(system, start)], course, samples=None, rtol=case["rtol"], method="taylor",
            progress=None, modes={},
        )  # fmt: skip
        facts = _facts(run, at["phase"])
        settled = _settled(system, run, at["phase"], case, stop)
    except (*EXPECTED, InputError) as error:  # it must not end the others
        return row_of(job, facts, reason_of(error), failed=True)
    return row_of(job, settled[0] | facts, settled[1])


def _facts(run: xr.Dataset, phase: float) -> dict[str, Any]:
    """Return what happens on a ramp."""
    contacts = [
        run_up_facts(columns_of_contact(run, number), float(clearance))
        for number, clearance in enumerate(run["clearance"].values)
    ]
    return {
        **{name: [each[name] for each in contacts] for name in (*OF_RAMP, "contact_count")},
        "node_largest_radius": np.hypot(run["x"].values, run["y"].values).max(axis=0),
        "end_angle": float(run["angle"][-1]) + phase,
        "horizon": float(run["horizon"]),
        "final_state": run["final_state"].values,
    }


def _settled(
    system: RotorSystem, run: xr.Dataset, phase: float, case: Mapping[str, Any], stop: Stop
) -> tuple[dict[str, Any], str]:
    """Return the settled response at the last speed and the ending, with a message.

    The motion goes on with the unbalance ahead by the angle to which the ramp has brought it.
    """
    angle = math.remainder(float(run["angle"][-1]), math.tau)
    problem = SettlingProblem.of(assemble(with_unbalance_at(system, angle)), case["rtol"])
    flow = SystemFlow.at(problem, case["to"], stop)
    size, end = problem.assembly.size, run["final_state"].values
    motion = np.array([problem.found.to_y(each) for each in end[: 2 * size].reshape(2, size)])
    settled = settle(flow, flow.state_of(motion, end[2 * size :]))
    features, turn = settled.features, np.exp(-1j * (angle + phase))
    row = np.zeros(1, point_of(problem))[0]
    whirls = {name: turn * getattr(features, name) for name in ("contact_whirl", "node_whirl")}
    features = replace(features, **whirls)
    fill(row, replace(settled, features=features), flow, settled.state * flow.scales)
    ending = _ending(settled, problem)
    figures: dict[str, Any] = {name: row[name] for name in row.dtype.names or ()}
    message = settled.decision.message if ending == UNRESOLVED else ""
    return figures | {"ending": ENDING[ending]}, message


def _ending(settled: SettledSystem, problem: SettlingProblem) -> str:
    """Return how a run-up ends by the settled response."""
    kind = settled.decision.kind
    if kind == CONTACT_FREE:
        return CONTACT_FREE
    rubs = np.array([each.friction > 0.0 for each in problem.assembly.contacts], bool)
    if (rubs & settled.features.backward).any():
        return WHIP
    return UNRESOLVED if kind == UNRESOLVED else RUB


def _dataset(
    grid: Varied, columns: Mapping[str, Array], problem: SettlingProblem, case: Mapping[str, Any],
    question: Question,
) -> xr.Dataset:  # fmt: skip
    """Return run-ups of a rotor system as a labelled dataset."""
    system, contacts = problem.assembly.system, problem.assembly.contacts
    behind = dict.fromkeys((*OF_CONTACT, *OF_RAMP, "contact_count"), ("contact",))
    behind |= dict.fromkeys((*OF_NODE, "node_largest_radius"), ("node",))
    coordinates = {"to": ((), case["to"]), "node": ("node", np.array(list(system.nodes), str))}
    dataset = labelled_run_ups(
        grid, columns, coordinates, provenance({"method": "taylor", "rtol": case["rtol"]}),
        "Rotor system: run-ups over a range of speeds", kind="system_run_ups",
        behind=behind | {"final_state": ("component",)},
    )  # fmt: skip
    clearances = np.array([each.clearance for each in contacts], float)
    far = dataset["largest_radius"]
    told = {
        "contact_node": ("contact", np.array([each.node for each in contacts], str)),
        "clearance": ("contact", clearances),
        "law_radius": ("contact", np.array([each.radius or math.nan for each in contacts], float)),
        "excursion": (far.dims, far.values / clearances),
    }
    dataset = dataset.assign({name: labelled(name, *each) for name, each in told.items()})
    dataset["to"].attrs["long_name"] = "spin speed at the end of the ramp"
    dataset["largest_radius"].attrs["long_name"] = (
        "largest distance of the contact from the centre of its stator on the ramp"
    )
    return with_system_units(dataset, system).assign_attrs({QUESTION: question.text()})
