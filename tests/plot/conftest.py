import numpy as np
import pytest
import xarray as xr

from rotor_ida import Rotor, folds, simulate
from rotor_ida.closed_forms import response_curve
from rotor_ida.schema import RESPONSE, labelled

ZETA, DELTA0 = 0.07, 0.5


@pytest.fixture(scope="session")
def exact():
    return response_curve(zeta=ZETA, delta0=DELTA0, limits=(0.05, 3.0))


@pytest.fixture(scope="session")
def fold_points():
    return folds(zeta=ZETA, delta0=DELTA0)


@pytest.fixture(scope="session")
def run():
    rotor = Rotor(omega=1.7, zeta=ZETA, delta0=DELTA0)
    return simulate(rotor, start=(0.0, 0.0, 0.0, 0.0), duration=20.0, samples=201)


@pytest.fixture
def simulated():
    """One response of each kind, at seven speeds, going up and down; not a simulation."""
    kinds = ["contact_free", "synchronous", "bouncing", "full_contact", "unresolved", "touching",
             "chaotic"]  # fmt: skip
    dims = ("omega", "zeta", "delta0", "start", "direction")
    shape = (7, 1, 1, 1, 2)
    flags = np.array([RESPONSE[kind] for kind in kinds], dtype=np.int8)
    spread = np.array([0.0, 0.0, 1.0, 0.5, 0.2, 0.0, 0.9])
    columns = {
        "response": flags,
        "amplitude": np.full(7, 1.2),
        "phase_lag": np.full(7, 2.9),
        "radius_min": 1.2 - spread,
        "radius_max": 1.2 + spread,
    }
    variables = {
        name: labelled(name, dims, np.broadcast_to(column.reshape(7, 1, 1, 1, 1), shape).copy())
        for name, column in columns.items()
    }
    axes = {"omega": np.linspace(0.5, 3.5, 7), "zeta": [ZETA], "delta0": [DELTA0]}
    coordinates = {name: labelled(name, name, values) for name, values in axes.items()}
    coordinates["direction"] = labelled("direction", "direction", np.array([1, -1], np.int8))
    for name in ("x", "y", "vx", "vy"):
        coordinates[f"start_{name}"] = labelled(f"start_{name}", "start", [0.0])
    return xr.Dataset(variables, coordinates)
