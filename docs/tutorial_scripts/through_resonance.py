r"""
Pass a critical speed with a given motor
========================================

Find out whether a rotor touches its snubber while it passes the critical speed, how hard, at which speed it leaves contact again, and whether
the motor is strong enough.

Open the notebook at the end of this page in Jupyter, or copy the blocks into ``python`` one by one (:doc:`/install`).

The data sheet
--------------

A rotor of 8 kg has a shaft stiffness of 2 N/µm and an unbalance eccentricity of 20 µm. A bronze snubber ring on springs of 4 N/µm has a
radial clearance of 60 µm. The shaft radius in it is 50 mm and the coefficient of friction 0.05. The machine starts at 1500 rpm and
runs at 10,000 rpm.
"""

import math

import numpy as np

from rotor_ida import DimensionalRotor, dimensional, folds, run_up

rpm = math.pi / 30  # rad/s
machine = DimensionalRotor(
    mass=8.0,  # kg
    shaft_stiffness=2e6,  # N/m
    damping=400.0,  # N s/m
    eccentricity=20e-6,  # m
    clearance=60e-6,  # m
    contact_stiffness=4e6,  # N/m, as the exponent is 1:
    contact_exponent=1.0,  # a linear spring
    friction=0.05,
    disc_radius=0.05,  # m
    speed=1500 * rpm,  # rad/s
)
critical = math.sqrt(machine.shaft_stiffness / machine.mass) / rpm
free = machine.eccentricity * critical * rpm * machine.mass / machine.damping
print(f"critical speed of the shaft {critical:.0f} rpm")
print(f"radius of the whirl there, without a snubber: {1e6 * free:.0f} µm")

# %%
# At constant critical speed it would whirl far beyond the clearance. A run-up passes this speed, and the whirl needs time to grow.
#
# The run-up
# ----------
#
# The drive accelerates by 3000 rpm per second. For a ``DimensionalRotor`` all numbers are in SI units, speeds in rad/s.
# ``dimensional`` converts the result to rpm and micrometres.

rotor = machine.rotor()
rest = (0, 0, 0, 0)


def up_to_speed(rate):
    """Run the machine up at a rate in rpm/s."""
    run = run_up(machine, to=10_000 * rpm, rate=rate * rpm, start=rest, samples=6001)
    return dimensional(run, units={"speed": "rpm", "length": "µm"})


run = up_to_speed(3000)
speeds = run.event_speed.values
print(
    f"{run.sizes['contact']} contacts, {float(run.t[-1]):.1f} s, {float(run.revolutions):.0f} revolutions"
)
print(f"first touch at {speeds[0]:.0f} rpm, last exit at {speeds[-1]:.0f} rpm")
print(f"largest force {float(run.peak_force.max()):.0f} N")
print(f"largest radius {float(np.hypot(run.x, run.y).max()):.0f} µm")
print(f"events are timed to {float(run.event_time_error.max()):.1g} s or better")

# %%
# The rotor touches below the critical speed and stays in contact above it, since the snubber is a spring too. Shaft and snubber together
# have a much higher resonance, and the rotor follows it.
#
# Where contact ends
# ------------------
#
# The whirl in contact is known exactly at every speed, and it ends at a fold. The curve below is the steady response at each
# constant speed; the line is the run-up.

from rotor_ida.closed_forms import response_curve
from rotor_ida.plot import panels, style

of_whirls = {
    "zeta": rotor.zeta,
    "delta0": rotor.delta0,
    "shaft_stiffness": rotor.shaft_stiffness,
    "contact_exponent": rotor.contact_exponent,
    "friction": rotor.friction,
}
to_rpm = machine.reference_frequency / rpm
to_microns = 1e6 * machine.length_scale
curve = response_curve(**of_whirls, limits=(1500 / to_rpm, 10_000 / to_rpm))
fold = to_rpm * float(folds(**of_whirls).fold_omega.max())
print(f"the whirl in contact ends at {fold:.0f} rpm")


def draw_whirls(ax):
    """Draw the radius of every whirl, solid where it is stable."""
    omega, radius, piece = (curve[name].values.ravel() for name in ("omega", "amplitude", "piece"))
    stable = curve.stability.values.ravel() == 1
    breaks = np.flatnonzero(np.diff(piece) | np.diff(stable)) + 1
    for part in np.split(np.arange(omega.size), breaks):
        line = "-" if stable[part[0]] else "--"
        ax.plot(to_rpm * omega[part], to_microns * radius[part], "k" + line, lw=1.0)
    ax.axhline(1e6 * machine.clearance, color="0.5", lw=0.8, ls=":")
    ax.text(1600, 1e6 * machine.clearance + 3, "clearance", color="0.4")
    ax.plot([], [], "k-", lw=1.0, label="exact whirl, constant speed")
    ax.plot([], [], "k--", lw=1.0, label="unstable")


