"""Every public function with odd values for each argument: only errors of this package leave it."""

from __future__ import annotations

import fractions
import functools
import inspect
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import rotor_ida
from rotor_ida import (
    Contact,
    DimensionalRotor,
    Rotor,
    RotorError,
    RotorSystem,
    Support,
    Unbalance,
    closed_forms,
    decode_flags,
)
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.rotor_system import SystemParameters
from rotor_ida.model.system_parameters import SystemAxes
from tests.example_datasets import KINDS

LONGEST_MESSAGE = 300
PATHS = ("path", "study", "folder")
# Seconds: the longest call follows one undamped motion, in three of them on one core.
LONGEST_CALL = 60.0

ROTOR = Rotor(omega=1.2, zeta=0.5, delta0=0.5)
MACHINE = DimensionalRotor(
    mass=4.0, contact_stiffness=1e9, damping=280.0, eccentricity=1e-6, clearance=2e-6, speed=600.0
)
REST = (0.0, 0.0, 0.0, 0.0)
ODD = {
    "None": None, "True": True, "text": "1.0", "long text": "1" * 1000, "line\nfeed": "a\nb",
    "bytes": b"1", "nan": float("nan"), "inf": float("inf"), "-1": -1, "0": 0, "tiny": 5e-324,
    "huge": 1e308, "10**400": 10**400, "2**63": 2**63, "complex": 1j, "empty list": [],
    "list of lists": [[1, 2], [3, 4]], "ragged": [[1], [2, 3]], "dict": {}, "object": object(),
    "0-d array": np.array(1.0), "1-d array": np.array([1, 2]), "2-d array": np.eye(4),
    "0-d DataArray": xr.DataArray(1.0),
    "long DataArray": xr.DataArray(np.arange(100.0) - 3.0, dims="omega", name="omega"),
    "Series": pd.Series([1.0, 2.0]), "delay": np.timedelta64(1, "s"),
    "dates": np.array(["2019-06-01"], dtype="datetime64[ns]"),
    "Fraction": fractions.Fraction(1, 2), "function": len, "class": Rotor, "Dataset": xr.Dataset(),
    "masked": np.ma.array([1.0, 2.0], mask=[False, True]), "endless range": range(10**30),
    "iterator": iter(()),
}  # fmt: skip
SETTLING = ("bifurcation_diagram", "continue_attractors")


@functools.cache
def run() -> xr.Dataset:
    return rotor_ida.simulate(ROTOR, start=REST, duration=10.0, samples=33)


@functools.cache
def many_turns() -> xr.Dataset:
    return rotor_ida.simulate(ROTOR, start=REST, duration=260.0, samples=2601)


@functools.cache
def seen() -> xr.Dataset:
    longer = rotor_ida.simulate(ROTOR, start=REST, duration=30.0, samples=301)
    return rotor_ida.signals_of(longer)


@functools.cache
def swept(omega: float = 1.2) -> xr.Dataset:
    return rotor_ida.sweep(omega=omega, zeta=0.5, delta0=0.5)


CYCLES = Rotor(omega=3.0, zeta=0.07, delta0=0.5)


@functools.cache
def cycle() -> xr.Dataset:
    return rotor_ida.limit_cycle(CYCLES, start=(3.0, 1.0, 0.0, 0.0))


def system_of_cycles() -> dict[str, object]:
    return {"rotor": replace(CYCLES, shaft_stiffness=0.01).system()}


@functools.cache
def system_cycle() -> xr.Dataset:
    start = ((3.0, 1.0), (0.0, 0.0))
    return rotor_ida.limit_cycle(**system_of_cycles(), speed=3.0, start=start)


@functools.cache
def fold() -> xr.Dataset:
    branch = rotor_ida.continue_cycle(CYCLES, start=cycle(), limits=(2.5, 3.1))
    return branch.isel(special=0)


@functools.cache
def compared() -> xr.Dataset:
    starts = [(3.0, 1.0, 0.0, 0.0)]
    return rotor_ida.compare(rotor_ida.sweep(omega=3.0, zeta=0.07, delta0=0.5, starts=starts))


