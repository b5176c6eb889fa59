"""
A run-down recorded by two probes
=================================

Read a run-down that two proximity probes and a keyphasor have recorded, and find out in ten minutes at which speed the rotor is critical, where the
shaft lies in its clearance, and how large its unbalance is and at which angle. You end with a report in HTML and PDF. You need an installation
(:doc:`/install`) and four commands; beside each is the Python that does the same.

The file
--------

The probes are at 45° right and left of the vertical, their sensitivity is 7.87 V/mm (200 mV/mil), and in the centre of the stator they read −10 V.
The file is made here, so that the correct answers are known: a horizontal rotor of 40 kg with its critical speed at 3,000 rpm and 5 % of critical
damping. Its unbalance eccentricity is 12 µm, at 40° from the mark of the keyphasor. It slows down from 6,000 rpm to a slow roll at 300 rpm. The
surface under the probes has a runout of 3 µm once and 1 µm twice a revolution, and each probe has noise of 0.5 µm. With
a file of your own skip this block.
"""

import numpy as np

from rotor_ida import machine_from_data_sheet, run_up

truth = machine_from_data_sheet(
    mass="40 kg",
    critical_speed="3000 rpm",
    damping_ratio="5 %",
    eccentricity="12 um",
    clearance="400 um",
    contact_stiffness="1e8 N/m",
    load="weight",
    speed="6000 rpm",
)
rpm = np.pi / 30
t = np.arange(0, 40, 1 / 2560)  # s
profile = [(0, 6000 * rpm), (2, 6000 * rpm), (36, 300 * rpm), (43, 300 * rpm)]
run = run_up(truth, speeds=profile, samples=t + 2)  # from when it whirls steadily on

mark = run.angle.values - np.radians(40)
noise = np.random.default_rng(1).normal(size=(2, t.size))
volts = []
for angle, own_noise in zip(np.radians([45, 135]), noise, strict=True):
    runout = 3 * np.cos(mark - angle - 0.7) + np.cos(2 * (mark - angle))
    position = 1e6 * (run.x.values * np.cos(angle) + run.y.values * np.sin(angle))  # um
    volts.append(-10 + 7.87e-3 * (position + runout + 0.5 * own_noise))
pulse = np.where(mark % (2 * np.pi) < 0.3, -2.0, -10.0)
head = "Time (s),Probe A 45R (V),Probe B 45L (V),Keyphasor (V)"
np.savetxt(
    "rundown.csv", np.stack([t, *volts, pulse], axis=1), "%.5f", ",", header=head, comments=""
)

# %%
# 1. Look at the Bode plot
# ------------------------
#
# Name the sensitivity, the gap voltage in the centre, and the stretch of slow roll, from which the runout is taken::
#
#     rotor-ida plot rundown.csv --kind bode --sense x --revolutions 4 --figure bode \
#         --sensitivity 7.87V/mm --length um --gap -10V \
#         --slow-roll 34.5s 40s --runout-orders 2 --caption "Fan 2, run-down of 1 March"

from rotor_ida import orders, read_signals
from rotor_ida.plot import plot_bode

signals = read_signals(
    "rundown.csv",
    sensitivity="7.87 V/mm",
    length="um",
    gap="-10 V",
    slow_roll=(34.5, 40),
    runout_orders=2,
    caption="Fan 2, run-down of 1 March",
)
tracked = orders(signals, revolutions=4)
plot_bode(tracked, sense="x")

# %%
# It shows what the probe at 45° reads, in windows of four revolutions: peak to peak, and the lag from the mark to the next peak. ``--sense y`` draws the other probe, and without ``--sense`` the
# forward whirl is drawn, zero to peak. At the slow roll noise alone is left, so no lag is drawn there. The figure names the critical speed and its amplification factor by half power:

from rotor_ida import bode_peaks

peak = bode_peaks(tracked, sense="x").isel(critical=0)
found_speed, factor = float(peak.critical_speed) / rpm, float(peak.amplification_factor)
print(f"critical speed {found_speed:,.0f} rpm, amplification factor {factor:.1f}")

# %%
# The critical speed is 3,000 rpm and the factor for 5 % of damping is 10. A run-down shows the peak a little late, at a lower speed, and
# flatter; the faster the run-down, the larger this error, which the fit of step 4 does not have. The attributes say what was guessed and subtracted:

