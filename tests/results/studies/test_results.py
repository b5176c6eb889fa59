"""Results in a study come back to the last bit; bytes of anything else are refused in one line."""

import numpy as np
import pytest

from rotor_ida import ArchiveError, Rotor
from rotor_ida.basins import following
from rotor_ida.basins.atlas import cells
from rotor_ida.cycles import continue_cycle
from rotor_ida.results.studies import Piece, opened
from rotor_ida.results.studies.arrays import packed
from rotor_ida.results.studies.results import open_results
from rotor_ida.steady import points, run_ups
from rotor_ida.steady.grid import form_of

FORMS = {
    "points of a sweep": form_of("points of a sweep", points.POINT, points.EVENT),
    "run-up": form_of("run-up", run_ups.POINT),
    "labelled batch of starts": following.FORM,
    "stretch of a branch": continue_cycle.FORM,
    "attractors of a rotor": cells.form_of(Rotor(omega=1.7, zeta=0.07, delta0=0.0)),
}


@pytest.mark.parametrize("word", FORMS)
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (packed({}), "it contains no {word}: "),
        (packed({"first": np.array(0), "rotor": np.array([1.0])}), "it contains no {word}: "),
        (b"anything", "it contains no packed arrays: "),
    ],
)
def test_other_bytes_are_refused(word, content, message):
    with pytest.raises(ValueError, match=f"^{message.format(word=word)}"):
        FORMS[word].unpack(content)


def test_a_piece_of_another_kind_is_damage_to_the_study(tmp_path):
    with opened(tmp_path, {"verb": "sweep"}, 1) as study:
        study.keep(Piece(0, 1, 0, "", packed({"first": np.array(0)})))
    with (
        open_results(tmp_path, lambda: {"verb": "sweep"}, 1, FORMS["points of a sweep"]) as kept,
        pytest.raises(ArchiveError, match=r"damaged: pieces/0: it contains no points of a"),
    ):
        list(kept.results())