# Arguments with which each function does little.
GIVEN: dict[str, Callable[[Path], dict[str, object]]] = {
    "Rotor": lambda _: {"omega": 1.2, "zeta": 0.5, "delta0": 0.5},
    "DimensionalRotor": lambda _: {name: getattr(MACHINE, name)
                                   for name in DimensionalRotor.__slots__},
    "simulate": lambda _: {"rotor": ROTOR, "start": REST, "duration": 1.0, "samples": 3},
    "run_up": lambda _: {"rotor": ROTOR, "start": REST, "to": 1.5, "rate": 0.1, "samples": 3},
    "synchronous_response": lambda _: {"omega": 1.2, "zeta": 0.5, "delta0": 0.5},
    "folds": lambda _: {"zeta": 0.07, "delta0": 0.5},
    "run_ups": lambda folder: {"omega": 0.3, "to": 1.6, "rate": 0.4, "zeta": 0.5, "delta0": 2.0,
        "workers": 1, "study": folder / "run_ups"},
    "sweep": lambda folder: {"omega": 1.2, "zeta": 0.5, "delta0": 0.5, "workers": 1,
        "study": folder / "sweep"},
    "basin": lambda _: {"rotor": ROTOR, "x": [0.0, 1.0], "y": [0.0, 1.0], "workers": 1},
    "basin_fractions": lambda _: {"rotor": ROTOR, "x": (0.0, 1.0), "y": (0.0, 1.0), "starts": 2,
        "workers": 1},
    "continue_attractors": lambda _: {"omega": 1.2, "zeta": 0.5, "delta0": 0.5, "x": (0.0, 1.0),
        "y": (0.0, 1.0), "starts": 2, "workers": 1},
    "touchdown_report": lambda _: {"rotor": MACHINE, "x": (0.0, 1e-6), "y": (0.0, 1e-6),
        "starts": 2, "shocks": 0},
    "bifurcation_diagram": lambda _: {"omega": 1.2, "zeta": 0.5, "delta0": 0.5, "starts": 1,
        "extrema_time": 1.0, "workers": 1},
    "limit_cycle": lambda _: {"rotor": CYCLES, "start": [float(cycle()[name][0]) for name in ("x",
        "y", "vx", "vy")], "period": 3.1},
    "continue_cycle": lambda folder: {"rotor": CYCLES, "start": cycle(), "limits": (2.95, 3.05),
        "points": 5, "study": folder / "branch"},
    "bifurcation_curve": lambda _: {"rotor": CYCLES, "start": fold(), "kind": "fold",
        "limits": ((2.4, 3.2), (0.4, 0.6)), "points": 3},
    "branches_through": lambda _: {"compared": compared(), "limits": (2.95, 3.05), "points": 5},
    "lyapunov_exponent": lambda _: {"rotor": ROTOR, "start": REST, "transient": 1.0,
        "duration": 40.0, "batches": 4},
    "lyapunov_exponent_system": lambda _: {**system_of_cycles(), "speed": 3.0, "transient": 1,
        "revolutions": 80, "batches": 4, "exponents": 1},
    "poincare_section": lambda _: {"rotor": ROTOR, "start": REST, "revolutions": 1},
    "rotating": lambda _: {"run": run()},
    "signals_of": lambda _: {"run": run()},
    "orders": lambda _: {"signals": run()},
    "bode_peaks": lambda _: {"signals": run()},
    "centre_line": lambda _: {"signals": run()},
    "filtered_orbit": lambda _: {"signals": run(), "order": 1},
    "full_spectrum": lambda _: {"signals": run()},
    "spectral_lines": lambda _: {"signals": run(), "count": 2},
    "spectrogram": lambda _: {"signals": run(), "segment": 16},
    "whirl_ratio": lambda _: {"signals": run()},
    "rub_signs": lambda _: {"signals": many_turns()},
    "correct_probes": lambda _: {"signals": run()},
    "subtract_runout": lambda _: {"signals": run(), "slow_roll": run()},
    "fit": lambda _: {"signals": seen(), "machine": ROTOR, "unknown": ["zeta"], "time_error": 0.1,
        "entries": [15.0]},
    "read_signals": lambda folder: {"path": measured_in(folder)},
    "contact_forces": lambda _: {"run": run()},
    "contact_summary": lambda _: {"run": run()},
    "compare": lambda _: {"dataset": swept()},
    "concat": lambda _: {"datasets": [swept(), swept(1.3)], "dim": "omega"},
    "decode_flags": lambda _: {"data": run()},
    "to_dataframe": lambda _: {"dataset": run()},
    "dimensional": lambda _: {"dataset": run(), "machine": MACHINE},
    "machine_from_data_sheet": lambda _: {"mass": "4 kg", "contact_stiffness": "1e9 N/m^1.5",
        "clearance": 2e-6, "speed": "600 rad/s", "damping": 280.0, "eccentricity": "1 um"},
    "save_machine": lambda folder: {"machine": MACHINE, "path": folder / "new.toml",
        "overwrite": True},
    "load_machine": lambda folder: {"path": machine_in(folder)},
    "summary": lambda _: {"run": ramp()},
    "save": lambda folder: {"dataset": run(), "path": folder / "new.nc", "overwrite": True},
    "load": lambda folder: {"path": archive_in(folder)},
    "open_archive": lambda folder: {"path": archive_in(folder)},
    "resume": lambda folder: {"folder": study_in(folder), "workers": 1},
    "status": lambda folder: {"folder": study_in(folder)},
    "response_curve": lambda _: {"zeta": 0.07, "delta0": 0.5, "limits": (0.5, 3.0), "points": 20},
    "clearance_curve": lambda _: {"omega": 1.2, "zeta": 0.07, "limits": (0.0, 2.0), "points": 20},
    "backbone": lambda _: {"amplitude": 2.0},
    "speeds_at_amplitude": lambda _: {"amplitude": 2.0, "zeta": 0.07, "delta0": 0.5},
    "peak_amplitude": lambda _: {"zeta": 0.07, "delta0": 0.5},
    "peaks": lambda _: {"zeta": 0.07, "delta0": 0.5},
    "jumps": lambda _: {"zeta": 0.07, "delta0": 0.5},
    "cusp": lambda _: {"delta0": 0.5},
    "cusp_zeta": lambda _: {"delta0": 0.5},
    "free_periods": lambda _: {"amplitude": 2.0, "delta0": 0.5},
    "circular_period": lambda _: {"amplitude": 2.0},
    "planar_period": lambda _: {"amplitude": 2.0},
    "centre_speed": lambda _: {"amplitude": 2.0},
    "amplitude_from_speed": lambda _: {"speed": 2.0},
    "hopf_points": lambda _: {"zeta": 0.07, "delta0": 0.5, "contact_damping": 0.5},
    "ramp_flight": lambda _: {"time": 1.0, "rotor": ROTOR, "start": REST, "rate": 0.1},
    "late_jumps": lambda _: {"rate": 1e-3, "zeta": 0.07, "delta0": 0.5},
    "sommerfeld_curve": lambda _: {"zeta": 0.07, "delta0": 0.5, "limits": (0.5, 3.0),
        "inertia": 10.0, "points": 20},
    "whirl_torque": lambda _: {"amplitude": 2.0, "omega": 1.2, "zeta": 0.5, "delta0": 0.5},
    "impact": lambda _: {"entry_speed": 1.0, "contact_damping": 0.5},
    "rest": lambda _: {"rotor": ROTOR},
    "backward_whirl": lambda _: {"rotor": rubbing()},
    "touch_speeds": lambda _: {"zeta": 0.07, "delta0": 0.5, "shaft_stiffness": 0.25},
    "restoring_field": lambda _: {"x": 1.0, "y": 1.0, "delta0": 0.5},
    "flight": lambda _: {"time": 1.0, "rotor": ROTOR, "start": REST},
    "contact_free_whirl": lambda _: {"rotor": ROTOR},
    "touch_fading": lambda _: {"rotor": ROTOR},
    "stability_determinant": lambda _: {"amplitude": 2.0, "omega": 1.2, "zeta": 0.5, "delta0": 0.5},
    "eigenvalues": lambda _: {"amplitude": 2.0, "omega": 1.2, "zeta": 0.5, "delta0": 0.5},
}  # fmt: skip