print(signals.attrs["columns"])
print(signals.attrs["notes"].replace("; ", ";\n"))

# %%
# 2. Where does the shaft lie?
# ----------------------------
#
# The gap voltage shows it. Displacements count from −10 V, so the clearance is a circle about 0::
#
#     rotor-ida plot rundown.csv \
#         --kind centreline --clearance 400um --figure centre \
#         --sensitivity 7.87V/mm --length um --gap -10V

from rotor_ida.plot import plot_centre_line

plot_centre_line(signals, clearance=400)

# %%
from rotor_ida import centre_line

below = -float(centre_line(signals).offset_y.mean())
print(f"{below:.1f} um below the centre; weight over stiffness is", end=" ")
print(f"{1e6 * truth.load / truth.shaft_stiffness:.1f} um")

# %%
# The centre line stays where the weight holds the shaft. In an oil film it would rise with the speed, and in a rub it would leave the side that touches.
#
# 3. Which way does it whirl?
# ---------------------------
#
# ::
#
#     rotor-ida plot rundown.csv --kind cascade --figure cascade \
#         --sensitivity 7.87V/mm --length um --slow-roll 34.5s 40s --runout-orders 2

from rotor_ida.plot import plot_cascade

plot_cascade(signals)

# %%
from rotor_ida import whirl_ratio

whirl = whirl_ratio(signals, revolutions=4)
moving = whirl.isel(window=whirl.speed.values > 1000 * rpm)
ratio = moving.whirl_over_spin.values
print(f"whirl over spin above 1,000 rpm: {ratio.min():.2f} to {ratio.max():.2f}")

# %%
# The whirl is forward and synchronous, and the cascade has no line beside 1X: the unbalance is the only cause, with neither rub nor oil whirl.
# :doc:`/signatures` shows the signs of rub.
#
# 4. Find the unbalance, and write a report
# -----------------------------------------
#
# Fit stiffness, damping and unbalance to the passage through the critical speed. The mass is known; guess the rest to about a third::
#
#     rotor-ida fit rundown.csv \
#         --mass 40kg --shaft-stiffness 3.5e6N/m --damping 1000Ns/m --eccentricity 10um \
#         --clearance 400um --contact-stiffness 1e8N/m --contact-exponent 1 --speed 6000rpm \
#         --unknown shaft_stiffness damping eccentricity unbalance_angle \
#         --times 15 21 --report page \
#         --sensitivity 7.87V/mm --length um \
#         --gap -10V --slow-roll 34.5s 40s --runout-orders 2
#
# The folder ``page`` contains the report in HTML and PDF, with this figure, the values with their errors, the fitted machine, and the command.

from rotor_ida import DimensionalRotor, fit
from rotor_ida.plot import fit_figure

guess = DimensionalRotor(
    mass=40.0,
    shaft_stiffness=3.5e6,
    damping=1000.0,
    eccentricity=10e-6,
    clearance=400e-6,
    contact_stiffness=1e8,
    contact_exponent=1.0,
    speed=6000 * rpm,
)
passage = signals.sel(t=slice(15, 21))
found = fit(passage, guess, ["shaft_stiffness", "damping", "eccentricity", "unbalance_angle"])
fit_figure(found)

# %%
known = [truth.shaft_stiffness, truth.damping, truth.eccentricity, np.radians(40)]
rows = (found.unknown.values, found.estimate.values, found.standard_error.values, known)
for name, value, error, correct in zip(*rows, strict=True):
    print(f"{name}: {value:.6g} with a standard error of {error:.1g}; correct is {correct:.6g}")
stiffness, _, eccentricity, angle = found.estimate.values
print(f"critical speed {np.sqrt(stiffness / 40) / rpm:,.1f} rpm")
print(f"unbalance {40 * eccentricity * 1e6:.0f} g mm at {np.degrees(angle):.0f}° ahead of the mark")

# %%
# All are within two standard errors. To balance the rotor, remove this unbalance at its angle, counted from the mark in the direction of rotation, or add as much on the
# other side.
#
# Next: :doc:`/signals` is the reference on files, probes, gap and runout, :doc:`/fit` that on fits. A measured rub is fitted in the same way,
# with the clearance among the unknowns.