with style():
    figure, (ax,) = panels(1, 1, width=6.6, height=3.6)
    draw_whirls(ax)
    ax.plot(
        run.speed,
        np.hypot(run.x, run.y),
        color="#bd1f01",
        lw=1.0,
        label="run-up, 3000 rpm/s",
    )
    ax.plot(speeds[[0, -1]], [60, 60], "o", color="#bd1f01", ms=4, label="first touch, last exit")
    ax.axvline(fold, color="0.5", lw=0.8)
    ax.text(fold - 80, 8, "fold", color="0.4", ha="right")
    ax.set(xlabel="speed [rpm]", ylabel="radius [µm]", xlim=(1500, 10_000), ylim=(0, 250))
    ax.legend(loc="upper left")
figure

# %%
# Contact ends late: the rotor passes the fold, and its radius takes some revolutions to fall. The delay depends on the
# rate.
#
# Compare rates
# -------------

print("   rate    first touch    last exit    above the fold   largest force   in contact")
for rate in (2000, 4000, 8000, 16_000):
    run_at = up_to_speed(rate)
    first, last = run_at.event_speed.values[[0, -1]]
    touching = float((run_at.exit_time - run_at.entry_time).sum())
    force = float(run_at.peak_force.max())
    print(f"{rate:6d} rpm/s {first:7.0f} rpm {last:8.0f} rpm {last - fold:12.0f} rpm "
          f"{force:13.0f} N {touching:10.2f} s")  # fmt: skip

# %%
# A higher rate does not prevent contact here. It shortens the time in contact and moves the last exit to a higher speed. Plan the
# first operating speed well above the fold.
#
# Is the motor strong enough?
# ---------------------------
#
# So far the drive supplied any torque that the ramp needs. The torque of a motor falls with the speed. Contact costs torque, for friction
# and for the damping of the whirl. On the exact whirl both are known:

omega = curve.omega.values.ravel() * machine.reference_frequency
radius = curve.amplitude.values.ravel() * machine.length_scale
force = machine.contact_stiffness * np.maximum(radius - machine.clearance, 0.0)
needed = machine.damping * omega * radius**2 + machine.friction * force * (
    radius + machine.disc_radius
)
print(
    f"the largest torque needed: {np.nanmax(needed):.2f} N m, at {omega[np.nanargmax(needed)] / rpm:.0f} rpm"
)

# %%
# Two motors are available, with 3 and 6 N m at rest. The torque of both falls linearly to zero at 12,000 rpm. The moment of inertia of all
# rotating parts is 0.01 kg m².

no_load = 12_000 * rpm
driven = {}
for stall in (3.0, 6.0):
    run = run_up(
        machine, torque=(stall, stall / no_load), inertia=0.01, duration=12.0, start=rest,
        samples=1001,
    )  # fmt: skip
    driven[stall] = dimensional(run, units={"speed": "rpm"})
    last = driven[stall].speed.values[-1]
    touching = driven[stall].event_kind.values[-1] > 0  # the last event is an entry, and no exit
    print(f"{stall:.0f} N m: {last:.0f} rpm after 12 s, {'in contact' if touching else 'free'}, "
          f"largest force {float(driven[stall].peak_force.max()):.0f} N")  # fmt: skip

# %%
stable = curve.stability.values.ravel() == 1
with style():
    figure, (first, second) = panels(1, 2, width=7.2, height=3.3, shared=False)
    first.plot(
        omega / rpm, np.where(stable, needed, np.nan), "k-", lw=1.2, label="needed on the whirl"
    )
    for (stall, run), colour in zip(driven.items(), ("#bd1f01", "#1f6fb8"), strict=True):
        ends = np.array([1500, 10_000])
        first.plot(ends, stall * (1 - ends / 12_000), color=colour, lw=1.0)
        first.text(1650, 0.875 * stall + 0.12, f"motor of {stall:.0f} N m", color=colour)
        second.plot(run.t, run.speed, color=colour, lw=1.2, label=f"motor of {stall:.0f} N m")
    second.axhline(fold, color="0.5", lw=0.8)
    second.text(11.8, fold + 130, "fold", color="0.4", ha="right")
    first.set(xlabel="speed [rpm]", ylabel="torque [N m]", xlim=(1500, 10_000), ylim=(0, 6))
    second.set(xlabel="time [s]", ylabel="speed [rpm]", xlim=(0, 12), ylim=(1000, 13_000))
    first.legend(loc="upper right")
    second.legend(loc="lower right")
figure

# %%
# The weaker motor has enough torque at every speed without contact, but it does not pass the resonance. Its torque line crosses the curve
# below the fold, and the speed stays there, with the rotor in contact: the Sommerfeld effect with rub. The stronger motor has torque to spare,
# and accelerates freely once contact ends. The crossing is known without simulation:

for stall in driven:
    left = stall * (1 - omega / no_load) - needed
    meets = stable & (force > 0.0) & (left < 0.0)
    where = (
        f"stays at about {omega[meets].min() / rpm:.0f} rpm" if meets.any() else "passes the fold"
    )
    print(f"motor of {stall:.0f} N m: {where}")

# %%
# Next
# ----
#
# - What a run-up computes: :doc:`/run_up`, and which rate to choose: :doc:`/how_slow`.
# - Run it up in the browser: ``rotor-ida explore`` (:doc:`/explorer`).
# - More friction may lead to dry whip: :doc:`/rub`.
# - The same on the command line, in rpm: ``rotor-ida run-up --help`` (:doc:`/command_line`).
