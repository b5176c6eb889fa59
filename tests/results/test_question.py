"""A question comes back from JSON as it was asked, and is answered to the bit."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import rotor_ida
from rotor_ida import InputError, Rotor
from rotor_ida.results.dataset_kinds import kind_of
from rotor_ida.results.question import VERBS, Question, arguments_from
from rotor_ida.verification.comparison_rules import VERIFIED
from rotor_ida.verification.verify import question_of
from tests import example_datasets

SYSTEM = Rotor(omega=2.0, zeta=0.07, delta0=2.0).system()
# what each of them adds to the values that questions hold
ASKED = ("run", "sweep", "basin", "bifurcation_curve", "branch", "system_run", "system_branch",
         "drop_ensemble", "clearance_report")  # fmt: skip


@pytest.mark.parametrize("name", ASKED)
def test_it_comes_back_from_json(name):
    question = question_of(example_datasets.KINDS[name]())
    text = question.text()
    again = Question.of_text(text)
    assert (again.verb, again.text()) == (question.verb, text)
    assert again.arguments.keys() == question.arguments.keys()
    design = json.loads(json.dumps(question.design(), allow_nan=False))
    found = Question.of_design(design)
    assert (found.verb, found.text()) == (question.verb, text)


def test_numbers_keep_all_their_bits():
    given = {
        "x": np.array([0.1 + 0.2, -0.0, 1e-300]),
        "starts": 3,
        "rtol": None,
        "method": "bdf",
        "y": pd.Series([0.5, 2.0]),
    }
    again = Question.of_text(Question("basin", given).text()).arguments
    assert again == {
        "x": (0.1 + 0.2, -0.0, 1e-300),
        "starts": 3,
        "rtol": None,
        "method": "bdf",
        "y": (0.5, 2.0),
    }
    assert np.signbit(again["x"][1])
    assert isinstance(again["starts"], int)


def test_a_stator_of_its_own_stays_apart_from_one_that_is_shared():
    stators = [rotor_ida.Stator(mass=1.0, stiffness=2.0) for _ in range(2)]
    contacts = [
        rotor_ida.Contact(node="disc", clearance=gap, stiffness=4.0, stator=stator)
        for gap, stator in ((0.5, stators[0]), (0.6, stators[1]), (0.7, stators[0]))
    ]
    question = Question("sweep", {"rotor": replace(SYSTEM, contacts=contacts)})
    first, second, third = arguments_from(question.plain())["rotor"].contacts
    assert first.stator is third.stator is not second.stator


@pytest.mark.parametrize("text", ["{", "[1]", '{"rotor": {"type": "Path"}}', '{"x": {"type": "R'])
def test_text_that_holds_no_question_is_refused(text):
    with pytest.raises(InputError, match="a question must be arguments in JSON, got"):
        Question.of_text(text)


def test_no_text_chooses_where_a_study_is_or_its_workers():
    text = '{"verb": "sweep", "study": "somewhere", "workers": 9, "omega": 1.0}'
    assert Question.of_text(text) == Question("sweep", {"omega": 1.0})


@pytest.mark.parametrize("name", example_datasets.KINDS)
def test_a_result_keeps_its_question(name):
    made = example_datasets.KINDS[name]()
    kept = Question.of_result(made)
    if kind_of(made) not in VERIFIED:
        return
    assert kept is not None
    assert kept.verb in VERBS


def test_only_verbs_are_asked():
    with pytest.raises(InputError, match=r"must be one of basin, .*, got 'save'"):
        Question("save", {}).ask()
