"""Whatever is handed to the core returns, or is refused in words: nothing crashes or hangs.

Tests of the core's own arithmetic lie elsewhere; here its arguments are odd.
"""

from __future__ import annotations

import contextlib
import ctypes
import re
import subprocess
import threading
import time
from dataclasses import replace
from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rotor_ida import Rotor, SimulationError
from rotor_ida.basins import kernel
from rotor_ida.core import faults, interface, runs, sundials
from rotor_ida.core.interface import (
    DONE,
    MESSAGES,
    NO_SOLVER,
    NOT_FINITE,
    OUT_OF_STEPS,
    STOPPED,
    RotorStruct,
    RunStruct,
)
from rotor_ida.core.runs import RunRequest
from rotor_ida.core.system_requests import EPISODE, LAW, RACE, TOUCH
from rotor_ida.core.systems import SystemRunStruct
from rotor_ida.errors import BudgetError
from rotor_ida.simulation.options import Options
from rotor_ida.simulation.run import run

ROOT = Path(__file__).parents[2]
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
REST = (0.0, 0.0, 0.0, 0.0)
REFUSALS = (TypeError, ValueError)

odd_numbers = st.one_of(
    st.floats(),
    st.floats(-3.0, 3.0),
    st.sampled_from([0.0, -0.0, 5e-324, -5e-324, 1e-300, 1e300, 1.7e308, -1.7e308, 1e-17, 1e6]),
)
sizes = st.one_of(st.floats(0.0, 4.0), st.sampled_from([0.0, 5e-324, 1e-300, 1e300, 1e6]))
papers = st.builds(Rotor, omega=sizes, zeta=sizes, delta0=sizes)


@st.composite
def machines(draw):
    """Return a machine: contact damping needs clearance."""
    numbers = {name: draw(sizes) for name in ("omega", "zeta", "delta0", "shaft_stiffness", "load")}
    numbers["contact_damping"] = draw(sizes) if numbers["delta0"] else 0.0
    return Rotor(**numbers, contact_exponent=draw(st.sampled_from([1.0, 1.5])))


@contextlib.contextmanager
def stopping_after(seconds, stop):
    """Set a stop flag after a while; and fail where what runs meanwhile goes on for a second."""
    asked = []

    def ask():
        asked.append(time.perf_counter())
        stop[0] = 1

    timer = threading.Timer(seconds, ask)
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
    assert not asked or time.perf_counter() - asked[0] < 1.0


asked = st.fixed_dictionaries(
    {
        "rotor": st.one_of(papers, machines()),
        "start": st.tuples(*[odd_numbers] * 4),
        "duration": st.one_of(st.floats(0.0, 3.0), odd_numbers),
        "rtol": st.one_of(st.sampled_from([1e-4, 1e-9, 1e-15]), odd_numbers),
        "atol": st.one_of(st.just(1e-11), odd_numbers),
    },
    optional={
        "method": st.sampled_from(["taylor", "adams", "bdf"]), "slack": odd_numbers,
        **dict.fromkeys(("exact_flight", "fixed_axes", "events", "extrema"), st.booleans()),
    },
)  # fmt: skip


@settings(max_examples=150)
@given(asked, st.sampled_from([None, None, 0, 3, 30]))
def test_a_run_of_odd_numbers_ends_or_is_refused(given_things, spans):
    """Or its stretching, over some spans."""
    stop = np.zeros(1, np.uint8)
    try:
        with stopping_after(0.1, stop), np.errstate(all="ignore"):
            if spans is not None:
                request = RunRequest(**given_things, stop=stop, bundle=np.eye(4))
                seen = runs.stretch(request, spans)[1]
            else:
                seen = runs.follow_run(RunRequest(**given_things, stop=stop))
    except ValueError:
        return
    assert seen.status == DONE or interface.message_of(seen.status)
    assert len(seen.event_times) == len(seen.event_states) == len(seen.event_kinds)


