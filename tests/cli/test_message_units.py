"""Every message answers in the unit that was typed, whatever the package calculates in.

The expected numbers are those of the line, or limits of the dimensionless rotor (1e6, 1e-12) times
its scales: eccentricity 10 um and, for k = 1e7 N/m and m = 10 kg, 1000 rad/s.
"""

from pathlib import Path

import pytest

from rotor_ida import DimensionalRotor
from rotor_ida.cli.message_units import Given, rewritten
from rotor_ida.errors import InputError, SimulationError
from rotor_ida.results.in_si import in_si

MACHINE = """
mass = "10 kg"
contact_stiffness = "1e7 N/m"
damping = 200.0
eccentricity = "10 um"
clearance = "100 um"
speed = "3000 rpm"
"""
SYSTEM = """
speed = "2000 rpm"
system = { mass = [4, 4], stiffness = [1e5, 1e5], damping = [90, 90], nodes = { disc = [0, 1] } }
contacts = [ { node = "disc", clearance = "60 um", stiffness = "1e7 N/m" } ]
unbalance = [ { node = "disc", moment = "100 g mm" } ]
"""
OF_MACHINE = {
    "simulate --duration -1ms": "duration must be positive, got -1 ms",
    "simulate --duration 1 --start 30000mm 0 0 0":
        "start x must lie within 10000 mm of zero, got 30000 mm",
    "simulate --duration 1 --speed -100rpm":
        "m.toml: speed must be zero or positive, got -100 rpm",
    "simulate --duration 1 --clearance 1e9mm":
        "clearance must be at most 10000 mm to be simulated, got 1e+09 mm",
    "simulate --duration 1 --damping 1e30":
        "damping must be at most 2e+10 N s/m to be simulated, got 1e+30 N s/m",
    "run-up --to 6000rpm --rate -100rpm/s":
        "rate must be positive to change the speed from 0 to 6000 rpm, got -100 rpm/s",
    "run-up --to 600 --rate -10":
        "rate must be positive to change the speed from 0 to 600 rad/s, got -10 rad/s2",
    "run-up --from 60Hz --to 60Hz --in 1s":
        "to must differ from the rotor's speed 60 Hz, got 60 Hz",
    "run-up --speeds 0s:100rpm 2s:200rpm --duration 1s":
        "duration must be at least 2 s, the time of the speed change, got 1 s",
    "run-up --speeds 0ms:100rpm":
        "speeds must be two or more pairs of time and speed, got [[0 ms, 100 rpm]]",
    "run-up --speeds 0:30 1:-30":
        "a speed of speeds must be zero or positive: a run through zero is not supported, got "
        "-30 rad/s",
    "run-up --torque -3Nm 0.5 --inertia 1kgm2 --duration 1s":
        "tau0 of torque must be positive to turn a rotor that is at rest, got -3 Nm",
    "sweep --speed 2000rpm 1000rpm --direction up":
        "speed must increase in a sweep up or down, got 1000 rpm after 2000 rpm",
    "bifurcation-diagram --speed 1000rpm --x 5um:-5um":
        "x must be a range (low, high) with low <= high, got (5 um, -5 um)",
    "bifurcation-diagram --speed 1000rpm --damping 0":
        "damping must be above 0, where nothing settles, got 0 N s/m",
    "basin --x=300um:-300um:4 --y=0:1um:3": "x must increase, got 100 um after 300 um",
    "limit-cycle --period 100s": "period must lie from 1e-09 s to 10 s, got 100 s",
    "continue-cycle --parameter clearance --limits 200um 300um":
        "limits of clearance must contain that of the start, 100 um, got (200 um, 300 um)",
    "bifurcation-curve --kind fold --parameters speed clearance "
    "--limits 2000rpm 4000rpm 300um 200um":
        "limits of clearance must be two increasing numbers from 0 on, got (300 um, 200 um)",
}  # fmt: skip
OF_SYSTEM = {
    "simulate --duration -1ms": "duration must be positive, got -1 ms",
    "run-up --from 100rpm --to 900rpm --in 100ms --duration 50ms":
        "duration must be at least 100 ms, the time of the speed change, got 50 ms",
    "sweep --speed 2000rpm 1000rpm --direction up":
        "speed must increase in a sweep up or down, got 1000 rpm after 2000 rpm",
    "special-speeds --limits 3000rpm 2000rpm":
        "limits must be two numbers, the lower first, got (3000 rpm, 2000 rpm)",
    "campbell --speed 100rpm --contact-stiffness -1N/mm":
        "--contact-stiffness must be zero or positive, got -1 N/mm",
    "clearance-report --speed 1rpm 2rpm 3rpm --vibration-limit -5um":
        "--vibration-limit must be positive, got -5 um",
    "continue-cycle --limits 5000rpm 6000rpm":
        "limits of speed must contain that of the start, 2000 rpm, got (5000 rpm, 6000 rpm)",
    "limit-cycle --speed 0":
        "speed must not be 0, and at most 1e+15 rad/s, for a limit cycle, got 0 rad/s",
}  # fmt: skip


