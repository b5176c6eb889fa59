"""The basin that a page draws is the library's, the first look at it included."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import rotor_ida
from rotor_ida.explorer import starts
from rotor_ida.explorer.messages import Question
from rotor_ida.schema import RESPONSE
from tests.explorer.asking import ROTOR, Message, answer_to, question

ASKING = question(
    "starts", machine={"omega": 1.7, "zeta": 0.07, "delta0": 0.5}, start=[0, 0, 1, -1]
)


@pytest.fixture(scope="module")
def pictures() -> list[Message]:
    return answer_to(ASKING)


def test_who_goes_back_to_a_rotor_gets_the_same_pictures_without_a_wait(
    pictures: list[Message], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(starts, "basin", None)
    again = answer_to(ASKING)
    assert [each.facts for each in again] == [each.facts for each in pictures]
    for one, other in zip(again, pictures, strict=True):
        np.testing.assert_array_equal(one.arrays["label"], other.arrays["label"])
    moved = answer_to(question("starts", machine=ASKING.rotor.given, start=[0, 0, 1, -0.5]))
    assert moved[-1].part == "trouble"  # it is computed anew, which fails here


def test_an_interrupted_picture_is_not_kept(monkeypatch: pytest.MonkeyPatch):
    asking = question("starts", machine=ASKING.rotor.given | {"delta0": 0.25})
    whole = starts.basin

    def interrupted(*given: object, **options: object) -> xr.Dataset:
        return whole(*given, **options).assign_attrs(interrupted=1)

    monkeypatch.setattr(starts, "basin", interrupted)
    shown = starts.show_starts(asking)
    assert next(shown).facts["attractors"]
    with pytest.raises(KeyboardInterrupt):
        next(shown)
    monkeypatch.undo()
    finest = answer_to(asking)[-1]
    assert finest.facts["finest"]
    assert finest.facts["undecided"] == 0.0


def library_basin(asking: Question, count: int, rtol: float | None) -> xr.Dataset:
    axis = asking.reach * ((2.0 * np.arange(count) + 1.0) / count - 1.0)
    _, _, vx, vy = asking.start
    found = rotor_ida.basin(
        asking.rotor, x=axis, y=axis, vx=vx, vy=vy, rtol=rtol, workers=1, executor="serial"
    )
    return found.transpose("x", "y", ...)  # the order of the page


def labels_of(picture: Message) -> np.ndarray:
    count = picture.facts["count"]
    return picture.arrays["label"].reshape(count, count)


def test_pictures_become_finer_and_fractions_are_those_of_the_labels(pictures: list[Message]):
    counts = [each.facts["count"] for each in pictures]
    assert counts == sorted(counts)
    assert [each.facts["finest"] for each in pictures] == [*[False] * (len(pictures) - 1), True]
    for picture in pictures:
        assert picture.part == "basin"
        labels = picture.arrays["label"]
        for number, told in enumerate(picture.facts["attractors"]):
            assert told["fraction"] == np.mean(labels == number)
        assert picture.facts["undecided"] == np.mean(labels < 0)
    coarse = library_basin(ASKING, pictures[-2].facts["count"], starts.RTOL)
    np.testing.assert_array_equal(labels_of(pictures[-2]), coarse["label"].values)


def test_the_finest_picture_is_the_library_s_basin_bit_for_bit(pictures: list[Message]):
    finest = pictures[-1]
    found = library_basin(ASKING, finest.facts["count"], None)
    np.testing.assert_array_equal(labels_of(finest), found["label"].values)
    assert len(finest.facts["attractors"]) == found.sizes["attractor"]
    for told, number in zip(finest.facts["attractors"], found["attractor"].values, strict=True):
        assert RESPONSE[told["kind"]] == int(found["kind"][number])
        for name in ("amplitude", "radius_min", "radius_max", "fraction"):
            assert told[name] == float(found[name][number])


def test_what_the_first_look_decides_stays_so(pictures: list[Message]):
    first = pictures[0]
    found = library_basin(ASKING, first.facts["count"], None)
    decided = labels_of(first) >= 0
    assert decided.mean() == pytest.approx(1.0 - first.facts["undecided"])
    assert decided.any()
    for number, told in enumerate(first.facts["attractors"]):
        same = np.flatnonzero(np.isclose(found["amplitude"].values, told["amplitude"], rtol=1e-3))
        assert np.isin(found["label"].values[labels_of(first) == number], same).all()


@pytest.mark.parametrize("changes", [{"zeta": 0.0}, {"zeta": 1e6}, {"omega": 1e6}, {"omega": 1e-6}])
def test_a_rotor_without_a_basin_is_refused_in_one_line(changes: dict[str, float]):
    *_, trouble = answer_to(question("starts", machine=ROTOR | changes))
    assert trouble.part == "trouble"
    (line,) = trouble.facts["message"].splitlines()
    assert line.startswith(tuple(changes))


@pytest.mark.parametrize(
    "changes",
    [
        {"machine": ROTOR | {"delta0": 0.0}},
        {"machine": {"omega": 0.0, "zeta": 0.3, "delta0": 1.0}},
        {"machine": {"omega": 1.7, "zeta": 0.5, "delta0": 0.0}, "start": [0, 0, 20, 20]},
    ],
    ids=str,
)
def test_odd_planes_have_a_basin_or_one_reason(changes: dict[str, object]):
    *_, last = answer_to(question("starts", **changes))
    if last.part == "trouble":
        (line,) = last.facts["message"].splitlines()
        assert line
    else:
        assert last.facts["finest"]


MACHINES = {
    "a machine": ROTOR | {"shaft_stiffness": 0.25, "contact_exponent": 1.0, "contact_damping": 0.5},
    "a load": {"omega": 1.0, "zeta": 0.1, "delta0": 3.0, "shaft_stiffness": 0.25, "load": 0.2},
}


@pytest.mark.parametrize("name", MACHINES)
def test_the_basin_of_a_machine_is_the_library_s_and_coarser_with_load_or_friction(
    name: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(starts, "COARSE", 24)
    monkeypatch.setattr(starts, "FINE", 24)
    asking, is_plain = question("starts", machine=MACHINES[name]), name == "a machine"
    coarse = answer_to(asking, 2)[is_plain]
    count = coarse.facts["count"]
    assert (count, coarse.facts["finest"]) == (24 if is_plain else 12, False)
    found = library_basin(asking, count, starts.RTOL)
    np.testing.assert_array_equal(coarse.arrays["label"], found["label"].values.ravel())
    fractions = [each["fraction"] for each in coarse.facts["attractors"]]
    assert sum(fractions) + coarse.facts["undecided"] == pytest.approx(1.0, abs=1e-12)
