"""Atlases and reports of machines: a shaft, a linear contact, contact damping."""

import math

import numpy as np
import pytest

from rotor_ida import (
    InputError,
    Rotor,
    continue_attractors,
    limit_cycle,
    simulate,
    touchdown_report,
)
from rotor_ida.basins.atlas.cells import FORM, CellJob, fill_cell
from rotor_ida.basins.atlas.extents import (
    End,
    extent_of_contact_free,
    extent_of_whirl,
    varied,
)
from rotor_ida.closed_forms import eigenvalues, stability_determinant, synchronous_response
from rotor_ida.closed_forms.contact_free import complex_amplitude
from rotor_ida.plot import plot_attractor_map, plot_attractors
from rotor_ida.schema import RESPONSE, STABILITY

GO_ON = np.zeros(1, np.uint8)
BOX = {"x": (-15, 15), "y": (-15, 15)}
PLAIN = {"omega": 2.0, "zeta": 0.07, "delta0": 2.0}


def of_kind(report, kind):
    """Return the first attractor of a kind."""
    return report.isel(attractor=int(np.flatnonzero(report.kind == RESPONSE[kind])[0]))


def test_an_atlas_over_the_stiffness_of_the_shaft_begins_with_the_papers_rotor():
    kappas = [0.0, 0.1, 0.25, 0.5]
    atlas = continue_attractors(**PLAIN, shaft_stiffness=kappas, **BOX, starts=128)
    assert atlas.fraction.dims == ("omega", "zeta", "delta0", "shaft_stiffness", "attractor")
    line = atlas.squeeze()
    np.testing.assert_allclose(line.fraction.sum("attractor"), 1.0, rtol=1e-12)
    alone = continue_attractors(**PLAIN, **BOX, starts=128).squeeze()
    found = line.isel(shaft_stiffness=0)
    there = np.isfinite(found.fraction.values)
    for name in ("fraction", "amplitude", "radius_max", "period"):
        kept = alone[name].values
        np.testing.assert_array_equal(found[name].values[there], kept[np.isfinite(alone.fraction)])
    # one number for the contact-free whirls throughout, whose amplitude is exact
    exact = np.abs(complex_amplitude(2.0, 0.07, np.array(kappas)))
    np.testing.assert_allclose(line.amplitude.isel(attractor=0), exact, rtol=1e-14)
    # the bouncing cycle ends at a fold between the last two
    bouncing = of_kind(line.isel(shaft_stiffness=1), "bouncing").attractor.item()
    lasts = np.isfinite(line.radius_max.isel(attractor=bouncing).values)
    assert lasts.tolist() == [True, True, True, False]


def test_from_one_law_of_contact_to_the_other_nothing_is_followed():
    atlas = continue_attractors(**PLAIN, contact_exponent=[1.0, 1.5], **BOX, starts=64)
    line = atlas.squeeze()
    shared = np.isfinite(line.fraction.values).all(axis=0)
    kinds = line.kind.values[:, shared]
    family = [RESPONSE["contact_free"], RESPONSE["touching"]]
    assert shared.any()
    assert np.isin(kinds, family).all()


def test_numbers_of_a_machine_are_coordinates_of_its_atlas_and_in_its_study(tmp_path):
    given = PLAIN | {"contact_damping": 0.1}
    asked = {**given, **BOX, "starts": 32, "study": tmp_path / "study"}
    first, again = continue_attractors(**asked), continue_attractors(**asked)
    assert first.contact_damping.item() == 0.1
    assert first.fraction.dims == ("omega", "zeta", "delta0", "attractor")
    np.testing.assert_array_equal(first.radius_max, again.radius_max)
    with pytest.raises(InputError, match="study"):
        continue_attractors(**asked | {"contact_damping": 0.2})