def tables_of_lanes(number=0.0):
    """Return what the core writes, and what it only reads, of two functions for lanes."""
    states, stop = np.full((4, 3), number), np.ones(1, np.uint8)
    rows = [np.full((3, dtype.itemsize // 8), number).view(dtype)[:, 0]
            for dtype in (kernel.REGION, kernel.CONTACT_FREE, kernel.SECTION)]  # fmt: skip
    regions, free, sections = rows[0], rows[1][0, ...], rows[2]
    labels, times = np.full(3, kernel.NOT_COMPUTED, np.int16), np.zeros(3, np.float32)
    return {
        kernel.follow: (
            {"states": states, "labels": labels, "times": times},
            {"regions": regions, "free": free, "sections": sections, "stop": stop},
        ),
        kernel.measure_returns: (
            {"values": np.empty(3)}, {"states": states, "section": sections[0, ...], "stop": stop}
        ),
    }  # fmt: skip


REST_OF_LANES = {
    kernel.follow: {"duration": 1.0}, kernel.measure_returns: {"times": (0.0, 1.0)},
}  # fmt: skip


@pytest.mark.parametrize("call", REST_OF_LANES)
def test_lanes_refuse_tables_that_the_core_would_read_or_write_wrongly(call):
    """Of another type, of another shape or length, with gaps, or not to be written."""
    written, read = tables_of_lanes()[call]
    given = {"rotor": BOUNCING, "tolerance": 1e-6, **REST_OF_LANES[call], **written, **read}
    call(**given)
    for name, right in (written | read).items():
        odd = [np.zeros(right.shape, np.uint32), right[np.newaxis],
               np.zeros((*right.shape, 2), right.dtype)]  # fmt: skip
        if name not in ("regions", "sections") and right.ndim:
            odd.append(right[..., 1:].copy())
        if right.size > 1:
            odd.append(np.repeat(right, 2, axis=-1)[..., ::2])
        if name in written:
            odd.append(right.copy())
            odd[-1].flags.writeable = False
        for each in odd:
            with pytest.raises(REFUSALS):
                call(**given | {name: each})


@settings(max_examples=50)
@given(papers, *[odd_numbers] * 3)
def test_lanes_of_odd_numbers_end(rotor, number, duration, tolerance):
    for call, (written, read) in tables_of_lanes(number).items():
        more = {"duration": duration} if call is kernel.follow else {"times": (0.0, duration)}
        read["stop"][0] = 0
        with stopping_after(0.1, read["stop"]):
            call(rotor=rotor, tolerance=tolerance, **more, **written, **read)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"duration": np.inf}, "durations and tolerances must be finite numbers"),
        ({"rtol": np.nan}, "durations and tolerances must be finite numbers"),
        ({"rtol": 0.0}, "rtol and atol must be positive, got 0.0 and 1e-11"),
        ({"atol": -1.0}, "rtol and atol must be positive, got 1e-09 and -1.0"),
        ({"bundle": np.zeros((5, 4))}, "a bundle must have 4 or 7 rows of 4, got"),
        ({"bundle": np.zeros((7, 4)), "method": "adams"}, "must be carried by taylor, got 'adams'"),
        ({"bundle": np.zeros((4, 4), np.float32)}, "takes an array of float64, got float32"),
        ({"bundle": np.zeros((8, 4))[::2]}, "the core takes a contiguous array"),
        ({"stop": np.zeros(1)}, "takes an array of uint8, got float64"),
    ],
)
def test_what_is_wrong_is_said(wrong, message):
    right = {"rotor": BOUNCING, "start": REST, "duration": 1.0, "rtol": 1e-9, "atol": 1e-11}
    with pytest.raises(REFUSALS, match=message):
        runs.follow_run(RunRequest(**{**right, **wrong}))


def test_labels_that_no_16_bits_hold_are_refused():
    regions, sections = np.zeros(30_000, kernel.REGION), np.zeros(2767, kernel.SECTION)
    tables = np.zeros((4, 1)), np.zeros(1, np.int16), np.zeros(1, np.float32)
    known = regions, np.zeros((), kernel.CONTACT_FREE), sections
    with pytest.raises(ValueError, match="must be at most 32767, got 32768"):
        kernel.follow(*tables, BOUNCING, *known, 1.0, 1e-6, np.zeros(1, np.uint8))


