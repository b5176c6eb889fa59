"""
Basins and branches
===================

Compute one periodic motion with its events, its limit cycle, its branch over the speed, and its basin of attraction. Each step has an
estimate of its accuracy.

Open the notebook at the end of this page in Jupyter, or copy the blocks into ``python`` one by one (:doc:`/install`).

An orbit and its events
-----------------------

The paper's rotor has three parameters: spin speed ω, damping ratio ζ and clearance δ₀. They are dimensionless (:doc:`/model`).
"""

from rotor_ida import Rotor, simulate

rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
run = simulate(rotor, start=(0, 0, 0, 0), duration=100.0)
columns = ["event_time", "event_time_error"]
run[columns].to_dataframe()[columns].head()

# %%
# Each contact entry or exit is a root of \|z\| = δ₀ with an error estimate. The estimate is ten times the difference from a second,
# tighter run by Taylor series. For a check that shares neither steps nor variables, repeat the run with the plain reference in Python:
# the largest difference of two event times, over the sum of both stated errors, is below one.

check = simulate(rotor, duration=100.0, backend="python")
apart = abs(run.event_time - check.event_time)
float((apart / (run.event_time_error + check.event_time_error)).max())

# %%
# :doc:`/events` explains how events are found, and which grazes may be missed.
from rotor_ida.plot import plot_run

figure = plot_run(run)
figure

# %%
# Compare with exact responses
# ----------------------------
#
# ``sweep`` follows a rotor until it settles. ``compare`` matches the result with every exact whirl and limit cycle, and counts the
# digits that agree.

from rotor_ida import compare, sweep

compare(sweep(omega=[1.2, 1.7], zeta=0.07, delta0=[0.0, 0.5])).digits.squeeze().to_pandas()

# %%
# The limit cycle
# ---------------
#
# At ω = 2, δ₀ = 2 the rotor bounces. On axes that rotate with the unbalance this motion is a closed curve. Shooting computes it to
# machine precision, with its multipliers.

from rotor_ida import limit_cycle

cycle = limit_cycle(rotor, start=(0, 0, 0, 0))
print(f"period {float(cycle.period):.13g} +- {float(cycle.period_error):.1g}")
print("multipliers", (cycle.multiplier_real + 1j * cycle.multiplier_imag).values.round(6))

# %%
from rotor_ida.plot import cycle_figure

figure = cycle_figure(cycle)
figure

# %%
# The branch
# ----------
#
# ``continue_cycle`` follows the cycle over the speed, round folds and through grazes, until the branch closes or leaves the range. Special
# points are folds, period doublings and grazes.

from rotor_ida import continue_cycle
from rotor_ida.plot import panels, plot_branch
from rotor_ida.schema import SPECIAL

branch = continue_cycle(rotor, start=cycle, limits=(0.05, 5.0))
names = {number: word for word, number in SPECIAL.items()}
for kind, speed in zip(branch.special_kind.values, branch.special_value.values, strict=True):
    print(f"{names[int(kind)]:16s} at omega = {speed:.10f}")

# %%
figure, (ax,) = panels(1, 1, width=6.4, height=3.6)
plot_branch(branch, ax=ax)
figure

# %%
# The basin
# ---------
#
# Which starts at rest lead to this cycle? Most orbits are followed until they enter a trapping region, the rest until they settle
# (:doc:`/basins`). ``agreement`` is the fraction of labels that stay the same with a smaller step error.

import numpy as np

from rotor_ida import basin
from rotor_ida.plot import plot_basin
from rotor_ida.schema import RESPONSE

axis = np.linspace(-15.0, 15.0, 121)
found = basin(rotor, x=axis, y=axis)
kinds = {number: word for word, number in RESPONSE.items()}
for kind, fraction in zip(found.kind.values, found.fraction.values, strict=True):
    print(f"{kinds[int(kind)]:13s} {fraction:.3f} of the starts")
print(f"{float(found.agreement):.0%} of {int(found.agreement_count)} repeated labels are the same")

# %%
figure, (ax,) = panels(1, 1, width=5.2, height=4.6)
plot_basin(found, ax=ax)
figure

# %%
# Keep it
# -------
#
# An archive is a netCDF file that any reader opens. ``rotor-ida verify`` recomputes it from its attributes.

import tempfile
from pathlib import Path

from rotor_ida import load, save

path = Path(tempfile.mkdtemp()) / "run.nc"
save(run, path)
load(path).equals(run)

# %%
# Next: :doc:`/cycles` explains the cycles, :doc:`/archive` the format, and :doc:`/gallery/index` has every figure of the paper
# with corrections.