def test_a_cell_keeps_its_machine():
    rotor = Rotor(**PLAIN, shaft_stiffness=0.25, contact_exponent=1.0, contact_damping=0.1)
    cell = fill_cell(CellJob(rotor, np.zeros((4, 1)), 1e-6), GO_ON)
    assert FORM.from_arrays(FORM.as_arrays(cell)).rotor == rotor
    plain = fill_cell(CellJob(Rotor(**PLAIN), np.zeros((4, 1)), 1e-6), GO_ON)
    assert FORM.as_arrays(plain)["rotor"].tolist() == [2.0, 0.07, 2.0]
    assert FORM.from_arrays(FORM.as_arrays(plain)).rotor == Rotor(**PLAIN)


@pytest.mark.parametrize(("omega", "delta0"), [(1.7, 0.5), (1.2, 0.5), (1.7, 0.0)])
def test_a_shaft_of_no_stiffness_has_the_extents_of_none(omega, delta0):
    """Two methods: exact curves, cut at folds, and ever smaller steps along the whirl."""
    plain = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    soft = Rotor(omega=omega, zeta=0.07, delta0=delta0, shaft_stiffness=1e-12)
    whirls = synchronous_response(omega=omega, zeta=0.07, delta0=delta0).squeeze()
    stable = (whirls.stability == STABILITY["stable"]) & (whirls.in_contact == 1)
    for amplitude in whirls.amplitude.values[stable.values].tolist():
        for name in ("omega", "zeta", "delta0"):
            exact, found = (extent_of_whirl(each, amplitude, name) for each in (plain, soft))
            for one, other in zip(exact, found, strict=True):
                assert one.kind == other.kind
                assert other.value == pytest.approx(one.value, rel=1e-7)


def test_contact_damping_ends_a_whirl_where_its_growth_rate_passes_zero():
    given = {"omega": 1.7, "zeta": 0.07, "delta0": 0.5}
    amplitude = 1.1960944557
    rotor = Rotor(**given, contact_damping=0.3)
    low, high = extent_of_whirl(rotor, amplitude, "contact_damping")
    assert (low, high.kind) == (End(0.0, "none"), "hopf")
    rates = eigenvalues(amplitude, **given, contact_damping=high.value)
    assert abs(rates.real.max()) < 1e-11
    assert abs(rates[np.argmax(rates.real)].imag) > 0.1


def test_over_the_stiffness_a_whirl_ends_at_a_fold():
    given = {"omega": 1.7, "zeta": 0.07, "delta0": 0.5, "contact_exponent": 1.5}
    rotor = Rotor(**given, shaft_stiffness=0.25)
    low, high = extent_of_whirl(rotor, 1.4231, "shaft_stiffness")
    assert (low, high.kind) == (End(0.0, "none"), "fold")
    sizes = synchronous_response(**given, shaft_stiffness=high.value).amplitude.values.ravel()
    beside = {**given, "shaft_stiffness": high.value}
    assert np.abs(stability_determinant(sizes, **beside)).min() < 1e-6


@pytest.mark.parametrize(
    "rotor",
    [
        Rotor(omega=3.0, zeta=0.1, delta0=1.5, shaft_stiffness=1.0),
        Rotor(omega=0.5, zeta=0.1, delta0=1.5, shaft_stiffness=1.0),
        Rotor(omega=0.5, zeta=0.1, delta0=0.6, shaft_stiffness=1.0),
        Rotor(omega=1.0, zeta=0.6, delta0=1.5, shaft_stiffness=1.0),
    ],
    ids=repr,
)
def test_the_contact_free_whirl_of_a_shaft_ends_where_it_just_reaches_the_ring(rotor):
    assert varied(rotor) == ("omega", "zeta", "delta0", "shaft_stiffness")
    touches = 0
    for name in varied(rotor):
        low, high = extent_of_contact_free(rotor, name)
        assert low.value < getattr(rotor, name) < high.value
        for end in (low, high):
            given = rotor.given | {name: end.value}
            if end.kind == "touch":
                size = abs(complex_amplitude(*(given[each] for each in
                           ("omega", "zeta", "shaft_stiffness"))))  # fmt: skip
                assert size == pytest.approx(given["delta0"], rel=1e-12)
                touches += 1
            else:
                assert end in (End(0.0, "none"), End(math.inf, "none"))
    assert touches


