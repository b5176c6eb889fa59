"""The benchmarks ask the package for nothing that it does not have."""

import ast
import importlib
import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.mark.parametrize("path", sorted(BENCHMARKS.glob("*.py")), ids=lambda path: path.stem)
def test_names_that_a_benchmark_imports_exist(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("rotor_ida"):
            module = importlib.import_module(node.module)
            for name in (alias.name for alias in node.names):
                if not hasattr(module, name):
                    importlib.import_module(f"{node.module}.{name}")


@pytest.fixture(scope="module")
def ross_rub():
    spec = importlib.util.spec_from_file_location("ross_rub", BENCHMARKS / "ross_rub.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("over_rim", [-1.5, -0.5, 1.0])
def test_friction_opposes_the_slip_all_round_the_ring(ross_rub, over_rim):
    radius = 0.0095
    whirl = over_rim * ross_rub.SPEED * radius / (ross_rub.CLEARANCE + ross_rub.DEPTH)
    rows = ross_rub.table(ross_rub.friction_here(radius), radius, whirl, 12)
    assert (np.sign(rows[:, 1]) == math.copysign(1.0, over_rim + 1.0)).all()
    np.testing.assert_allclose(rows[:, 3], 180.0, atol=1e-2)
    np.testing.assert_allclose(rows[:, 4], 0.0, atol=1e-4)
    np.testing.assert_allclose(rows[:, 5], -1.0, atol=1e-4)


def test_table_shows_where_a_force_by_components_points(ross_rub):
    """(-mu |F_x|, mu |F_y|) is right at 225 degrees alone, and does no work over a turn."""
    scale = ross_rub.FRICTION * ross_rub.STIFFNESS * ross_rub.DEPTH

    def by_components(place, _):
        return scale * np.array([-1.0, 1.0]) * np.abs(place) / math.hypot(*place)

    rows = ross_rub.table(by_components, 0.0095, ross_rub.SPEED, 8)
    angle, _, _, between, radial, sliding = rows.T
    np.testing.assert_allclose(angle, np.arange(8) * 45.0)
    np.testing.assert_allclose(between, [90, 0, 90, 90, 90, 180, 90, 90], atol=1e-9)
    np.testing.assert_allclose(radial, [-1, 0, 1, 1, 1, 0, -1, -1], atol=1e-12)
    np.testing.assert_allclose(sliding, [0, 1, 0, 0, 0, -1, 0, 0], atol=1e-12)
    assert abs(radial.mean()) < 1e-15
    assert abs(sliding.mean()) < 1e-15
