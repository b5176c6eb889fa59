"""The figure of every kind of result, of one disc, of a machine in SI units and of a system."""

from itertools import pairwise

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rotor_ida import dimensional
from rotor_ida.plot import figure_of
from rotor_ida.plot.appearance import without_pyplot
from rotor_ida.plot.datasets import is_of_disc
from rotor_ida.results import dataset_kinds
from rotor_ida.results.dataset_kinds import kind_of
from tests.example_datasets import KINDS, MACHINE
from tests.plot.pictures import check_nothing_cut_off

# Results that say something about samples of others, or of no disc with a machine, and without a
# figure.
PLAIN = {"run_without_times", "runs_by_name", "no_limit_cycle"}
# Variants of others.
VARIANTS = {"run_without_contact", "run_in_si_units", "sweep_both_ways"}
NOT_DRAWN = {"comparison", "system_touchdown", "contact_summary"}
DRAWN = [name for name in KINDS if name not in PLAIN | NOT_DRAWN | VARIANTS]
# What is drawn over speeds and clearances without units.
WITHOUT_UNITS = {"atlas", "basin_fractions", "bifurcation_curve"}
# Kinds drawn elsewhere: in other tests of plots, and of signals.
ELSEWHERE = {
    "backward_whirl", "centre_line", "fit", "full_spectrum", "hopf_points", "late_jumps", "orders",
    "response_curve", "signals", "spectrogram",
}  # fmt: skip


def test_every_kind_with_a_figure_is_drawn_here_or_elsewhere():
    kinds = {name: kind_of(KINDS[name]()) for name in [*DRAWN, *NOT_DRAWN]}
    assert not any(dataset_kinds.KINDS[kinds[name]].drawn for name in NOT_DRAWN)
    here = {kinds[name] for name in DRAWN}
    assert here | ELSEWHERE == {name for name, kind in dataset_kinds.KINDS.items() if kind.drawn}


def check_complete(figure):
    """Texts are on the figure and apart, axes are labelled, legends and titles told once."""
    check_nothing_cut_off(figure)
    renderer = FigureCanvasAgg(figure).get_renderer()
    for ax in figure.axes:
        if not ax.axison or ax.get_label() == "<colorbar>":
            continue
        here = ax.get_window_extent().expanded(1.1, 1.1)
        for axis in (ax.xaxis, ax.yaxis):
            labels = [tick.label1 for tick in axis.get_major_ticks()]
            boxes = [label.get_window_extent(renderer) for label in labels
                     if label.get_visible() and label.get_text()]  # fmt: skip
            boxes = [box for box in boxes if here.contains(*box.get_points().mean(axis=0))]
            apart = [one.overlaps(two) for one, two in pairwise(boxes)]
            assert not any(apart), [label.get_text() for label in labels]
    for legend in [*figure.legends, *(ax.get_legend() for ax in figure.axes)]:
        if legend is not None:
            words = [text.get_text() for text in legend.get_texts()]
            assert len(words) == len({*words})
            assert all(words)


@pytest.mark.parametrize("name", DRAWN)
def test_its_figure_is_complete_in_every_unit(name):
    dataset = KINDS[name]()
    shown = [dataset]
    if is_of_disc(dataset) and "length_scale" not in dataset.attrs:
        shown.append(dimensional(dataset, MACHINE))
    for each in shown:
        with without_pyplot():
            figure = figure_of(each)
        assert isinstance(figure, Figure)
        if each is shown[-1]:  # with units the texts are longer
            check_complete(figure)
        units = {part for ax in figure.axes for part in (ax.get_xlabel(), ax.get_ylabel())}
        is_plain = each is dataset and "length_scale" not in each.attrs
        if is_of_disc(each) and name not in WITHOUT_UNITS:
            assert is_plain == (not any("[µm" in label or "[rpm" in label or "[1/s]" in label
                                        or "[m" in label or "[N]" in label or "[s]" in label
                                        for label in units))  # fmt: skip
        assert np.isfinite([ax.dataLim.bounds for ax in figure.axes if ax.has_data()]).any()
