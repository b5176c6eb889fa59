"""Every result of the analysis is labelled and can be kept in an archive."""

import numpy as np
import pytest

from rotor_ida import (
    DimensionalRotor,
    Rotor,
    bifurcation_diagram,
    contact_forces,
    dimensional,
    load,
    lyapunov_exponent,
    poincare_section,
    rotating,
    save,
    simulate,
    spectrum,
)
from rotor_ida.schema import QUANTITIES, flags_of

REST = (0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def results():
    rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
    run = simulate(rotor, start=REST, duration=40.0, samples=401)
    return {
        "rotating": rotating(run),
        "spectrum": spectrum(run),
        "forces": contact_forces(run),
        "section": poincare_section(rotor, start=REST, revolutions=5),
        "empty_section": poincare_section(
            Rotor(omega=1.0, zeta=0.5, delta0=9.0), start=REST, revolutions=5, at="exit"
        ),
        "lyapunov": lyapunov_exponent(rotor, start=REST, duration=200.0),
        "bifurcation_diagram": bifurcation_diagram(
            omega=[1.0, 2.0], zeta=0.5, delta0=2.0, starts=2
        ),
    }


def test_every_variable_says_what_it_is(results):
    for result, dataset in results.items():
        for name, variable in dataset.variables.items():
            assert variable.attrs["long_name"] == QUANTITIES[name].long_name, (result, name)
            assert name == "message" or variable.attrs["units"], (result, name)
            assert variable.dtype.kind not in "bc"
            if "flag_values" in variable.attrs:
                assert set(np.unique(variable)) <= set(flags_of(variable).values()), name
        assert {"omega", "zeta", "delta0"} <= set(dataset.coords), result


def test_attributes_tell_how_it_was_made(results):
    for result, dataset in results.items():
        for key in ("Conventions", "title", "source", "method", "flight", "rtol",
                    "rotor_ida_version", "numpy_version"):  # fmt: skip
            assert key in dataset.attrs, (result, key)
    titles = {dataset.attrs["title"] for name, dataset in results.items() if "section" not in name}
    assert len(titles) == 5


def test_archives_give_them_back(results, tmp_path):
    for name, dataset in results.items():
        save(dataset, tmp_path / f"{name}.nc")
        back = load(tmp_path / f"{name}.nc")
        for variable in dataset.variables:
            np.testing.assert_array_equal(back[variable].values, dataset[variable].values)


def test_in_si_units_lengths_forces_and_rates_scale_as_they_should(results):
    machine = DimensionalRotor(mass=4.0, contact_stiffness=1e9, damping=280.0,
                               eccentricity=1e-6, clearance=2e-6, speed=1000.0)  # fmt: skip
    lines = dimensional(results["spectrum"], machine)
    assert lines.whirl_amplitude.attrs["units"] == "m"
    assert lines.frequency.attrs["units"] == "s-1"
    np.testing.assert_allclose(lines.frequency, 500.0 * results["spectrum"].frequency, rtol=1e-12)
    forces = dimensional(results["forces"], machine)
    np.testing.assert_allclose(forces.force_x, results["forces"].force_x, rtol=1e-12)
    assert forces.force_x.attrs["units"] == "N"