@pytest.mark.parametrize(("line", "message"), OF_MACHINE.items(), ids=range(len(OF_MACHINE)))
def test_messages_about_a_machine_have_the_units_of_its_user(program, line, message):
    Path("m.toml").write_text(MACHINE)
    command, *words = line.split()
    answer = program(command, "--machine", "m.toml", *words)
    assert (answer.status, answer.err) == (2, f"rotor-ida: {message}\n")


@pytest.mark.parametrize(("line", "message"), OF_SYSTEM.items(), ids=range(len(OF_SYSTEM)))
def test_messages_about_a_system_have_the_units_of_its_user(program, line, message):
    Path("s.toml").write_text(SYSTEM)
    command, *words = line.split()
    answer = program(command, "s.toml", *words)
    assert (answer.status, answer.err) == (2, f"rotor-ida: {message}\n")


def test_a_message_about_a_file_has_the_units_of_the_file(program):
    Path("s.toml").write_text(SYSTEM.replace("60 um", "-60 um"))
    assert program("simulate", "s.toml", "--duration", "1ms").err == (
        "rotor-ida: s.toml: contacts[0]: clearance of the contact at 'disc' must be zero or "
        "positive, got -60 um\n"
    )


def test_a_message_about_a_measured_file_has_its_unit(program):
    rows = "".join(f"{0.001 * n},{n % 7},{n % 5}\n" for n in range(200))
    Path("probes.csv").write_text(f"time_s,x_um,y_um\n{rows}")
    answer = program("plot", "probes.csv", "--kind", "orbit", "--clearance", "-3um",
                     "--probe-angles", "0", "90")  # fmt: skip
    assert answer.err == "rotor-ida: clearance must be zero or positive, got -3.0\n"


def test_a_run_that_fails_tells_its_time_and_state_in_si_units():
    machine = DimensionalRotor(mass=10.0, contact_stiffness=1e7, damping=200.0, eccentricity=1e-5,
                               clearance=1e-4, speed=300.0, contact_exponent=1.0)  # fmt: skip
    error = in_si(
        SimulationError("too many steps", time=50.5, state=(1.5, -2.0, 3.0, 0.25)), machine
    )
    place = "state (x, y, vx, vy) = (1.5e-05 m, -2e-05 m, 0.03 m/s, 0.0025 m/s)"
    assert str(error) == f"too many steps (at t = 0.0505 s, {place})"
    assert (error.time, error.state[1]) == pytest.approx((0.0505, -2e-5), rel=1e-14)
    typed = rewritten(error, [Given("duration", 2.0, "ms")])
    assert "(at t = 50.5 ms, state" in str(typed)


def test_an_undamped_system_is_refused_at_a_speed(program):
    Path("s.toml").write_text(SYSTEM.replace("damping = [90, 90], ", ""))
    answer = program("clearance-report", "s.toml", "--speed", "1rpm", "2rpm", "--probes", "disc")
    assert answer.status == 2
    assert answer.err.endswith("for a report, got no damping at 1509.88 rpm\n")


def test_numbers_without_units_stay():
    given = [Given("duration", 1.0, "s"), Given("speed", 2.0, "rpm")]
    error = InputError("{name} must be at least {least}, got {value}", name="rtol", least=1.0,
                       value=2.0)  # fmt: skip
    assert str(rewritten(error, given)) == "rtol must be at least 1.0, got 2.0"
