"""Whether results are the same to the last bit, whoever compiled the core and for which processor.

    python tests/same_bits.py [--outside]

The same results, of runs by every compiled method, cycles, exponents, sweeps and basins, are
computed in one process for each level of the processor, and for the libraries that each other C
compiler here makes. Any difference is a failure. With --outside what lies outside the core is
changed as well: the mathematical library (GLIBC_TUNABLES), the vectors of NumPy
(NPY_DISABLE_CPU_FEATURES), and the kernels of OpenBLAS (OPENBLAS_CORETYPE); what moves with these,
and by how much, is listed.
"""

import argparse
import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from runpy import run_path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
OUTSIDE = {
    "libm without FMA and AVX2": {
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2_Usable,-FMA_Usable,-AVX2,-FMA,-FMA4"
    },
    "NumPy without AVX-512": {"NPY_DISABLE_CPU_FEATURES": "AVX512F AVX512CD AVX512_SKX"},
    "NumPy without AVX2 and FMA": {
        "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX"
    },
    "OpenBLAS for Haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "OpenBLAS for Nehalem": {"OPENBLAS_CORETYPE": "Nehalem"},
}


def results():
    """Return results of every kind by name, as arrays of numbers."""
    from rotor_ida import (
        Bearing,
        Contact,
        Race,
        Rotor,
        RotorSystem,
        Unbalance,
        basin,
        limit_cycle,
        lyapunov_exponent,
        run_up,
        simulate,
        sweep,
    )

    found = {}

    def keep(name, dataset):
        for variable in dataset.variables:
            if dataset[variable].dtype.kind in "fiu":
                found[f"{name}: {variable}"] = dataset[variable].values

    rest = (0.0, 0.0, 0.0, 0.0)
    rotors = {
        "bouncing": (Rotor(omega=2.0, zeta=0.07, delta0=2.0), rest),
        "full contact": (Rotor(omega=3.0, zeta=0.07, delta0=0.5), (3.0, 1.0, 0.0, 0.0)),
        "no clearance": (Rotor(omega=1.7, zeta=0.07, delta0=0.0), rest),
        "slow": (Rotor(omega=0.6, zeta=0.07, delta0=2.0), rest),
    }
    for word, (rotor, start) in rotors.items():
        for how in ("taylor", "adams", "bdf", "cvode"):
            options = {"flight": how} if how == "cvode" else {"method": how}
            keep(f"run, {word}, {how}", simulate(rotor, start=start, duration=100.0, **options))
    turned = 0.2 * np.array([[0.0, 1.0], [-1.0, 0.0]])
    system = RotorSystem(
        mass=np.kron([[2.0, 0.1], [0.1, 1.0]], np.eye(2)),
        stiffness=np.kron([[2.0, -1.0], [-1.0, 1.5]], np.eye(2)), damping=0.1 * np.eye(4),
        gyroscopic=np.kron(np.eye(2), turned), nodes={"a": (0, 1), "b": (2, 3)}, units="1",
    )  # fmt: skip
    rubs = {"clearance": 0.5, "stiffness": 20.0, "friction": 0.2, "radius": 2.0, "damping": 0.3}
    around = {
        "contacts": [Contact(node=node, **rubs) for node in "ab"],
        "unbalance": [Unbalance(node="a", moment=1.0)],
    }
    for method in ("taylor", "adams", "bdf"):
        run = simulate(system, speed=1.1, duration=100.0, method=method, **around)
        keep(f"system, {method}", run)
    race = Race(radius=2.0, inertia=0.5, drag=0.2)
    around["contacts"] = [Contact(node=node, **rubs, race=race) for node in "ab"]
    keep("system with races", simulate(system, speed=1.1, duration=100.0, **around))
    keep("system, run-up", run_up(system, speed=0.3, to=2.0, rate=0.02, **around))
    rows = np.multiply.outer([0.5, 1.0, 0.8], [[0.3, 0.2], [-0.1, 0.4]])
    film = Bearing(node="b", speed=[0.3, 0.9, 2.0], stiffness=rows, damping=0.5 * rows)
    keep("system, film", run_up(system, speed=0.3, to=2.0, rate=0.02, bearings=[film], **around))
    for word in ("bouncing", "full contact"):
        rotor, start = rotors[word]
        keep(f"cycle, {word}", limit_cycle(rotor, start=start))
    chaotic = Rotor(omega=1.38, zeta=0.07, delta0=1.0)
    for method in ("taylor", "adams"):
        told = lyapunov_exponent(
            chaotic, start=(1.5, -0.25, 0.0, 0.0), transient=50.0, duration=200.0, method=method
        )
        keep(f"exponents, {method}", told)
    machine = Rotor(omega=0.5, zeta=0.05, delta0=1.0, shaft_stiffness=0.3, contact_damping=0.2,
                    load=0.1, friction=0.2, disc_radius=2.0)  # fmt: skip
    drives = {"ramp": {"to": 2.0, "rate": 0.05},
              "torque": {"torque": (4.0, 1.0), "inertia": 20.0, "duration": 30.0}}  # fmt: skip
    for word, drive in drives.items():
        for method in ("taylor", "adams"):
            keep(f"run-up, {word}, {method}", run_up(machine, start=rest, method=method, **drive))
    keep("run-up, paper's", run_up(rotors["bouncing"][0], start=rest, to=2.2, rate=1e-3))
    keep("sweep", sweep(omega=[1.2, 2.0], zeta=0.07, delta0=[0.0, 0.5, 2.0], starts=[rest]))
    places = np.linspace(-15.0, 15.0, 24)
    for delta0 in (0.0, 1.0, 2.0):
        keep(f"basin, {delta0:g}", basin(Rotor(omega=1.7, zeta=0.07, delta0=delta0), x=places,
                                         y=places))  # fmt: skip
    loaded = Rotor(omega=1.7, zeta=0.1, delta0=1.0, shaft_stiffness=0.4, load=0.3)
    keep("basin, under a load", basin(loaded, x=places, y=places))
    return found


