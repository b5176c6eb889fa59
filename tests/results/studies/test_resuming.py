"""A study that was broken off goes on to the same bits as one that was not."""

import json
import os
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import count
from multiprocessing import get_context
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from rotor_ida import (
    Contact,
    Rotor,
    RotorSystem,
    Stator,
    Unbalance,
    basin,
    basin_fractions,
    bifurcation_diagram,
    continue_attractors,
    continue_cycle,
    drop_ensemble,
    limit_cycle,
    load,
    lyapunov_exponent,
    run_ups,
    save,
    sweep,
)
from rotor_ida.cycles import continue_cycle as continue_cycle_module
from rotor_ida.errors import InputError
from rotor_ida.parallel import pools
from rotor_ida.results.studies import status
from rotor_ida.results.studies.design import refuse_another
from rotor_ida.results.studies.store import FILE, PIECES, _read, _write
from rotor_ida.steady import follow
from rotor_ida.verification.resume import resume
from tests.example_datasets import HELD, a_branch, a_system_cycle, given_for_drops

BOUNCER = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
AXIS = np.linspace(-8.0, 8.0, 40)
PLANE = {"speed": 0.7, "node": "disc", "y": [-1.0, 0.0, 1.0, 2.0]}
DROPS = given_for_drops()
AROUND = {name: each for name, each in DROPS.items() if name != "system"}
STATOR = Stator(mass=1.0, stiffness=5.0, damping=0.5)
TWO = RotorSystem(
    mass=np.eye(4), stiffness=np.kron([[2.0, -1.0], [-1.0, 2.0]], np.eye(2)),
    damping=0.1 * np.eye(4), nodes={"one": (0, 1), "two": (2, 3)}, units="1",
    contacts=[Contact(node="two", clearance=0.8, stiffness=20.0, stator=STATOR)],
    unbalance=[Unbalance(node="one", moment=0.4)],
)  # fmt: skip

KINDS = {
    "sweep": lambda **more: sweep(
        omega=[0.9, 1.2, 1.7], zeta=[0.3, 0.5], delta0=[0.0, 0.5],
        starts=[(0, 0, 0, 0), (3, 0, 0, 1)], **more,
    ),
    "ramps": lambda **more: sweep(
        omega=[0.9, 1.2, 1.7], zeta=[0.3, 0.5], delta0=[0.0, 0.5, 1.0], direction="both",
        events=True, **more,
    ),
    "ramps of machines": lambda **more: sweep(
        omega=[0.9, 1.2, 1.7], zeta=0.3, delta0=1.0, shaft_stiffness=0.25, contact_exponent=[1.0],
        load=[0.0, 0.3], direction="both", along="load", **more
    ),
    "run-ups": lambda **more: run_ups(
        omega=0.3, to=1.6, rate=[0.2, 0.3, 0.4], zeta=0.1, delta0=[1.0, 2.0], shaft_stiffness=1.0,
        friction=[0.0, 0.1], disc_radius=10.0, phase=[0.0, 1.0],
        starts=[(0, 0, 0, 0), (1, 0, 0, 0)], rtol=1e-8, **more,
    ),
    "basin": lambda **more: basin(BOUNCER, x=AXIS, y=AXIS, **more),
    "basin_fractions": lambda **more: basin_fractions(
        BOUNCER, x=(-8, 8), y=(-8, 8), vx=(-4, 4), starts=4000, **more
    ),
    "atlas of machines": lambda **more: continue_attractors(
        omega=[1.2, 1.5, 1.8], zeta=0.3, delta0=0.5, shaft_stiffness=0.25, contact_exponent=1.0,
        contact_damping=[0.0, 0.5], x=(-3, 3), y=(-3, 3), starts=20, **more,
    ),
    "exponents": lambda **more: lyapunov_exponent(
        BOUNCER, zeta=[0.07, 0.1, 0.2], transient=50.0, duration=200.0, batches=4, **more
    ),
    "cycles": lambda **more: limit_cycle(BOUNCER, omega=[1.9, 2.0, 2.5], **more),
    "branch": lambda **more: continue_cycle(BOUNCER, start=(0, 0, 0, 0), limits=(0.9, 2.4), **more),
    "branch of doubled cycles": lambda **more: continue_cycle(
        BOUNCER, start=a_branch().isel(special=0), limits=(1.75, 1.85), **more
    ),
    "diagram at a rate": lambda **more: bifurcation_diagram(
        omega=[1.0, 1.2], zeta=0.5, delta0=0.5, starts=2, x=(-1.0, 1.0), y=0.0, vx=0.0, vy=0.0,
        seed=3, direction="both", rate=0.1, **more,
    ),
    "drops": lambda **more: drop_ensemble(
        DROPS["system"], **AROUND, drops=5, seed=3, friction=(0.1, 0.2),
        clearance_factor=(0.9, 1.1),
        **more,
    ),
    "system sweep": lambda **more: sweep(
        TWO, speed=[0.6, 0.9, 1.2], modes=2,
        starts=["settled", (np.array([0.5, 0.0, 0.0, 0.0]), np.zeros(4))], rtol=1e-9, **more,
    ),
    "system run-ups": lambda **more: run_ups(
        TWO, speed=0.3, to=1.4, rate=[0.02, 0.2], starts=[None, "settled"], **more
    ),
    "system cycles": lambda **more: limit_cycle(
        BOUNCER.system(), speed=[1.9, 2.0, 2.5], start="rest", **more
    ),
    "system branch": lambda **more: continue_cycle(
        BOUNCER.system(), start=a_system_cycle(), limits=(1.9, 2.1), **more
    ),
    "system extrema": lambda **more: bifurcation_diagram(
        TWO, speed=[1.0, 1.1], revolutions=5, starts=["settled", None], **more
    ),
    "system strobes": lambda **more: bifurcation_diagram(
        TWO, speed=[1.0, 1.1], at="revolution", revolutions=5, starts=["settled", None], **more
    ),
    "system basin": lambda **more: basin(
        HELD.system(), **PLANE, x=[-2.0, -1.0, 0.0, 1.0, 2.0], **more
    ),
    "system atlas": lambda **more: continue_attractors(
        HELD.system(), speed=[0.7, 0.8, 0.9], node="disc", x=(-3, 3), y=(-3, 3), starts=4, **more
    ),
}  # fmt: skip


