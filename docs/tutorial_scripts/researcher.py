"""
Five minutes for a researcher
=============================

One orbit, from its events to its basin: each step with a number that says how far it can be trusted.

You need Python 3.11 or newer and two lines in a shell::

    python3 -m venv .venv
    .venv/bin/pip install . jupyterlab

in a clone of the repository; from the first release on, ``rotor-ida`` in place of the dot will do. Then open the notebook at the end of
this page with ``.venv/bin/jupyter lab``; or start ``.venv/bin/python`` and copy the blocks one by one. Where a
block ends with a figure, a notebook shows it; at the prompt of Python, save it: ``figure.savefig("name.png")``.

An orbit and its events
-----------------------

A rotor is three numbers: spin speed ω, damping ratio ζ and clearance δ₀, in units of the eccentricity
and of a frequency that mass and contact set (:doc:`/model`).
"""

from rotor_ida import Rotor, simulate

rotor = Rotor(omega=2.0, zeta=0.07, delta0=2.0)
run = simulate(rotor, start=(0, 0, 0, 0), duration=100.0)
columns = ["event_time", "event_time_error"]
run[columns].to_dataframe()[columns].head()

# %%
# Every time at which the disc enters or leaves contact is a root of \|z\| = δ₀, and carries an estimate
# of its error. A second method that shares no step with CVODE, Taylor series, is the witness: the
# largest difference of two event times, over the sum of the errors that both state, is below one.

witness = simulate(rotor, start=(0, 0, 0, 0), duration=100.0, method="taylor", rtol=1e-14)
apart = abs(run.event_time - witness.event_time)
float((apart / (run.event_time_error + witness.event_time_error)).max())

# %%
# :doc:`/events` says how events are found, and which grazes can be told from misses.
from rotor_ida.plot import plot_run

figure = plot_run(run)
figure

# %%
# Against the closed form
# -----------------------
#
# ``sweep`` follows a rotor until it has settled; ``compare`` holds that against every exact whirl and
# limit cycle, and counts the digits that agree.

from rotor_ida import compare, sweep

compare(sweep(omega=[1.2, 1.7], zeta=0.07, delta0=[0.0, 0.5])).digits.squeeze().to_pandas()

# %%
# Its limit cycle
# ---------------
#
# At ω = 2, δ₀ = 2 the rotor settles on no whirl: it bounces. On axes that turn with the unbalance that
# motion is a closed curve. Shooting finds it to rounding, with its multipliers.

from rotor_ida import limit_cycle

cycle = limit_cycle(rotor, start=(0, 0, 0, 0))
print(f"period {float(cycle.period):.13g} +- {float(cycle.period_error):.1g}")
print("multipliers", (cycle.multiplier_real + 1j * cycle.multiplier_imag).values.round(6))

# %%
from rotor_ida.plot import cycle_figure

figure = cycle_figure(cycle)
figure

# %%
# Its branch
# ----------
#
# Followed over the speed, round folds and through grazes, until the branch closes or leaves the range.
# The table of special points says where it folds, doubles its period or grazes.

from rotor_ida import continue_cycle, decode_flags
from rotor_ida.plot import panels, plot_branch

branch = continue_cycle(rotor, start=cycle, limits=(0.05, 5.0))
kinds = decode_flags(branch.special_kind).values
for kind, speed in zip(kinds, branch.special_value.values, strict=True):
    print(f"{kind:16s} at omega = {speed:.10f}")

# %%
figure, (ax,) = panels(1, 1, width=6.4, height=3.6)
plot_branch(branch, ax=ax)
figure

# %%
# Its basin
# ---------
#
# From which starts, at rest, does the rotor end on this cycle? Most starts are followed until a region,
# proven or estimated, holds them, the rest until they settle (:doc:`/basins`). ``agreement`` is the part of
# the labels that come out the same with a smaller error.

import numpy as np

from rotor_ida import basin
from rotor_ida.plot import plot_basin

axis = np.linspace(-15.0, 15.0, 121)
found = basin(rotor, x=axis, y=axis)
for kind, fraction in zip(decode_flags(found.kind).values, found.fraction.values, strict=True):
    print(f"{kind:13s} {fraction:.3f} of the starts")
print(
    f"{float(found.agreement):.0%} of {int(found.agreement_count)} labels found again are the same"
)

# %%
figure, (ax,) = panels(1, 1, width=5.2, height=4.6)
plot_basin(found, ax=ax)
figure

# %%
# Keep it
# -------
#
# An archive is netCDF that any reader opens; ``rotor-ida verify`` computes it again from what the file
# says of itself.

import tempfile
from pathlib import Path

from rotor_ida import load, save

path = Path(tempfile.mkdtemp()) / "run.nc"
save(run, path)
load(path).equals(run)

# %%
# Where to go on: :doc:`/cycles` has the theory of the cycles, :doc:`/archive` the format, and
# :doc:`/gallery/index` every figure of the paper beside what is right.
