"""Forces over time, and how their peaks are distributed."""

import numpy as np
import pytest
import xarray as xr

from rotor_ida import Rotor, contact_forces, simulate
from rotor_ida.plot import panels, plot_force_peaks, plot_forces
from rotor_ida.plot.forces import shade_contacts
from tests.plot.pictures import lines_of

REST = (0.0, 0.0, 0.0, 0.0)
BOUNCING = Rotor(omega=2.0, zeta=0.07, delta0=2.0)


def test_forces_and_their_peaks():
    forces = contact_forces(simulate(BOUNCING, start=REST, duration=30.0))
    lines = lines_of(plot_forces(forces))
    line = lines["normal force"]
    at = np.searchsorted(line.get_xdata(), forces.t)
    np.testing.assert_array_equal(line.get_ydata()[at], forces.force)
    assert set(forces.peak_force.values[:-1]) <= set(line.get_ydata())
    step = plot_force_peaks(forces).lines[0]
    assert step.get_ydata()[-1] == 1.0
    none = forces.isel(contact=slice(0, 0))
    texts = [text.get_text() for text in plot_force_peaks(none).texts]
    assert texts == ["fewer than two whole contacts"]


def test_force_of_a_contact_that_the_run_cuts_off_is_a_mark():
    """It is the largest so far, and may exceed all whole contacts."""
    forces = contact_forces(simulate(BOUNCING, start=REST, duration=20.0))
    ax = plot_force_peaks(forces)
    mark = lines_of(ax)["contact cut off by the run: at least"]
    assert mark.get_xdata().tolist() == forces.peak_force[-1:].values.tolist()
    assert mark.get_ydata().tolist() == [1.0]
    assert ax.get_xlim()[1] > mark.get_xdata()[0] > ax.lines[0].get_xdata()[-1]


def test_largest_force_at_the_end_of_a_run_is_no_peak():
    """A run that ends inside a contact while the force grows has not seen its peak."""
    run = simulate(BOUNCING, start=REST, duration=6.0, samples=601)
    rising = contact_forces(run.sel(t=slice(0.0, 2.0)))
    assert rising.peak_time.size
    cut = rising.assign(peak_time=("contact", np.full(rising.sizes["contact"], 2.0)))
    assert "peak of a contact" in lines_of(plot_forces(contact_forces(run)))
    assert "peak of a contact" not in lines_of(plot_forces(cut))


@pytest.mark.parametrize(
    ("entries", "exits", "pale", "full"),
    [  # in a run of 30 s, of which about 0.08 s can be seen
        (np.arange(23.0, 30.0, 0.018), np.arange(23.0, 30.0, 0.018) + 0.003, [(23, 30)], []),
        ([5.0, 9.0], [5.001, 12.0], [], [(5, 5.001), (9, 12)]),
        ([5.0, 6.01, 6.03], [6.0, 6.02, 8.0], [(5, 8)], [(5, 6), (6.03, 8)]),
    ],
)  # fmt: skip
def test_contacts_that_cannot_be_told_apart_are_shaded_as_in_and_out(entries, exits, pale, full):
    run = xr.Dataset(
        {"entry_time": ("contact", entries), "exit_time": ("contact", exits)},
        {"t": np.linspace(0.0, 30.0, 9)},
    )
    ax = panels(1, 1)[1][0]
    shade_contacts(ax, run)
    spans = {
        each.get_label(): [path.get_extents().intervalx for path in each.get_paths()]
        for each in ax.collections
    }
    for words, wanted in (("in and out of contact", pale), ("in contact", full)):
        assert len(spans.get(words, [])) == len(wanted)
        for span, (begin, end) in zip(spans.get(words, []), wanted, strict=True):
            np.testing.assert_allclose(span, (begin, end), atol=0.02 if end == 30 else 1e-9)