def write(path, libraries):
    """Write all results into a file, with the libraries of a folder if one is given."""
    if libraries:
        from rotor_ida.core import library

        library.FOLDER = Path(libraries)
    np.savez(path, **results())


def computed(folder, name, settings, libraries=""):
    """Return the results of a process with some settings of its environment."""
    path = Path(folder) / f"{name}.npz"
    words = [sys.executable, __file__, "--write", str(path), "--libraries", libraries]
    subprocess.run(words, check=True, env=os.environ | settings)
    with np.load(path) as held:
        return {"name": name, **{each: held[each] for each in held.files}}


def differing(expected, found):
    """Return the names of results that differ in a bit, each with its largest difference."""
    told = {}
    for name, values in expected.items():
        if name == "name":
            continue
        if name not in found or values.shape != found[name].shape:
            told[name] = float("nan")
        elif values.tobytes() != found[name].tobytes():
            told[name] = float(np.nanmax(np.abs(values.astype(float) - found[name].astype(float))))
    return told


def compilers():
    """Return the words that call each C compiler here, by name."""
    found = {name: shutil.which(name) for name in ("gcc", "clang")}
    words = {name: [path] for name, path in found.items() if path}
    if importlib.util.find_spec("ziglang"):
        words["zig cc, which is clang"] = [sys.executable, "-m", "ziglang", "cc"]
    return words


def compare(folder, outside):
    """Compare levels, compilers and what is outside; return how many give the same bits or not."""
    from rotor_ida.core.library import build_info, offered

    hatch_build = run_path(str(ROOT / "hatch_build.py"))
    levels = offered()
    ends = sorted({levels[0], levels[-1]})
    ways = [(f"level {level}", {"ROTOR_IDA_CPU": level}) for level in levels]

    def version(said):  # cc may be gcc by another name
        return said.partition(" ")[2]

    installed = version(build_info()["compiler"])
    for name, words in compilers().items():
        if version(hatch_build["described"](words)) == installed:
            continue  # it made the installed core of these very sources
        made = Path(tempfile.mkdtemp(dir=folder))
        hatch_build["build"](words, out=made, only=ends)
        for level in ends:
            ways.append((f"{name}, {level}", {"ROTOR_IDA_CPU": level}, str(made)))
    with ThreadPoolExecutor(os.cpu_count()) as processes:
        first, *others = processes.map(
            lambda way: computed(folder, *way), [*ways, *outside.items()]
        )
    others, moved = others[: len(ways) - 1], others[len(ways) - 1 :]
    wrong = 0
    print(f"{len(first) - 1} arrays of the installed core, level baseline, beside:")
    for other in others:
        told = differing(first, other)
        wrong += bool(told)
        print(f"  {other['name']}: {'the same bits' if not told else f'{len(told)} differ'}")
        for each, size in list(told.items())[:5]:
            print(f"    {each}: by up to {size:.3g}")
    if moved:
        print("What else moves (chaos makes the last bit another orbit; none is a failure):")
    for other in moved:
        told = differing(first, other)
        by_kind = {}
        for each, size in told.items():
            kind = each.split(":")[0]
            by_kind[kind] = max(by_kind.get(kind, 0.0), 0.0 if np.isnan(size) else size)
        said = ", ".join(f"{kind} by up to {size:.1g}" for kind, size in by_kind.items())
        print(f"  {other['name']}: {said or 'nothing'}")
    return len(others) - wrong, wrong


def main():
    """Write results, or compare those of all ways to have them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", metavar="FILE", help=argparse.SUPPRESS)
    parser.add_argument("--libraries", default="", help=argparse.SUPPRESS)
    parser.add_argument("--outside", action="store_true", help="what other libraries move, too")
    given = parser.parse_args()
    if given.write:
        write(given.write, given.libraries)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        same, wrong = compare(folder, OUTSIDE if given.outside else {})
    print(f"{same} passed, {wrong} failed")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