SYSTEM = RotorSystem(mass=np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)}, units="1")
DAMPED = RotorSystem(
    mass=np.eye(2), damping=0.1 * np.eye(2), stiffness=np.eye(2), nodes={"disc": (0, 1)}, units="1"
)
TOUCHING = replace(
    DAMPED, contacts=[Contact(node="disc", clearance=0.5, stiffness=4.0)],
    unbalance=[Unbalance(node="disc", moment=1.0)],
)  # fmt: skip
GIVEN |= {
    "RotorSystem": lambda _: {"mass": np.eye(2), "stiffness": np.eye(2), "nodes": {"a": (0, 1)}},
    "Contact": lambda _: {"node": "disc", "clearance": 0.5, "stiffness": 4.0},
    "Bearing": lambda _: {
        "node": "disc", "speed": [0.0, 1.0], "stiffness": [1.0, 2.0], "damping": [0.1, 0.2],
    },
    "Stator": lambda _: {"mass": 1.0, "stiffness": 2.0},
    "Race": lambda _: {"radius": 1.0, "inertia": 2.0},
    "Unbalance": lambda _: {"node": "disc", "moment": 1.0},
    "simulate_system": lambda _: {
        "rotor": SYSTEM, "speed": 1.2, "duration": 2.0,
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0)],
    },
    "sweep_system": lambda _: {
        "rotor": SYSTEM, "speed": [0.8, 1.2],
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0, damping=0.5)],
    },
    "run_ups_system": lambda folder: {
        "rotor": SYSTEM, "speed": 0.8, "to": 1.2, "rate": 0.4, "workers": 1, "study": folder / "up",
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0, damping=0.5)],
    },
    "limit_cycle_system": lambda _: {
        **system_of_cycles(), "speed": 3.0, "period": 3.1,
        "start": tuple(np.array([cycle()[name].values[0] for name in each]) for each in
                       (("x", "y"), ("vx", "vy"))),
    },
    "continue_cycle_system": lambda folder: {
        **system_of_cycles(), "start": system_cycle(), "limits": (2.99, 3.01), "points": 2,
        "direction": "forward",
        "study": folder / "branch",
    },
    "synchronous_response_system": lambda _: {
        "rotor": SYSTEM, "speed": [0.8, 1.2],
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0)],
        "unbalance": [Unbalance(node="disc", moment=1.0)],
    },
    "special_speeds": lambda _: {
        "system": SYSTEM, "limits": (0.8, 1.2), "points": 4,
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0)],
        "unbalance": [Unbalance(node="disc", moment=1.0)],
    },
    "campbell": lambda _: {"system": SYSTEM, "speed": [0.8, 1.2], "modes": 2},
    "clearance_report": lambda _: {
        "system": DAMPED, "speed": (0.8, 1.2), "probes": ["disc"], "points": 8,
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0)],
        "unbalance": [Unbalance(node="disc", moment=1.0)], "vibration_limit": 1.0,
    },
    "Support": lambda _: {"node": "disc", "stiffness": 2.0},
    "ball_bearing_stiffness": lambda _: {
        "ball_diameter": 0.01, "pitch_diameter": 0.05, "balls": 9,
    },
    "drop": lambda _: {
        "system": SYSTEM, "speed": 1.2, "duration": 2.0, "gravity": (0.0, -1.0),
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0)],
        "supports": [Support(node="disc", stiffness=2.0)],
    },
    "drop_ensemble": lambda folder: {
        "system": SYSTEM, "speed": 1.2, "duration": 1.0, "gravity": (0.0, -1.0), "drops": 2,
        "contacts": [Contact(node="disc", clearance=0.5, stiffness=4.0)], "workers": 1,
        "supports": [Support(node="disc", stiffness=2.0)], "study": folder / "drops",
    },
    "poincare_section_system": lambda _: {
        "rotor": TOUCHING, "speed": 1.2, "start": None, "revolutions": 3, "at": "entry",
        "contact": 0,
    },
    "bifurcation_diagram_system": lambda folder: {
        "rotor": TOUCHING, "speed": [1.2], "at": "revolution", "revolutions": 2, "starts": [None],
        "study": folder / "study",
    },
    "basin_system": lambda folder: {
        "rotor": TOUCHING, "speed": 1.2, "node": "disc", "x": [0.0, 0.1], "y": [0.0],
        "start": None, "study": folder / "study",
    },
    "basin_fractions_system": lambda folder: {
        "rotor": TOUCHING, "speed": 1.2, "node": "disc", "x": (0.0, 0.1), "y": (0.0, 0.1),
        "starts": 2, "start": None, "study": folder / "study",
    },
    "run_up_system": lambda _: {"rotor": SYSTEM, "speed": 1.2, "to": 1.4, "rate": 0.1},
    "load_course": lambda folder: {"path": system_in(folder)},
    "load_system": lambda folder: {"path": system_in(folder)},
}  # fmt: skip
# Functions of one disc and of rotor systems have a second entry, with a system.
OF_SYSTEMS = {
    "simulate_system": rotor_ida.simulate, "run_up_system": rotor_ida.run_up,
    "sweep_system": rotor_ida.sweep, "run_ups_system": rotor_ida.run_ups,
    "lyapunov_exponent_system": rotor_ida.lyapunov_exponent,
    "limit_cycle_system": rotor_ida.limit_cycle, "continue_cycle_system": rotor_ida.continue_cycle,
    "synchronous_response_system": rotor_ida.synchronous_response,
    "poincare_section_system": rotor_ida.poincare_section,
    "bifurcation_diagram_system": rotor_ida.bifurcation_diagram,
    "basin_system": rotor_ida.basin, "basin_fractions_system": rotor_ida.basin_fractions,
}  # fmt: skip


