"""Time against achieved error, for this program and others: a table, and a figure.

Tolerances from 1e-4 down to the tightest that a way takes, each tenth; the error is the worst one
of a state at 2,001 samples, against Taylor series at rtol 1e-15, whose own error is that of
rounding. All are measured in turn. heyoka's Taylor series cannot cross the kink of the contact law,
hence the third run.

    pip install -e '.[bench]' && python benchmarks/work_precision.py --out docs/work_precision.png
"""

import argparse
import importlib.util

import ways
from matplotlib.backends.backend_agg import FigureCanvasAgg
from measuring import clocked, in_turn, machine

from rotor_ida.plot.appearance import panels, style
from rotor_ida.plot.labels import parameter_text
from rotor_ida.plot.legends import shared_legend
from rotor_ida.plot.palette import BLUE, GREY, INK, ORANGE, PURPLE, RED

POWERS = range(4, 16)
# Function, the last power of ten that it takes as its tolerance, and how it is drawn.
WAYS = {
    "rotor_ida, Taylor": (ways.taylor, 14, INK, "P", "-"),
    "rotor_ida, CVODE": (ways.compiled, 13, BLUE, "o", "-"),
    "the same from Python": (ways.python, 13, RED, "s", "-"),
    "SciPy DOP853": (ways.dop853, 13, ORANGE, "^", "--"),
    "scikit-sundae, plainly": (ways.sundae, 13, PURPLE, "D", "--"),
    "heyoka": (ways.heyoka, 15, GREY, "v", "--"),
}


def measure(case, rounds):
    """Return, for each way, its errors and times over the tolerances; print them as a table."""
    print(f"\n**{case.name}** (worst state error / ms of processor time)\n")
    present = {
        name: entry[:2]
        for name, entry in WAYS.items()
        if name != "heyoka" or importlib.util.find_spec("heyoka")
    }
    print("| rtol | " + " | ".join(present) + " |\n|---|" + "---|" * len(present))
    curves = {name: ([], []) for name in present}
    made = {
        (name, power): make(case, 10.0**-power)
        for power in POWERS
        for name, (make, last) in present.items()
        if power <= last
    }
    times = in_turn({key: clocked(way) for key, way in made.items()}, rounds)
    for power in POWERS:
        rtol = 10.0**-power
        cells = []
        for name, (error, spent) in curves.items():
            key = (name, power)
            if key not in made:
                cells.append("")
                continue
            error.append(ways.errors(case, made[key]())[0])
            spent.append(times[key].median)
            cells.append(f"{error[-1]:.0e} / {1e3 * spent[-1]:.2f}")
        print(f"| {rtol:.0e} | " + " | ".join(cells) + " |", flush=True)
    return curves


def draw(results, path):
    """Draw error across, time up, one panel for each run."""
    figure, axes = panels(1, len(results), width=8.4, height=3.7)
    with style():
        for ax, (case, curves) in zip(axes, results, strict=True):
            for name, (error, spent) in curves.items():
                _, _, colour, marker, line = WAYS[name]
                known = [(e, 1e3 * s) for e, s in zip(error, spent, strict=True) if e > 0.0]
                # Where a way is wrong whatever its tolerance, a line would promise a trend.
                wrong = known[-1][0] > 1e-3
                ax.plot(
                    *zip(*known, strict=True),
                    color=colour,
                    marker=marker,
                    markersize=4.0,
                    markeredgecolor=INK,
                    markeredgewidth=0.3,
                    linestyle="none" if wrong else line,
                    label=name,
                )
            ax.set_xscale("log")
            ax.set_yscale("log")
            title = parameter_text({"omega": case.omega, "delta0": case.delta0})
            ax.set_title(f"{case.name}\n{title}")
            ax.set_xlabel("worst error of a state")
            ax.tick_params(which="minor", length=0.0)
        axes[0].invert_xaxis()
        axes[0].set_ylabel("time of a run (ms)")
        shared_legend(figure, axes, columns=3)
        FigureCanvasAgg(figure)
        figure.savefig(path, dpi=200, metadata={"Software": None})


def main():
    """Measure, print and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="work_precision.png")
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    print(f"{machine()}\n\nMedians of {arguments.rounds} rounds, in turn.")
    cases = [ways.FULL_CONTACT, ways.BOUNCING, ways.in_contact_from_start()]
    results = [(case, measure(case, arguments.rounds)) for case in cases]
    draw(results, arguments.out)


if __name__ == "__main__":
    main()
