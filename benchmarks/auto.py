r"""AUTO-07p beside this program: the same limit cycles, their multipliers and their branches.

Each table by its own name, or both; needs gfortran and make, with which bifpy builds AUTO:

    pip install -e '.[bench]' && python benchmarks/auto.py
    python benchmarks/auto.py cycles

- cycles: errors of period and multipliers of three cycles, held against shooting with SciPy's
  DOP853 restarted at every event, which is right to 1e-11;
- branches: folds, period doublings and torus bifurcations along a branch, the digits of omega in
  which AUTO agrees with this program, and times a point.

AUTO solves for a cycle by collocation, on NTST intervals of 4 points each; contact begins and ends
inside some of them. It prints periods with 11 digits and multipliers with six: an error of 0 is one
below 5e-6. The trivial multiplier of this program is 1 by construction; what stands for its error
is that of the monodromy matrix times the rate of change. AUTO's model is compiled, and the
executable alone is timed. bifpy builds AUTO without optimisation; for a fair race, install it so:

    MAKEFLAGS='F90=gfortran\ -O3 F77=gfortran\ -O3' pip install --no-cache-dir bifpy
"""

import argparse
import importlib.util
import math
import shutil
import statistics
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version

import numpy as np
from measuring import clocked, in_turn, machine, ratio
from scipy.integrate import solve_ivp

from rotor_ida import Rotor, continue_cycle, limit_cycle

MESHES = (20, 80, 320)
ROUNDS = 3
MOST_POINTS = 500
TOLERANCE = 1e-8
# Two special points of one kind are the same where omega differs by less, in parts of it.
NEAR = 2e-3
# Places in AUTO's list of parameters.
OMEGA, PERIOD = 1, 11
KINDS = {"FOLD": "fold", "PERIOD_DOUBLING": "period_doubling", "TORUS": "torus"}


@dataclass(frozen=True)
class Case:
    """A cycle to start from, on the rotating axes, how its branch is followed, and a known cycle.

    AUTO passes the known cycle at once: its first point is the one given to it, not one it found.
    """

    name: str
    delta0: float
    omega: float
    start: tuple[float, float, float, float]
    period: float
    known_omega: float
    known_period: float
    known_pair: tuple[complex, complex]
    limits: tuple[float, float]
    longest_step: float
    zeta: float = 0.07

    def rotor(self, omega):
        """Return the rotor at a speed."""
        return Rotor(omega=omega, zeta=self.zeta, delta0=self.delta0)

    @property
    def known_multipliers(self):
        """The known cycle's multipliers: 1, its partner and the pair."""
        return (1.0, math.exp(-2.0 * self.zeta * self.known_period), *self.known_pair)


# The first two branches close; the sliver is a piece of the first. AUTO's longest step is its
# default, 0.1, but on the sliver, whose two ends lie about 0.02 apart.
CASES = (
    Case(
        name="bouncing",
        delta0=2.0,
        omega=1.98,
        start=(-2.4727059219186573, -3.243048955908284, 1.3136804977793057, -0.998823905378841),
        period=4.609324165468,
        known_omega=2.0,
        known_period=4.563916675380,
        known_pair=(-0.51147221409 + 0.51598781494j, -0.51147221409 - 0.51598781494j),
        limits=(0.3, 5.0),
        longest_step=0.1,
    ),
    Case(
        name="full contact",
        delta0=0.5,
        omega=2.98,
        start=(-2.5869296393748753, -1.4426292589081702, 1.5483459564046274, -2.766486345895145),
        period=3.136579030836,
        known_omega=3.0,
        known_period=3.115214254929,
        known_pair=(0.53147652352 + 0.60337913357j, 0.53147652352 - 0.60337913357j),
        limits=(2.0, 5.0),
        longest_step=0.1,
    ),
    Case(
        name="sliver",
        delta0=2.0,
        omega=0.3995,
        start=(-1.30931623991648, -2.033672177060268, 0.274543776777076, -0.18098213935044058),
        period=22.042579472282,
        known_omega=0.4,
        known_period=22.016240259964,
        known_pair=(-0.71954819843, -0.06372732336),
        limits=(0.39, 0.41),
        longest_step=0.02,
    ),
)


