"""Kill studies with signal 9 at random moments, resume them, and compare with undisturbed ones.

    python benchmarks/kills.py --kills 100

Each study is begun by the command line in a process of its own, killed, resumed, killed again,
until one session gets to the end. Then its folder must hold its store and its result and nothing
else, and the result must be, bit for bit, that of a study which nobody disturbed.
"""

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import rotor_ida

PROGRAM = [sys.executable, "-c", "import sys, rotor_ida.cli; sys.exit(rotor_ida.cli.main())"]
STUDIES = {
    "sweep": "sweep --omega 0.5:3:120 --zeta 0.07 --delta0 0 0.5 1 2",
    "sweep up and down": (
        "sweep --omega 0.5:3:30 --zeta 0.07 0.1 0.15 0.2 --delta0 0.5 1 2 --direction both"
    ),
    "basin": "basin --omega 2 --zeta 0.07 --delta0 2 --x=-15:15:300 --y=-15:15:300",
    "basin_fractions": (
        "fractions --omega 3 --zeta 0.07 --delta0 0.5 --x=-9:9 --y=-9:9 --vx=-5:5 --vy=-5:5 "
        "--starts 60000"
    ),
}


def undisturbed(words, folder):
    """Return the result of a study that nobody disturbs, and the time that it takes [s]."""
    began = time.monotonic()
    subprocess.run(
        [*PROGRAM, *words, "--study", str(folder)], check=True, stdout=subprocess.DEVNULL
    )
    return rotor_ida.load(folder / "result.nc"), time.monotonic() - began


def session(words, longest, chance):
    """Begin or go on with a study and kill it somewhere within a time; return its exit status."""
    running = subprocess.Popen([*PROGRAM, *words], stdout=subprocess.DEVNULL)
    try:
        return running.wait(timeout=chance.uniform(0.0, longest))
    except subprocess.TimeoutExpired:
        running.send_signal(signal.SIGKILL)
        return running.wait()


def differences(one, other):
    """Return the names of the variables that are not the same, bit for bit."""
    if set(one.variables) != set(other.variables):
        return sorted(set(one.variables) ^ set(other.variables))
    return [
        name
        for name in one.variables
        if one[name].dtype != other[name].dtype
        or one[name].shape != other[name].shape
        or np.ascontiguousarray(one[name].values).tobytes()
        != np.ascontiguousarray(other[name].values).tobytes()
    ]


def disturbed(words, folder, longest, chance, most):
    """Kill and resume a study until it is done; return the number of kills."""
    kills = 0
    begin = [*words, "--study", str(folder)]
    while True:
        # the same words, or the command resume: both go on
        again = begin if chance.random() < 0.5 or kills == 0 else ["resume", str(folder)]
        status = session(again, longest if kills < most else 600.0, chance)
        if status == 0:
            return kills
        if status == -signal.SIGKILL:
            kills += 1
        elif again == begin:  # else it was killed before there was anything to resume
            raise SystemExit(f"{' '.join(again)} ended with status {status}")


def main():
    """Print a table: kills, sessions that ended, and what differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    chance = random.Random(given.seed)
    total, faults = 0, 0
    with tempfile.TemporaryDirectory() as place:
        root = Path(place)
        wanted = {name: undisturbed(words.split(), root / name) for name, words in STUDIES.items()}
        studies = 0
        while total < given.kills:
            name = list(STUDIES)[studies % len(STUDIES)]
            result, alone = wanted[name]
            folder = root / f"disturbed {studies}"
            kills = disturbed(
                STUDIES[name].split(), folder, 0.7 * alone, chance, given.kills - total
            )
            left = sorted(set(os.listdir(folder)) - {"study.json", "pieces", "result.nc"})
            differing = differences(rotor_ida.load(folder / "result.nc"), result)
            total, studies = total + kills, studies + 1
            faults += bool(left) + bool(differing)
            print(
                f"{name}: {kills} kills; left over: {left or 'nothing'}; "
                f"differing: {differing or 'nothing'}",
                flush=True,
            )
    print(f"{total} kills in {studies} studies, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