@cache
def whole_of(kind):
    """Return what is computed in one go."""
    return KINDS[kind]()


def assert_same(found, whole):
    """Check every bit; the arguments of a question have no order."""
    asked, again = (json.loads(each.attrs.pop("question", "{}")) for each in (found, whole))
    # a study of drops keeps the system with the contacts that were given beside it
    assert asked == again or asked["verb"] == again["verb"] == "drop_ensemble"
    xr.testing.assert_identical(found, whole)


def breaking_off(after):
    calls = count()

    def progress(_done, _total):
        if next(calls) == after:
            raise KeyboardInterrupt

    return progress


@pytest.mark.parametrize("kind", KINDS)
def test_it_goes_on_to_the_same_bits(kind, tmp_path, monkeypatch):
    whole = whole_of(kind)
    monkeypatch.setattr(continue_cycle_module, "PIECE", 2)
    for after in (0, 1):
        with pytest.raises(KeyboardInterrupt):
            KINDS[kind](study=tmp_path, progress=breaking_off(after))
    found = status(tmp_path)
    assert 0 < found["done"] < found["points"]
    told = []
    again = KINDS[kind](study=tmp_path, progress=lambda *told_now: told.append(told_now))
    begun, points = told[0]
    assert points == found["points"]
    # a branch goes on from the end of its last piece
    assert begun >= found["done"] if "branch" in kind else begun == found["done"]
    assert told[-1] == (found["points"], found["points"])
    assert_same(again, whole.copy())
    assert sorted(os.listdir(tmp_path)) == [PIECES, FILE]
    finished = status(tmp_path)
    assert (finished["left"], finished["failed"]) == (0, 0)
    assert_same(KINDS[kind](study=tmp_path), whole.copy())
    assert_same(resume(tmp_path), whole.copy())


@pytest.fixture(scope="module")
def processes():
    """Return two processes for the jobs of all kinds, as each takes seconds to import all."""
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        yield SimpleNamespace(submit=pool.submit, shutdown=lambda **_: None)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if "branch" not in kind])
def test_processes_find_the_same_bits_as_threads(kind, processes, monkeypatch):
    monkeypatch.setattr(pools, "ProcessPoolExecutor", lambda *_, **__: processes)
    xr.testing.assert_identical(KINDS[kind](executor="processes", workers=2), whole_of(kind))


def test_a_failure_of_the_surroundings_is_tried_again(tmp_path, monkeypatch):
    from rotor_ida.steady import points as sweeps

    def has_no_memory(rotor, *rest, **options):
        if rotor.omega == 2.0:
            raise MemoryError
        return follow.settle_disc(rotor, *rest, **options)

    given = {"omega": [1.0, 2.0], "zeta": 0.5, "delta0": 0.5, "executor": "serial"}
    with monkeypatch.context() as patch:
        patch.setattr(sweeps, "settle_disc", has_no_memory)
        found = sweep(**given, study=tmp_path)
    assert found.message.values.ravel().tolist() == ["", "MemoryError"]
    assert status(tmp_path)["left"] == 1
    xr.testing.assert_identical(sweep(**given, study=tmp_path), sweep(**given))


def test_only_what_draws_and_tells_does_not_decide_on_the_bits():
    script = (
        "import sys, rotor_ida.steady.sweep, rotor_ida.basins\n"
        "from rotor_ida.results.provenance import NOT_COMPUTING\n"
        "used = [name.replace('.', '/').removeprefix('rotor_ida/') + '/' for name in sys.modules]\n"
        "folders = tuple(f'{each}/' for each in NOT_COMPUTING)\n"
        "print([name for name in used if name.startswith(folders)], end='')"
    )
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert (ended.stdout, ended.stderr) == ("[]", "")