# Where the fields of a rotor are given odd values: of each class that reads them, and of studies.
READ_BY = {
    **dict.fromkeys(("simulate", "simulate_system"), SystemParameters.__annotations__),
    "sweep_system": SystemAxes.__annotations__,
    "synchronous_response_system": SystemParameters.__annotations__,
    **dict.fromkeys(("sweep", "synchronous_response", "run_ups"),
                    ALL_PARAMETERS),
}  # fmt: skip


def rubbing() -> Rotor:
    rotor = Rotor(omega=1.2, zeta=0.1, delta0=1.0)
    for name, value in (("friction", 0.2), ("disc_radius", 10.0)):
        object.__setattr__(rotor, name, value)
    return rotor


@functools.cache
def ramp() -> xr.Dataset:
    return rotor_ida.run_up(ROTOR, to=1.4, rate=0.1)


def machine_in(folder: Path) -> Path:
    path = folder / "machine.toml"
    return path if path.exists() else rotor_ida.save_machine(MACHINE, path)


def system_in(folder: Path) -> Path:
    path = folder / "system.toml"
    path.write_text("system = { mass = [1, 1], stiffness = [1, 1], nodes = { disc = [0, 1] } }")
    return path


def archive_in(folder: Path) -> Path:
    path = folder / "run.nc"
    return path if path.exists() else rotor_ida.save(run(), path)