@pytest.mark.parametrize("method", ["taylor", "adams"])
@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0, np.nan), (np.inf, 0.0, 0.0, 0.0)])
def test_a_start_that_is_not_finite_ends_the_run_at_once(start, method):
    """A caller meets it as a run that cannot be followed: loaded numbers may be NaN."""
    asked = RunRequest(
        rotor=BOUNCING, start=start, duration=1.0, rtol=1e-9, atol=1e-11, method=method, events=True
    )
    seen = runs.follow_run(asked)
    assert (seen.status, seen.time, seen.event_times.size) == (NOT_FINITE, 0.0, 0)


def test_a_bundle_that_must_not_be_written_is_refused():
    bundle = np.eye(4)
    bundle.flags.writeable = False
    asked = RunRequest(
        rotor=BOUNCING, start=REST, duration=1.0, rtol=1e-9, atol=1e-11, bundle=bundle
    )
    for call in (lambda: runs.follow_run(asked), lambda: runs.stretch(asked, 2)):
        with pytest.raises(ValueError, match="must be able to write into this array"):
            call()


def test_stretching_needs_a_bundle():
    asked = RunRequest(rotor=BOUNCING, start=REST, duration=1.0, rtol=1e-9, atol=1e-11)
    with pytest.raises(ValueError, match="a stretching must have a bundle"):
        runs.stretch(asked, 2)


# ---- A stop flag ends all that may last ----

LONG = {
    "a run by Taylor series": {"duration": 1e9, "rtol": 1e-12, "atol": 1e-14},
    "a run by CVODE": {"duration": 1e9, "rtol": 1e-9, "atol": 1e-11, "method": "adams"},
    "with differences": {"duration": 1e9, "rtol": 1e-12, "atol": 1e-14, "bundle": np.zeros((7, 4))},
    "with extrema": {"duration": 1e9, "rtol": 1e-12, "atol": 1e-14, "extrema": True},
    "a flight of many turns": {
        "rotor": Rotor(omega=1.7, zeta=0.0, delta0=3.0),
        "start": (-0.8, 0.0, 0.0, -1.7),
        "duration": 1e12,
        "rtol": 1e-9,
        "atol": 1e-11,
        "extrema": True,
    },
}


@pytest.mark.parametrize("name", LONG)
def test_a_long_run_stops_within_a_second(name):
    """Set by another thread: so the interpreter is free while the core works."""
    stop = np.zeros(1, np.uint8)
    with stopping_after(0.1, stop):
        asked = {"rotor": BOUNCING, "start": REST, "stop": stop, **LONG[name]}
        seen = runs.follow_run(RunRequest(**asked))
    assert seen.status == STOPPED


RAMP = np.array([(20.0, 0.05, 0.0, 0.0, 0.0, 1.0)], runs.PIECE)
BUDGETED = {
    **{method: {"method": method} for method in ("taylor", "adams", "bdf")},
    "integrated flight": {"method": "adams", "exact_flight": False},
    "any rotor": {"whole": True},
    "changing speed": {"pieces": RAMP},
    "without clearance": {"rotor": replace(BOUNCING, delta0=0.0)},
}


@pytest.mark.parametrize("name", BUDGETED)
def test_a_run_ends_where_its_steps_are_spent(name):
    """Exactly as many as it needs change nothing; one less ends it before its end."""
    asked = {"rotor": BOUNCING, "start": REST, "duration": 20.0, "rtol": 1e-8, "atol": 1e-10,
             "events": True, **BUDGETED[name]}  # fmt: skip
    free = runs.follow_run(RunRequest(**asked))
    enough = runs.follow_run(RunRequest(**asked, most_steps=free.steps))
    short = runs.follow_run(RunRequest(**asked, most_steps=free.steps - 1))
    assert free.status == enough.status == DONE
    assert enough.state == free.state
    np.testing.assert_array_equal(enough.event_times, free.event_times)
    assert (short.status, short.steps) == (OUT_OF_STEPS, free.steps)
    assert short.time < 20.0


def test_spent_steps_are_an_error_of_their_own():
    with pytest.raises(BudgetError, match="needs more steps than it may take"):
        run(BOUNCING, REST, 1e9, np.empty(0), Options(method="taylor"), most_steps=1000)


