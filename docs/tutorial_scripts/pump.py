r"""
A pump rotor, from its data sheet to a verdict
==============================================

Find out in ten minutes whether a rotor rubs on its way up to speed, how hard it rubs, and whether it ends in dry
whip. Then read the same from measured signals. You need an installation (:doc:`/install`) and six commands.
Beside each command is the Python that does the same; the output is that of the Python. If you have followed the README,
keep its ``pump.toml`` and ``pump.nc`` and go on with step 3.

1. Write down the machine
-------------------------

A pump rotor of 12 kg runs on a shaft of 4 N/µm with a damping ratio of 3 %. It is balanced to G6.3 for its
running speed of 3,600 rpm, and we take it beyond that speed. The pump is dry: no fluid force acts in the wear ring. The shaft is vertical,
so it carries no weight; add ``--load weight`` for a horizontal one. The wear ring leaves 150 µm of radial clearance, is as stiff as 100 N/µm, has a coefficient of friction of 0.12, and
meets the rotor at a radius of 60 mm. If you do not know the stiffness, try 1e7 to 1e9 N/m: the speed of the first touch does not
depend on it, the force does::

    rotor-ida machine --mass 12kg --shaft-stiffness 4e6N/m --damping-ratio 3% \
        --clearance 150um --balance-grade G6.3 --balance-speed 3600rpm --speed 3600rpm \
        --friction 0.12 --disc-radius 60mm --contact-stiffness 1e8N/m --out pump.toml

The command prints the critical speed, 5,513 rpm, and writes the file that the next commands read.
"""

from rotor_ida import machine_from_data_sheet

pump = machine_from_data_sheet(
    mass="12 kg",
    shaft_stiffness="4e6 N/m",
    damping_ratio="3 %",
    clearance="150 um",
    balance_grade="G6.3",
    balance_speed="3600 rpm",
    speed="3600 rpm",
    friction=0.12,
    disc_radius="60 mm",
    contact_stiffness="1e8 N/m",
)
print(f"eccentricity {1e6 * pump.eccentricity:.2f} um, damping {pump.damping:.1f} N s/m")

# %%
# 2. Run it up
# ------------
#
# Take it from standstill to 6,000 rpm in 20 s::
#
#     rotor-ida run-up --machine pump.toml --to 6000rpm --in 20s --out pump.nc --figure pump
#
# The answer comes first, in three sentences. Tables with the details follow.

from math import pi

from rotor_ida import dimensional, run_up, summary

ramp = [(0, 0), (20, 6000 * 2 * pi / 60)]  # s, rad/s
run = dimensional(run_up(pump, speeds=ramp), units={"speed": "rpm", "length": "um"})
print(summary(run).attrs["sentence"])

# %%
# So it rubs. The force comes in short hits of up to ten times the weight of the rotor, 118 N.

from rotor_ida.plot import plot_run_up

plot_run_up(run)

# %%
# 3. Read the Bode plot
# ---------------------
#
# ::
#
#     rotor-ida plot pump.nc --kind bode --figure bode
#
# The 1X amplitude rises to the clearance and then falls, which looks like a critical speed passed. The phase shows that it is
# not: the lag stays near 35° instead of going through 90°. The stator holds the rotor back.

from rotor_ida.plot import plot_bode

plot_bode(run)

# %%
# 4. Look for backward whirl
# --------------------------
#
# ::
#
#     rotor-ida plot pump.nc --kind cascade --figure cascade.pdf
#
# The right half of a cascade shows forward whirl, the left half backward whirl. A second line appears on the left
# with the first touch, near −120 Hz: friction drives the rotor backward between the hits. It is not dry whip, as the disc never rolls on
# the stator, but it is the warning of it. ``rotor-ida backward-whirl --machine pump.toml`` computes the dry whip that a hard
# knock could start, and the lowest speed at which it exists.

from rotor_ida.plot import plot_cascade

plot_cascade(run)

# %%
# 5. Balance it better
# --------------------
#
# G2.5 at the same speed is an eccentricity of 6.63 µm. An option overrides the file::
#
#     rotor-ida run-up --machine pump.toml --eccentricity 6.63um --to 6000rpm --in 20s

from dataclasses import replace

balanced = replace(pump, eccentricity=6.63e-6)
quiet = dimensional(run_up(balanced, speeds=ramp), units={"speed": "rpm", "length": "um"})
print(summary(quiet).attrs["sentence"])

# %%
# 6. Read a measurement
# ---------------------
#
# A recorder writes a CSV file with a time, two probes at +45° and −45°, and the speed, 2,000 times a second. To follow
# this step without a machine, write such a file from the run of step 2:

import numpy as np
import pandas as pd

t = np.arange(0.0, 20.0, 1 / 2000)
x, y, speed = (np.interp(t, run.t, run[name]) for name in ("x", "y", "speed"))
pd.DataFrame({
    "time_s": t,
    "probe_A_um": (x + y) / np.sqrt(2),
    "probe_B_um": (x - y) / np.sqrt(2),
    "speed_rpm": speed,
}).to_csv("probes.csv", index=False)  # fmt: skip

# %%
# The columns and their units are guessed from their names; only the angles of the probes have to be given. The mean position is
# subtracted, as it is the gap of DC-coupled probes; ``--gap 0`` keeps it::
#
#     rotor-ida plot probes.csv --kind cascade --figure measured --probe-angles 45 -45
#
# The picture is that of step 4, which the signs of a rub in a measurement can be compared with
# (:doc:`/signatures`).

from rotor_ida import read_signals

measured = read_signals("probes.csv", probe_angles=(45, -45))
plot_cascade(measured)

# %%
# Next: find the parameters of a machine from such signals (:doc:`/fit`), try other ramps and see what decides
# whether a run-up ends in whip (:doc:`/how_slow`), or move the sliders of the explorer (:doc:`/explorer`) with
# ``rotor-ida explore --machine pump.toml``.
