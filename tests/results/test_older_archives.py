"""Archives of an older version, one of each kind of result, are still of use."""

import gzip
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from rotor_ida import InputError, load
from rotor_ida.cli.describe import describe
from rotor_ida.plot.figures import figure_of
from rotor_ida.results.dataset_kinds import KINDS, kind_of
from rotor_ida.verification.comparison_rules import VERIFIED
from rotor_ida.verification.verify import differences, rerun

# written by the version of the folder's name; nothing in them is chaotic
FILES = sorted((Path(__file__).parents[1] / "data" / "f5fdd200").glob("*.nc.gz"))


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name.removesuffix(".nc.gz"))
def test_it_is_loaded_shown_drawn_and_computed_again(file, tmp_path):
    path = tmp_path / "archive.nc"
    path.write_bytes(gzip.decompress(file.read_bytes()))
    archived = load(path)
    kind = KINDS[kind_of(archived)]
    assert describe(archived, most=3)[1]
    if kind.drawn:
        assert figure_of(archived).axes
        plt.close("all")
    # these did not say from what they were computed
    if kind.name in {"drop_ensemble", "section", "touchdown"}:
        with pytest.raises(InputError, match=f"this {kind.name} cannot be verified: it lacks"):
            rerun(archived)
    elif kind.name in VERIFIED:
        found = differences(rerun(archived, workers=1), archived)
        assert found["agrees"], found["trouble"]
