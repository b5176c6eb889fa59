"""How a study grows: starts a second, bytes a start, and memory, by the number of starts.

    python benchmarks/size.py --cells 500 1000 2000

Basins of growing grids, each as a study in a process of its own, for a rotor whose starts are all
captured and for one most of whose starts are not. From the last lines follows what a study of 10^9
starts takes.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

ROTORS = {"captured": (1.7, 0.07, 0.0), "mostly not captured": (2.0, 0.07, 2.0)}

SCRIPT = """
import json, os, resource, sys, time
import numpy as np
import rotor_ida
omega, zeta, delta0, cells, folder = json.loads(sys.argv[1])
rotor = rotor_ida.Rotor(omega=omega, zeta=zeta, delta0=delta0)
small = np.linspace(-15.0, 15.0, 8)
rotor_ida.basin(rotor, x=small, y=small)
axis = np.linspace(-15.0, 15.0, cells)
at_first = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
clock = [time.perf_counter()]
def progress(done, total):
    if done == total:
        clock.append(time.perf_counter())
found = rotor_ida.basin(rotor, x=axis, y=axis, study=folder, progress=progress)
clock.append(time.perf_counter())
rotor_ida.save(found, folder + "/result.nc")
clock.append(time.perf_counter())
at_last = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
pieces = [os.path.getsize(each.path) for each in os.scandir(folder + "/pieces")]
sizes = [sum(pieces), os.path.getsize(folder + "/result.nc")]
print(json.dumps([np.diff(clock).tolist(), sizes, at_first, at_last]))
"""


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cells", type=int, nargs="+", default=[500, 1000, 2000])
    given = parser.parse_args()
    print("rotor, starts: starts/s, sort and gather [us/start], save [us/start]; "
          "store and result [bytes/start]; memory at first, at last [MiB]")  # fmt: skip
    for name, parameters in ROTORS.items():
        for cells in given.cells:
            with tempfile.TemporaryDirectory() as folder:
                job = json.dumps([*parameters, cells, str(Path(folder, "study"))])
                ended = subprocess.run(
                    [sys.executable, "-c", SCRIPT, job], check=True, capture_output=True, text=True
                )
            (follow, gather, save), (store, result), first, last = json.loads(ended.stdout)
            count = cells**2
            print(
                f"{name}, {count}: {count / follow:.0f}/s, {1e6 * gather / count:.2f}, "
                f"{1e6 * save / count:.2f}; {store / count:.1f}, {result / count:.2f}; "
                f"{first / 1024:.0f}, {last / 1024:.0f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