def test_a_seed_of_numpy_leaves_no_trace(tmp_path):
    box = {"x": (-8, 8), "y": (-8, 8), "starts": 100}
    found = basin_fractions(BOUNCER, **box, seed=np.uint8(3), study=tmp_path)
    assert type(found.attrs["seed"]) is int
    xr.testing.assert_identical(basin_fractions(BOUNCER, **box, seed=3, study=tmp_path), found)


def test_a_point_that_fails_is_recorded_and_the_others_go_on(tmp_path, monkeypatch):
    from rotor_ida.steady import points as sweeps

    def fails_at_two(rotor, *rest, **options):
        if rotor.omega == 2.0:
            raise OverflowError("too large")
        return follow.settle_disc(rotor, *rest, **options)

    monkeypatch.setattr(sweeps, "settle_disc", fails_at_two)
    given = {"omega": [1.0, 2.0, 3.0], "zeta": 0.5, "delta0": 0.5, "executor": "serial"}
    found = sweep(**given, study=tmp_path)
    told = status(tmp_path)
    assert (told["done"], told["failed"], told["left"]) == (3, 1, 0)
    assert told["reasons"] == ["OverflowError: too large"]
    assert found.status.values.ravel().tolist() == [0, 1, 0]
    assert found.message.values.ravel()[1] == "OverflowError: too large"
    monkeypatch.undo()
    xr.testing.assert_identical(sweep(**given, study=tmp_path), found)


def test_a_fault_of_the_program_is_raised_and_what_was_done_is_kept(tmp_path, monkeypatch):
    from rotor_ida.steady import points as sweeps

    def slips_at_two(rotor, *rest, **options):
        if rotor.omega == 2.0:
            raise KeyError("a slip")
        return follow.settle_disc(rotor, *rest, **options)

    given = {"omega": [1.0, 2.0, 3.0], "zeta": 0.5, "delta0": 0.5, "executor": "serial"}
    monkeypatch.setattr(sweeps, "settle_disc", slips_at_two)
    with pytest.raises(KeyError, match="a slip"):
        sweep(**given, study=tmp_path)
    monkeypatch.undo()
    told = status(tmp_path)
    assert (told["done"], told["failed"], told["left"]) == (1, 0, 2)
    xr.testing.assert_identical(sweep(**given, study=tmp_path), sweep(**given))


@pytest.mark.parametrize("kind", ["ramps", "basin_fractions", "run-ups"])
def test_columns_on_the_disk_hold_the_same_bits(kind, tmp_path, monkeypatch):
    from rotor_ida.basins import starts
    from rotor_ida.results.studies import arrays

    whole = whole_of(kind)
    monkeypatch.setattr(arrays, "LARGE", 1)
    monkeypatch.setattr(starts, "STRETCH", 100)
    on_disk = KINDS[kind](study=tmp_path / "study")
    xr.testing.assert_identical(on_disk, whole)
    saved = load(save(on_disk, tmp_path / "result.nc"))
    assert (
        saved.attrs["content_sha256"]
        == load(save(whole, tmp_path / "whole.nc")).attrs["content_sha256"]
    )
    assert sorted(os.listdir(tmp_path / "study")) == [PIECES, FILE]


def test_what_another_program_has_done_is_loaded_and_says_so(tmp_path):
    """A study that is done needs no computing; one that is not is refused by another program."""
    begun = sweep(omega=[1.2, 1.7], zeta=0.5, delta0=0.5, study=tmp_path / "study")
    told, _ = _read(tmp_path / "study", FILE)
    told["design"]["numba_version"] = "0.64"
    _write(tmp_path / "study", FILE, told)
    loaded = resume(tmp_path / "study")
    assert "numba_version 0.64" in loaded.attrs["computed_with"]
    del loaded.attrs["computed_with"]
    assert loaded.identical(begun)
    (tmp_path / "study" / PIECES / "0").unlink()
    with pytest.raises(InputError, match=r"was begun with numba_version '0\.64', got 'nothing'"):
        resume(tmp_path / "study")


@pytest.mark.parametrize(
    ("before", "now", "told"),
    [
        ([{"clearance": 1e-4, "friction": 0.1, "node": "a", "radius": 0.1, "stator": None}],
         [{"clearance": 1e-4, "friction": 0.2, "node": "a", "radius": 0.1, "stator": None}],
         r"given 0 friction 0\.1, got 0\.2"),
        ({"mass": [[1.0] * 9, [0.0] * 9]}, {"mass": [[1.0] * 9, [0.0] * 8 + [2.0]]},
         r"given mass 1 8 0\.0, got 2\.0"),
        ({"a": None}, {"b": None}, r"given a None, got 'nothing'"),
        ([1.2, 1.7], [1.2, 1.8], r"given \[1\.2, 1\.7\], got \[1\.2, 1\.8\]"),
        ([0.0] * 9, [0.0] * 8 + [-0.0], r"given 8 0\.0, got -0\.0"),
    ],
)  # fmt: skip
def test_a_refusal_shows_the_part_of_a_design_that_differs(before, now, told):
    with pytest.raises(InputError, match=rf"was begun with {told}: resume"):
        refuse_another("study", {"given": before, "rtol": 1.0}, {"given": now, "rtol": 1.0})
