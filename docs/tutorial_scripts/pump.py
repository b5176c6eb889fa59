r"""
A pump on its side, from its data sheet to a verdict
====================================================

Find out in ten minutes whether a horizontal pump rubs on its way up to speed, how hard it rubs, and what better balancing changes.
You start from a data sheet and end with a report in HTML and PDF. You need an installation (:doc:`/install`) and four commands.

Beside each command is the Python code that does the same, with its output. If you have followed the README,
keep its ``pump.toml`` and ``pump.nc`` and continue with step 3.

1. Write down the machine
-------------------------

A pump rotor of 12 kg runs on a shaft of 4 N/µm with a damping ratio of 3 %. It is balanced to G6.3 for its
running speed of 3,600 rpm. Its shaft is horizontal, so it carries the weight: ``--load weight``. The wear ring leaves 150 µm of
radial clearance, has a stiffness of 100 N/µm and a coefficient of friction of 0.12, and
touches the rotor at a radius of 60 mm. The pump is dry: no fluid force acts in the wear ring. If you do not know the stiffness, try
1e7 to 1e9 N/m: the speed of the first touch does not depend on it, the force does::

    rotor-ida machine --mass 12kg --shaft-stiffness 4e6N/m --damping-ratio 3% \
        --clearance 150um --balance-grade G6.3 --balance-speed 3600rpm --speed 3600rpm \
        --load weight --friction 0.12 --disc-radius 60mm --contact-stiffness 1e8N/m --out pump.toml

The command prints the critical speed, 5,513 rpm, and writes the file that the next commands read. :doc:`/my_machine` says how to
obtain each value.
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
    load="weight",
    friction=0.12,
    disc_radius="60 mm",
    contact_stiffness="1e8 N/m",
)
print(f"eccentricity {1e6 * pump.eccentricity:.2f} um, damping {pump.damping:.1f} N s/m")

# %%
# 2. Run it up, and write a report
# --------------------------------
#
# A new drive could take the pump to 5,500 rpm. Run it up from standstill in 20 s::
#
#     rotor-ida run-up --machine pump.toml \
#         --to 5500rpm --in 20s --out pump.nc --figure pump --report page
#
# The folder ``page`` contains the report in HTML and PDF: the answer, this figure, the machine, the assumptions, and the
# command that computes it again.

from math import pi

from rotor_ida import dimensional, run_up, summary
from rotor_ida.plot import plot_run_up

ramp = [(0, 0), (20, 5500 * 2 * pi / 60)]  # s, rad/s
run = dimensional(run_up(pump, speeds=ramp), units={"speed": "rpm", "length": "um"})
plot_run_up(run)

# %%
# The answer comes first on the page and in the terminal:

print(summary(run, running_speed=pump.speed).attrs["sentence"])

# %%
# At rest the shaft sags by weight over stiffness, a fifth of the clearance, so the gap below is the smaller one and the orbit meets the
# stator there first: the orbit on the left touches only at the bottom. Up to the running speed the pump is safe. A drive for
# 5,500 rpm would make it rub in short impacts of up to seven times its weight of 118 N.
#
# 3. Read the Bode plot
# ---------------------
#
# ::
#
#     rotor-ida plot pump.nc --kind bode --figure bode
#
# The 1X amplitude rises until the rotor touches and then falls, which looks like a critical speed passed. The phase shows that it is
# not: the lag stays near 30° instead of going through 90°. The stator holds the rotor back.

from rotor_ida.plot import plot_bode

plot_bode(run)

# %%
# A cascade of the same run (``--kind cascade``) shows backward whirl at negative frequencies, which the impacts excite. It is not dry whip, as the
# disc never rolls on the stator (:doc:`/rub`).
#
# 4. Balance it better
# --------------------
#
# G2.5 at the same speed is an eccentricity of 6.63 µm. An option overrides the file::
#
#     rotor-ida run-up --machine pump.toml \
#         --eccentricity 6.63um --to 5500rpm --in 20s --report balanced

from dataclasses import replace

balanced = replace(pump, eccentricity=6.63e-6)
quiet = dimensional(run_up(balanced, speeds=ramp), units={"speed": "rpm", "length": "um"})
print(summary(quiet, running_speed=pump.speed).attrs["sentence"])

# %%
# Balanced to G2.5, the pump passes its whole new range without a touch, though with little room at the end.
#
# Next: compare with a measured run-down (:doc:`run_down`), find a machine from such signals (:doc:`/fit`), try other ramps and see what
# decides whether a run-up ends in whip (:doc:`/how_slow`), or move the sliders of the explorer (:doc:`/explorer`) with
# ``rotor-ida explore --machine pump.toml``. :doc:`/run_up` is the reference.
