"""Whatever a page sends is a question or gets one line; an answer is read as what was packed."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rotor_ida.errors import InputError
from rotor_ida.explorer.messages import Answer, Question, packed, read_question
from rotor_ida.model.rotor import DimensionalRotor, Rotor
from tests.explorer.asking import (
    BEYOND,
    BEYOND_IN_SI,
    HEADER,
    MACHINE,
    OF_SYSTEM,
    ROTOR,
    RUB,
    RUB_IN_SI,
    asked,
    unpacked,
)

NAN = float("nan")
FINITE = "must be a finite real number, got"
LONGEST_MESSAGE = 500

MISTAKES = [
    ({"about": "weather"}, "about must be one of 'motion', 'run_up', 'lines', 'responses'"),
    ({"revolutions": 0}, "revolutions must be at least 1, got 0"),
    ({"revolutions": 2001}, "revolutions must be at most 2000, got 2001"),
    ({"start": [0, 0, 0]}, "start must be four numbers (x, y, vx, vy), got [0, 0, 0]"),
    ({"start": [0, NAN, 0, 0]}, f"start y {FINITE} nan"),
    ({"start": [0, 0, 1.1e6, 0]}, "start vx must lie within 1e+06 of zero, got 1100000.0"),
    ({"speeds": [1, 1]}, "speeds must be two increasing numbers, got (1.0, 1.0)"),
    ({"speeds": [0, 1.1e6]}, "speeds must be at most 1e+06, got 1100000.0"),
    ({"reach": 1e-7}, "reach must lie from 1e-06 to 1000000.0, got 1e-07"),
    ({"machine": ROTOR | {"mass": 1}}, "machine must have omega, zeta and delta0, or mass"),
    ({"machine": ROTOR | {"omega": 1.1e6}}, "omega must be at most 1e+06 to be simulated"),
    ({"machine": ROTOR | {"zeta": True}}, f"zeta {FINITE} True"),
    ({"machine": MACHINE | {"friction": 0.1}}, "disc_radius must be given with friction, got None"),
    ({"machine": MACHINE | {"mass": 1e300}}, "must give scales of frequency, velocity and force"),
    ({"machine": MACHINE | {"clearance": 1e9}}, "delta0 must be at most 1e+06 to be simulated"),
]  # fmt: skip

RAMP = {"about": "run_up", "to": 2.5, "rate": 0.01, "angle": 0.5}
MISTAKES += [
    (RAMP | {"rate": -0.01}, "rate must lead from the speed 2.0 to 2.5, got -0.01"),
    (RAMP | {"to": 2.0}, "rate must lead from the speed 2.0 to 2.0, got 0.01"),
    (RAMP | {"to": None}, f"to {FINITE} None"),
    (RAMP | {"rate": 1e-5}, "a piece of a run-up must have at most 2000 revolutions, got 17904.9"),
    (RAMP | {"machine": ROTOR | {"omega": 1e-4}, "rate": 1e-9}, "at most 2000 revolutions, got"),
]


def message_of(text: str) -> str:
    with pytest.raises(InputError) as caught:
        read_question(text)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    assert len(message) <= LONGEST_MESSAGE
    return message


@pytest.mark.parametrize(("changes", "told"), MISTAKES, ids=lambda value: str(value)[:60])
def test_a_mistake_gets_one_line_that_names_it(changes: dict[str, object], told: str):
    assert told in message_of(json.dumps(asked(**changes)))


@pytest.mark.parametrize(
    ("about", "machine", "told"),
    [("starts", {}, "about must be one of 'motion', 'lines', 'responses', 'campbell'"),
     ("motion", {"contact": -1}, "contact must be at least 0"),
     ("motion", {"speed": -1.0}, "speed must be zero or positive"),
     ("motion", {"changes": {"friction": NAN}}, f"friction {FINITE} nan")],
)  # fmt: skip
def test_a_mistake_about_a_system_gets_one_line_that_names_it(
    about: str, machine: dict[str, object], told: str
):
    whole = {**OF_SYSTEM["machine"], **machine}  # type: ignore[dict-item]
    assert told in message_of(json.dumps(OF_SYSTEM | {"about": about, "machine": whole}))


def test_columns_of_a_file_have_names_that_are_text():
    upload = {
        "about": "upload", "number": 1, "name": "a.csv", "size": 3, "probe_angles": [0, 90],
        "gains": [1, 1], "columns": {}, "units": {},
    }  # fmt: skip
    for each in ("columns", "units"):
        assert message_of(json.dumps(upload | {each: {"x": 7}})) == "x must be text, got 7"
        assert message_of(json.dumps(upload | {each: ["x"]})).startswith("a question must be one")


def test_what_no_page_sends_gets_one_line_and_its_path_is_not_read():
    texts = ["motion", "[" * 4096, "null", "{}", '{"a\\nb\\u2028c": 1}']
    for name in asked():
        given = asked()
        del given[name]
        texts.append(json.dumps(given))
    for text in texts:
        assert message_of(text).startswith("a question must be one of the page, got ")
    assert read_question(json.dumps(asked(path="/etc/passwd"))).path is None


def test_the_limits_themselves_are_allowed():
    largest = {"omega": 1e6, "zeta": 1e6, "delta0": 1e6}
    read = read_question(
        json.dumps(
            asked(
                machine=largest, start=[1e6, -1e6, 1e6, -1e6], revolutions=2000, speeds=[0, 1e6],
                reach=1e6, side=1,
            )
        )
    )  # fmt: skip
    assert read.rotor == Rotor(**largest)
    assert read.speeds == (0.0, 1e6)
    assert read_question(json.dumps(asked(reach=1e-6))).reach == 1e-6


def test_what_a_machine_has_beside_comes_along():
    beyond, in_si = BEYOND | RUB, BEYOND_IN_SI | RUB_IN_SI
    read = read_question(json.dumps(asked(machine=ROTOR | beyond)))
    assert read.rotor == Rotor(**ROTOR, **beyond)
    read = read_question(json.dumps(asked(machine=MACHINE | in_si)))
    assert read.machine == DimensionalRotor(**MACHINE | in_si)
    for name, value in (ROTOR | beyond).items():
        assert getattr(read.rotor, name) == pytest.approx(value, rel=1e-14)


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(), inner, max_size=5),
    max_leaves=20,
)
FIELDS = st.sampled_from(sorted(asked()))
ASKED = st.builds(lambda name, value: asked(**{name: value}), FIELDS, JSON)
MACHINES = st.sampled_from([ROTOR, MACHINE, ROTOR | BEYOND | RUB, MACHINE | BEYOND_IN_SI])
NUMBER = st.floats() | st.integers() | st.floats(0.0, 1e6) | JSON
ANY_MACHINE = MACHINES.flatmap(lambda names: st.fixed_dictionaries(dict.fromkeys(names, NUMBER)))


@given((JSON | ASKED | st.builds(lambda each: asked(machine=each), ANY_MACHINE)).map(json.dumps))
def test_any_text_is_a_question_or_refused(text: str):
    try:
        assert isinstance(read_question(text), Question)
    except InputError:
        message_of(text)


KINDS = st.sampled_from([np.float64, np.float32, np.int8])
ARRAYS = KINDS.flatmap(lambda kind: arrays(kind, st.integers(0, 20)))


@given(st.dictionaries(st.text(), ARRAYS, max_size=5), st.text())
def test_arrays_come_back_bit_for_bit(given_arrays: dict[str, np.ndarray], note: str):
    message = unpacked(packed(Answer("motion", {"note": note}, given_arrays)))
    assert message.header["part"] == "motion"
    assert message.facts == {"note": note}
    assert list(message.arrays) == list(given_arrays)
    for name, values in given_arrays.items():
        assert message.arrays[name].dtype == values.dtype
        assert message.arrays[name].tobytes() == values.tobytes()


@given(st.integers(0, 30), st.integers(0, 9))
def test_every_array_begins_at_a_multiple_of_eight_bytes(length: int, size: int):
    given_arrays = {"a": np.zeros(size, np.int8), "b": np.zeros(3), "c": np.zeros(1, np.float32)}
    message = packed(Answer("x" * length, {}, given_arrays))
    behind = HEADER + int.from_bytes(message[:HEADER], "little")
    places = json.loads(message[HEADER:behind])["arrays"]
    assert [(behind + offset) % 8 for _, offset, _ in places.values()] == [0, 0, 0]


def test_numbers_and_arrays_of_any_layout_are_packed_behind_the_ticket_of_the_question():
    values, ticket = np.arange(12.0).reshape(3, 4), {"about": "motion", "number": 7, "side": 1}
    facts = {"a": np.float64(0.1), "b": np.int8(3), "c": np.bool_(True), "d": np.array([1.0])}
    message = unpacked(packed(Answer("p", facts, {"a": values.T, "b": values[:, ::2]}), ticket))
    assert message.header == {
        "part": "p", **ticket, "facts": {"a": 0.1, "b": 3, "c": True, "d": [1.0]},
    }  # fmt: skip
    assert message.arrays["a"].tolist() == values.T.ravel().tolist()
    assert message.arrays["b"].tolist() == values[:, ::2].ravel().tolist()


def test_what_is_not_finite_is_null_in_the_header_and_itself_in_an_array():
    facts = {"period": math.nan, "list": [math.inf, 1.0], "deep": {"a": (-math.inf,)},
             "of numpy": np.array([1.0, np.nan])}  # fmt: skip
    message = unpacked(packed(Answer("settled", facts, {"a": np.array([math.nan, -math.inf])})))
    assert message.facts == {
        "period": None, "list": [None, 1.0], "deep": {"a": [None]}, "of numpy": [1.0, None],
    }  # fmt: skip
    assert np.isnan(message.arrays["a"][0])
    assert message.arrays["a"][1] == -math.inf