def test_no_extremum_of_a_last_flight_is_lost_where_its_table_is_full():
    """Two a revolution, of a whirl that is off the centre: more than there is room for at first."""
    seen = runs.follow_run(
        RunRequest(
            rotor=Rotor(omega=1.3, zeta=0.0, delta0=5.0), start=(-0.6, 0.3, 0.0, -1.3),
            duration=3000.0, rtol=1e-9, atol=1e-11, extrema=True,
        )
    )  # fmt: skip
    assert seen.status == DONE
    assert abs(len(seen.extrema) - 2.0 * 3000.0 * 1.3 / (2.0 * np.pi)) <= 2.0
    assert seen.extrema["time"][-1] > 2995.0


def test_lanes_stop_within_a_second():
    stop, count = np.zeros(1, np.uint8), 5000
    states = np.random.default_rng(0).normal(size=(4, count))
    labels, times = np.full(count, kernel.NOT_COMPUTED, np.int16), np.zeros(count, np.float32)
    none = np.empty(0, kernel.REGION), kernel.NO_CONTACT_FREE, np.empty(0, kernel.SECTION)
    with stopping_after(0.3, stop):
        kernel.follow(states, labels, times, BOUNCING, *none, 1e9, 1e-9, stop)
    assert (labels == kernel.NOT_COMPUTED).any()
    stop[0] = 0
    section, values = np.ones((), kernel.SECTION), np.empty(count)
    with stopping_after(0.3, stop):
        kernel.measure_returns(states, BOUNCING, section, (0.0, 1e9), 1e-9, values, stop)


# ---- Structures and tables are those of the header ----

SIZES = """
#include <stddef.h>
#include <stdio.h>
#include "system.h"
int main(void)
{
    printf("%zu %zu %zu %zu", sizeof(struct rotor), sizeof(struct run), sizeof(struct sundials),
           sizeof(struct system_run));
    OFFSETS
}
"""


def test_structures_are_those_of_the_header(tmp_path):
    """Their sizes, and the place of each field."""
    if not (ROOT / "hatch_build.py").is_file():
        pytest.skip("an installed package has no sources to compile")
    compiler = run_path(str(ROOT / "hatch_build.py"))["find_compiler"]()
    if compiler is None:
        pytest.skip("no C compiler is installed")
    structures = {
        "rotor": RotorStruct, "run": RunStruct, "sundials": sundials.SundialsStruct,
        "system_run": SystemRunStruct,
    }  # fmt: skip
    fields = [(name, field[0]) for name, each in structures.items() for field in each._fields_]
    offsets = "".join(
        f'printf(" %zu", offsetof(struct {name}, {field}));' for name, field in fields
    )
    source, program = tmp_path / "sizes.c", tmp_path / "sizes"
    source.write_text(SIZES.replace("OFFSETS", offsets))
    core = Path(interface.__file__).parent
    subprocess.run([*compiler, f"-I{core}", str(source), "-o", str(program)], check=True)
    said = subprocess.run([program], capture_output=True, check=True, text=True).stdout.split()
    expected = [ctypes.sizeof(each) for each in structures.values()]
    expected += [getattr(structures[name], field).offset for name, field in fields]
    assert [*map(int, said)] == expected


def test_rows_of_systems_have_no_gaps():
    """Those of ``system_law``, ``system_touch``, ``episode`` and ``race`` are read as they are."""
    sizes = [each.itemsize for each in (LAW, TOUCH, EPISODE, RACE)]
    assert sizes == [12 * 8, 3 * 8 + 4 * 4, 12 * 8, 4 * 8]


def members(enum):
    """Return the names and numbers of an enumeration of ``core.h``, in its order."""
    header = Path(interface.__file__).parent / "core.h"
    if not header.is_file():
        pytest.skip("an installed package has no sources")
    stated = re.search(rf"enum {enum} \{{([^}}]*)\}}", header.read_text("utf-8"))[1]
    found = {}
    stated = re.sub(r"/\*.*?\*/", "", stated, flags=re.DOTALL)  # the comments
    for name, number in re.findall(r"(\w+)(?: = (-?\d+))?,?", stated):
        found[name] = int(number) if number else len(found)
    return found