def measured_in(folder: Path) -> Path:
    path = folder / "measured.csv"
    if not path.exists():
        times = np.arange(100) / 100
        table = np.column_stack([times, np.cos(50 * times), np.sin(50 * times), 50 * times])
        np.savetxt(path, table, delimiter=",", header="t,x,y,angle", comments="")
    return path


def study_in(folder: Path) -> Path:
    study = folder / "study"
    if not study.exists():
        rotor_ida.sweep(omega=1.2, zeta=0.5, delta0=0.5, study=study)
    return study


@functools.cache
def public() -> dict[str, Callable[..., object]]:
    """Return what a user may call, without modules, errors and a plain record."""
    found = {name: getattr(rotor_ida, name) for name in rotor_ida.__all__}
    found |= {name: getattr(closed_forms, name) for name in closed_forms.__all__}
    return {
        name: each
        for name, each in found.items()
        if name != "ContactFreeWhirl"
        and not inspect.ismodule(each)
        and not (isinstance(each, type) and issubclass(each, Exception))
    }


def function_of(name: str) -> Callable[..., object]:
    """Return the public function of an entry."""
    if name in OF_SYSTEMS:
        return getattr(rotor_ida, name.removesuffix("_system"))
    return public()[name]


def arguments_of(name: str) -> list[str]:
    """Return the arguments of an entry, with the fields of a rotor that it is given here.

    Of some with all fields: they are read by the same code everywhere, and that each function uses
    or refuses them is shown by `test_no_parameter_is_ignored`.
    """
    function = OF_SYSTEMS.get(name) or inspect.unwrap(function_of(name))
    names = list(inspect.signature(function).parameters)
    if name in OF_SYSTEMS:
        names[0] = "rotor"
    fields = [each for each in ("changed", "varied") if each in names]
    names = [each for each in names if each not in fields]
    more = [*READ_BY.get(name, ()), *GIVEN[name](Path())] if fields else []
    return list(dict.fromkeys([*names, *more]))