def test_what_the_drive_gives_is_what_both_dampings_take():
    """Over a period of a cycle; the drive's work from the mean velocity along the unbalance."""
    rotor = Rotor(**PLAIN, contact_damping=0.02)
    row = of_kind(touchdown_report(rotor, **BOX, starts=64, shocks=0), "bouncing")
    run = simulate(rotor, start=(3.0, 0.0, 0.0, 0.0), duration=400.0, samples=2)
    turn = np.exp(-1j * rotor.omega * 400.0)
    z, v = complex(run.x[-1], run.y[-1]) * turn, complex(run.vx[-1], run.vy[-1]) * turn
    cycle = limit_cycle(rotor, start=(z.real, z.imag, v.real, v.imag))
    assert float(cycle.period) == pytest.approx(float(row.period), rel=1e-6)
    along = float(cycle.vx[:-1].mean())  # on the rotating axes; periodic, and so exact
    given = rotor.omega**2 * along * 2.0 * math.pi / rotor.omega
    assert float(row.dissipation_per_revolution) == pytest.approx(given, rel=1e-4)
    assert 0.01 < float(row.contact_loss_per_revolution / row.dissipation_per_revolution) < 0.5


def test_forces_of_a_linear_contact_are_the_indentation():
    rotor = Rotor(**PLAIN, contact_exponent=1.0)
    row = of_kind(touchdown_report(rotor, **BOX, starts=64, shocks=0), "bouncing")
    assert float(row.largest_force) == pytest.approx(float(row.radius_max) - 2.0, rel=1e-12)
    assert "contact_loss_per_revolution" not in row


@pytest.mark.parametrize(("zeta", "kappa"), [(0.07, 0.25), (0.9, 0.25)])
def test_no_shock_below_the_bound_drives_a_held_whirl_to_the_ring(zeta, kappa):
    """With little damping and with much; by CVODE, in twelve directions, just below it."""
    rotor = Rotor(omega=2.0, zeta=zeta, delta0=2.0, shaft_stiffness=kappa)
    report = touchdown_report(rotor, x=(-1, 1), y=(-1, 1), starts=16, shocks=64)
    row = of_kind(report, "contact_free")
    whirl = complex(complex_amplitude(2.0, zeta, kappa))
    for angle in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False):
        aside = np.exp(1j * angle)
        for kind, place in (("displacement", 0), ("velocity", 1)):
            size = 0.999 * float(row[f"{kind}_shock_bound"])
            assert size > 0.0
            z, v = np.array([whirl, 2j * whirl]) + size * aside * np.eye(2)[place]
            run = simulate(rotor, start=(z.real, z.imag, v.real, v.imag), duration=60.0, samples=2)
            assert run.sizes["event"] == 0


def test_an_atlas_is_drawn_over_the_parameters_of_machines():
    atlas = continue_attractors(
        **PLAIN | {"delta0": [1.5, 2.0]}, shaft_stiffness=[0.1, 0.2], **BOX, starts=16
    )
    assert plot_attractor_map(atlas).get_ylabel().startswith("stiffness of the shaft")
    line = plot_attractors(atlas.isel(delta0=[0]))
    assert line.get_xlabel().startswith("stiffness of the shaft")


def test_a_load_is_refused():
    with pytest.raises(InputError, match=r"^load must be 0 for an atlas"):
        continue_attractors(**PLAIN, load=0.125, **BOX, starts=4)
    with pytest.raises(InputError, match=r"^load must be 0 for a touchdown report"):
        touchdown_report(Rotor(**PLAIN, load=0.125), **BOX, starts=4)