def field(state, parameters):
    """Return the rates of change on the rotating axes, of numbers or of AUTO's symbols."""
    x, y, vx, vy = (state[i] for i in range(4))
    omega, zeta, delta0 = (parameters[i] for i in range(3))
    radius = np.sqrt(x * x + y * y)
    restoring = np.maximum(radius - delta0, 0.0) ** 1.5 / radius
    return [
        vx + omega * y,
        vy - omega * x,
        omega * omega - 2 * zeta * vx + omega * vy - restoring * x,
        -2 * zeta * vy - omega * vx - restoring * y,
    ]


def orbit(case):
    """Return the times and states of one period."""
    found = solve_ivp(
        lambda _time, state: field(state, (case.omega, case.zeta, case.delta0)),
        (0.0, case.period),
        case.start,
        method="DOP853",
        t_eval=np.linspace(0.0, case.period, 2001),
        rtol=1e-11,
        atol=1e-12,
    )
    return found.t.tolist(), found.y.T.tolist()


def follow(auto, case, intervals, direction):
    """Let AUTO follow a branch one way, once round if it closes; return its points and folder."""

    def begin(state, parameters, _time):
        state[:] = [0.0] * 4
        parameters[:3] = [case.omega, case.zeta, case.delta0]
        parameters[PERIOD - 1] = case.period

    result = auto.run(
        field,
        begin,
        {
            "ips": auto.IPS_PERIODIC_ORBIT, "ndim": 4, "npar": 3, "nmx": MOST_POINTS, "mxbf": 0,
            "ntst": intervals, "ncol": 4, "itmx": 20, "itnw": 9, "nwtn": 5,
            "epsl": TOLERANCE, "epsu": TOLERANCE, "epss": 10 * TOLERANCE,
            "ds": 0.05 * direction * case.longest_step, "dsmax": case.longest_step,
            "dsmin": 1e-6 * case.longest_step, "rl0": case.limits[0], "rl1": case.limits[1],
        },
        icu=[OMEGA, PERIOD],
        dat=orbit(case),
        # Three passes of an omega near the start are a round, or one and a half.
        uzr={OMEGA: case.known_omega},
        stop=["UZ3"],
        transpile=True,
        keep_output=True,
    )  # fmt: skip
    return [point for branch in result.branches for point in branch.points], result.output_directory


def errors(case, period, multipliers):
    """Return the errors of the period, of the trivial multiplier and of the worst of the others."""
    nearest = [min(abs(found - right) for found in multipliers) for right in case.known_multipliers]
    return abs(period / case.known_period - 1.0), nearest[0], max(nearest[1:])


def cycles(auto, _rounds):
    """Print the errors of the known cycles."""
    print("\n| cycle | way | period | trivial multiplier | other multipliers |")
    print("|---|---|---|---|---|")
    for case in CASES:
        ours = limit_cycle(case.rotor(case.known_omega), start=case.start, period=case.period)
        multipliers = ours.multiplier_real.values + 1j * ours.multiplier_imag.values
        period, _, others = errors(case, ours.period.item(), multipliers)
        rows = {"this program": (period, ours.trivial_defect.item(), others)}
        for intervals in MESHES:
            points, folder = follow(auto, case, intervals, 1)
            shutil.rmtree(folder)
            known = next(p for p in points if p.point_type.name == "USER_SPECIFIED_VALUE")
            rows[f"AUTO, NTST {intervals}"] = errors(
                case, known.parameters[1], known.floquet_multipliers
            )
        for way, row in rows.items():
            numbers = [f"{error:.0e}" if error else "0" for error in row]
            print(f"| {case.name} | {way} | {' | '.join(numbers)} |", flush=True)