def odd_calls(name: str, folder: Path) -> Iterator[tuple[str, str]]:
    """Call a function with one odd argument at a time; yield what was odd, and what is wrong."""
    function = function_of(name)
    function(**GIVEN[name](folder))  # as it stands it is accepted
    for argument in arguments_of(name):
        for word, value in ODD.items():
            if argument == "progress" and callable(value):
                continue  # whatever it raises is its own
            if argument in PATHS and word == "long text":
                continue  # a path is shown whole
            if name in SETTLING and (argument, word) == ("zeta", "tiny"):
                continue  # it is used, and followed for as long as a run may last
            given = GIVEN[name](folder) | {argument: value}
            began = time.monotonic()
            trouble = ""
            try:
                function(**given)
            except RotorError as error:
                message = str(error)
                shown = message.replace(str(folder), "")
                if "\n" in message or len(shown) > LONGEST_MESSAGE:
                    trouble = f"message of {len(message)} characters: {message[:400]!r}"
            except Exception as error:
                trouble = f"raw {type(error).__name__}: {str(error)[:200]}"
            if time.monotonic() - began > LONGEST_CALL:
                trouble = f"took {time.monotonic() - began:.1f} s"
            yield f"{name}({argument} = {word})", trouble


def test_every_public_function_is_in_the_table():
    assert set(public()) == set(GIVEN) - set(OF_SYSTEMS)
    arguments = sum(len(arguments_of(name)) for name in GIVEN)
    assert arguments * len(ODD) > 2000


@pytest.mark.parametrize("name", GIVEN)
def test_odd_values_are_refused_in_one_line_or_used(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    troubles = [f"{call}: {trouble}" for call, trouble in odd_calls(name, tmp_path) if trouble]
    assert not troubles, "\n".join(troubles)


def calls_with_results(folder: Path) -> Iterator[tuple[str, str, bool]]:
    """Yield each function, each of its arguments that is a result, and whether it is a list."""
    for name, function in public().items():
        parameters = inspect.signature(function).parameters.values()
        if any("xr.Dataset" in str(each.annotation) for each in parameters):
            for argument, value in GIVEN[name](folder).items():
                if isinstance(value, xr.Dataset):
                    yield name, argument, False
                elif isinstance(value, list) and isinstance(value[0], xr.Dataset):
                    yield name, argument, True


def test_results_of_another_kind_are_refused_in_one_line_or_used(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    results = {kind: make() for kind, make in KINDS.items()}
    results |= {f"{kind}, in words": decode_flags(each) for kind, each in results.items()}
    troubles, calls = [], 0
    answers: dict[tuple[str, str, str], object] = {}
    for name, argument, several in calls_with_results(tmp_path):
        for kind, result in results.items():
            given = GIVEN[name](tmp_path) | {argument: [result, result] if several else result}
            calls += 1
            try:
                found = public()[name](**given)
            except RotorError as error:
                if "\n" in str(error):
                    troubles.append(f"{name}({argument} = {kind}): {error}")
            except Exception as error:
                troubles.append(f"{name}({argument} = {kind}): raw {type(error).__name__}: {error}")
            else:
                # words are refused, or make no difference
                numbers = answers.setdefault((name, argument, kind.partition(",")[0]), found)
                if isinstance(found, xr.Dataset) and not decode_flags(found).equals(
                    decode_flags(numbers)
                ):
                    troubles.append(f"{name}({argument} = {kind}): another result")
    assert not troubles, "\n".join(troubles)
    assert calls > 1200


def test_labelled_values_are_numbers_starts_and_ranges():
    """What comes out of one function goes into the next, and changes no bit."""
    whirls, responses = rotor_ida.synchronous_response(omega=[1.2], zeta=0.5, delta0=0.5), swept()
    again = rotor_ida.synchronous_response(
        omega=responses.omega, zeta=responses.zeta, delta0=responses.delta0
    )
    del again.attrs["question"], whirls.attrs["question"]  # numbers and axes, as each was asked
    assert again.identical(whirls)
    rest = xr.DataArray(list(REST), dims="component")
    assert rotor_ida.simulate(ROTOR, start=rest, duration=run().t[-1], samples=33).equals(run())
    table = np.array([REST])
    assert rotor_ida.sweep(omega=1.2, zeta=0.5, delta0=0.5, starts=table).equals(responses)
    plain, labelled = (
        rotor_ida.basin_fractions(ROTOR, x=ends, y=np.array(0.0), starts=np.array(5))
        for ends in ((-1.0, 1.0), xr.DataArray([-1.0, 1.0]))
    )
    assert labelled.equals(plain)