def test_statuses_are_those_of_the_header():
    for name, number in members("status").items():
        assert getattr(interface, name) == number, name
        with_more_room = {interface.FULL, interface.FULL_INSIDE}  # a run goes on, or begins anew
        assert number in {DONE, *with_more_room} or MESSAGES[number]
    assert interface.message_of(-28) == "the solver gave up with flag -28"


@pytest.mark.parametrize(
    ("status", "file", "limit"),
    [
        (interface.RUNAWAY, "speed_limits.c", "LARGEST_SPEED"),
        (interface.UNBOUNDED, "system_run.c", "MOST_CLEARANCES"),
    ],
)
def test_limits_in_messages_are_those_of_the_sources(status, file, limit):
    source = Path(interface.__file__).parent / file
    if not source.is_file():
        pytest.skip("an installed package has no sources")
    number = re.search(rf"{limit} = ([^;]*);", source.read_text("utf-8"))[1]
    assert f" {float(number):g}" in MESSAGES[status]


def test_faults_methods_and_modes_are_those_of_the_header():
    assert [*members("fault")] == [*faults.MESSAGE_OF_FAULT]
    assert members("method") == {name.upper(): n for name, n in interface.METHODS.items()}
    assert all(getattr(interface, name) == number for name, number in members("where").items())


# ---- Each function of SUNDIALS may fail ----

RUBBING = replace(BOUNCING, friction=0.1, disc_radius=10.0)

FAILING = {
    # those whose result is a pointer: it is null
    **dict.fromkeys(("vector_over", "vector_data", "matrix_new", "linear_new", "create"), 0),
    # those whose result is a flag
    **dict.fromkeys(
        ("context_new", "handlers_clear", "vector_fuse", "init", "reinit", "tolerances",
         "weigh_by", "user_data", "linear_use", "jacobian", "solve", "derivative",
         "evaluations"), -28,
    ),
}  # fmt: skip
NOT_LOOKED_AT = {"context_free", "vector_free", "matrix_free", "linear_free", "free"}
NOT_CALLED = {"last_order", "matrix_data"}  # only where a run asks for it, see below


def failing(name, result):
    """Return the table of functions with one that fails, and what keeps it alive."""
    table = sundials.SundialsStruct.from_buffer_copy(sundials.functions())
    fail = ctypes.CFUNCTYPE(ctypes.c_void_p if result == 0 else ctypes.c_int)(lambda: result)
    setattr(table, name, ctypes.cast(fail, ctypes.c_void_p))
    return table, fail


def test_all_functions_are_made_to_fail():
    assert {*FAILING} | NOT_LOOKED_AT | NOT_CALLED == {*sundials.FUNCTIONS}


@pytest.mark.skipif(bool(sundials.why_not()), reason="SUNDIALS cannot be called")
@pytest.mark.parametrize("name", [*FAILING, *sorted(NOT_CALLED)])
def test_a_function_of_sundials_that_fails_ends_the_run_in_words(monkeypatch, name):
    result = FAILING.get(name, 0 if name == "matrix_data" else -28)
    table, kept = failing(name, result)
    monkeypatch.setattr(sundials, "functions", lambda: table)
    options = Options(method="bdf", flight="cvode")
    rotor = RUBBING if name == "weigh_by" else BOUNCING  # which asks for it
    with pytest.raises(SimulationError) as refused:
        run(rotor, (3.0, 0.5, 0.0, 0.0), 20.0, np.linspace(0.0, 20.0, 4001), options)
    assert kept is not None
    message = refused.value.reason
    assert message in MESSAGES.values() or "the solver gave up with flag -" in message
    assert refused.value.time >= 0.0
    assert np.isfinite(refused.value.state).all()


def test_without_a_solver_there_is_none(monkeypatch):
    asked = RunRequest(
        rotor=BOUNCING, start=REST, duration=1.0, rtol=1e-9, atol=1e-11, method="adams"
    )
    monkeypatch.setattr(runs.sundials, "functions", sundials.SundialsStruct)
    lost = runs._struct_of(asked)
    lost.sundials = None
    assert interface.library().core_run(ctypes.byref(lost)) == NO_SOLVER