def special_points(branch):
    """Return kind and omega of the folds and period doublings of one of this program's branches."""
    names = branch.special_kind.attrs["flag_meanings"].split()
    flags = np.atleast_1d(branch.special_kind.attrs["flag_values"]).tolist()
    meaning = dict(zip(flags, names, strict=True))
    kinds = [meaning[int(kind)] for kind in branch.special_kind.values]
    pairs = zip(kinds, branch.special_value.values.tolist(), strict=True)
    return [pair for pair in pairs if pair[0] in KINDS.values()]


def agreement(right, found):
    """Return in words which of the special points were found, to how many digits, and what else."""
    words, rest = [], list(found)
    for kind, omega in right:
        same = [f for f in rest if f[0] == kind and abs(f[1] / omega - 1.0) < NEAR]
        rest = [f for f in rest if f not in same]
        worst = max((abs(f[1] / omega - 1.0) for f in same), default=0.0)
        digits = f"{-math.log10(max(worst, 1e-12)):.1f}" if same else "missed"
        words.append(f"{kind} {omega:.4f}: {digits}")
    words += [f"{kind} {omega:.4f}: spurious" for kind, omega in rest]
    return ", ".join(words)


def branches(auto, rounds):
    """Print the special points that each found, and times a point."""
    print("\n| branch | way | points | digits of omega | ms a point | times this program's |")
    print("|---|---|---|---|---|---|")
    for case in CASES:
        rotor = case.rotor(case.omega)
        start = limit_cycle(rotor, start=case.start, period=case.period)
        ours = partial(continue_cycle, rotor, start=start, limits=case.limits)
        branch = ours()
        right = special_points(branch)
        ways, sizes, words = {"this program": ours}, {"this program": branch.sizes["point"]}, {}
        folders = []
        for intervals in MESHES:
            way, points = f"AUTO, NTST {intervals}", []
            runs = [follow(auto, case, intervals, direction) for direction in (1, -1)]
            for found, folder in runs:
                points += found
                folders.append(folder)
            ways[way] = partial(run_again, [folder for _, folder in runs])
            sizes[way] = len(points)
            words[way] = agreement(
                right,
                [
                    (KINDS[point.point_type.name], point.parameters[0])
                    for point in points
                    if point.point_type.name in KINDS
                ],
            )
        times = in_turn({name: clocked(way) for name, way in ways.items()}, rounds)
        for folder in folders:
            shutil.rmtree(folder)
        words["this program"] = ", ".join(f"{kind} {omega:.10f}" for kind, omega in right)
        for way, size in sizes.items():
            each = statistics.median(times[way].wall) / size
            slower = ratio(times[way], times["this program"])[1] * sizes["this program"] / size
            row = (case.name, way, size, words[way], f"{1e3 * each:.2f}", f"{slower:.2f}")
            print(f"| {' | '.join(map(str, row))} |", flush=True)


def run_again(folders):
    """Run the compiled model in each folder where AUTO has followed a branch."""
    for folder in folders:
        subprocess.run(["./model_exe"], cwd=folder, check=True, capture_output=True)


TABLES = {table.__name__: table for table in (cycles, branches)}


def main():
    """Print the tables asked for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=", ".join(TABLES))
    parser.add_argument("--rounds", type=int, default=ROUNDS)
    arguments = parser.parse_args()
    unknown = set(arguments.tables) - set(TABLES)
    if unknown:
        parser.error(f"no table {', '.join(sorted(unknown))}: choose from {', '.join(TABLES)}")
    if importlib.util.find_spec("bifpy") is None:
        sys.exit("AUTO is missing: pip install -e '.[bench]', which needs gfortran and make")
    if shutil.which("gfortran") is None:
        sys.exit("gfortran is missing, which compiles the model for AUTO: install it first")
    from bifpy import auto  # noqa: PLC0415 - an optional extra

    print(f"{machine()}, bifpy {version('bifpy')}")
    print(f"\nMedians of {arguments.rounds} rounds, in turn.")
    for name in arguments.tables or TABLES:
        TABLES[name](auto, arguments.rounds)


if __name__ == "__main__":
    main()
