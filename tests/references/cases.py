"""The runs in the table: doubles throughout, some of them chosen by a computation."""

from math import sqrt

from flint import acb, arb, ctx

from .motion import Case, dot

REST = (0.0, 0.0, 0.0, 0.0)
GRAZES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
PASSING = {"omega": 1.7, "zeta": 0.07}
PASSING_START = (0.3, 0.2, 0.3, -0.5)


def flight_peak(omega, zeta, start):
    """Return the first largest |z| of a contact-free flight, larger than |z| at its start.

    The flight is z = c + d exp(-2 zeta t) + a exp(i omega t); Newton's method on d|z|^2/dt from
    the highest of many points before the first sign change of |z|' from plus to minus.
    """
    ctx.prec = 240
    x, y, vx, vy = (arb(value) for value in start)
    omega, damping = arb(omega), 2 * arb(zeta)
    whirl = -omega / acb(omega, -damping)
    turn = acb(0, 1) * omega
    glide = -(acb(vx, vy) - turn * whirl) / damping
    centre = acb(x, y) - whirl - glide

    def motion(time):
        turning = whirl * (turn * time).exp()
        gliding = glide * (-damping * time).exp()
        return (
            centre + turning + gliding,
            turning * turn - gliding * damping,
            turning * turn**2 + gliding * damping**2,
        )

    best, count = dot(*[motion(arb(0))[0]] * 2), 1
    while True:
        time = arb(count) / 64
        before, here, after = (motion(time + arb(n) / 64)[0] for n in (-1, 0, 1))
        before, here, after = (dot(z, z) for z in (before, here, after))
        if here > before and here > after and here > best:
            break
        count += 1
    for _ in range(12):
        z, v, a = motion(time)
        time = (time - dot(z, v) / (dot(v, v) + dot(z, a))).mid()
    z = motion(time)[0]
    return dot(z, z).sqrt().mid(), float(time)


def grazes():
    """Flights whose first peak passes the ring by a little, or falls short of it."""
    peak, time = flight_peak(**PASSING, start=PASSING_START)
    for depth in GRAZES:
        label = f"{depth:.0e}".replace("e-0", "e-")
        yield Case(
            f"graze_{label}",
            f"the first peak of |z|, at t = {time:.3f}, is {label} outside the ring",
            **PASSING,
            delta0=float(peak - arb(depth)),
            start=PASSING_START,
            duration=30.0,
        )
    for depth in GRAZES:
        label = f"{depth:.0e}".replace("e-0", "e-")
        yield Case(
            f"miss_{label}",
            f"the first peak of |z|, at t = {time:.3f}, is {label} short of the ring",
            **PASSING,
            delta0=float(peak + arb(depth)),
            start=PASSING_START,
            duration=30.0,
        )


def departures():
    """Free vibration whose inner turning points lie just inside the ring, or just outside it.

    In flight the least radius is L/|v|. From r = A with velocity v across it, in contact,
    A v = b sqrt(v^2 + (4/5) (A - delta0)^2.5) makes it b.
    """
    amplitude, delta0 = 2.0, 1.0
    for depth in (1e-3, 1e-6, -1e-6):
        b = delta0 - depth
        speed = b * sqrt(0.8 * (amplitude - delta0) ** 2.5 / (amplitude**2 - b**2))
        label = f"{abs(depth):.0e}".replace("e-0", "e-")
        yield Case(
            f"departure_{'' if depth > 0 else 'miss_'}{label}",
            f"every departure from the ring is short, to {label} inside it"
            if depth > 0
            else f"a contact that eases to {label} outside the ring and never ends",
            omega=0.0,
            zeta=0.0,
            delta0=delta0,
            start=(amplitude, 0.0, 0.0, speed),
            duration=30.0,
        )


def plain():
    """Runs whose parameters were simply chosen."""
    table = [
        (
            "hard_case",
            "DESIGN's hard case: long flights between contacts make K grow to 1e7",
            0.6,
            0.07,
            2.0,
            REST,
            200.0,
        ),
        (
            "free_planar",
            "free vibration through the centre; times are known in closed form",
            0.0,
            0.0,
            1.0,
            (2.0, 0.0, 0.0, 0.0),
            60.0,
        ),
        (
            "free_non_planar",
            "free vibration with angular momentum",
            0.0,
            0.0,
            1.0,
            (0.3, 0.0, 1.0, 0.4),
            120.0,
        ),
        (
            "free_several_hundred",
            "free vibration, hundreds of events",
            0.0,
            0.0,
            0.5,
            (3.0, 0.0, 0.0, 0.3),
            300.0,
        ),
        (
            "free_damped",
            "free vibration that dies out",
            0.0,
            0.05,
            1.0,
            (3.0, 0.0, 0.0, 0.5),
            100.0,
        ),
        ("bouncing", "from rest on to the bouncing attractor", 2.0, 0.07, 2.0, REST, 60.0),
        (
            "fast_small_clearance",
            "from rest, until contact is permanent",
            3.0,
            0.07,
            0.5,
            REST,
            60.0,
        ),
        (
            "fast_violent",
            "omega 3 from a violent start, before contact is permanent",
            3.0,
            0.07,
            0.5,
            (0.0, 0.2, -12.0, 1.0),
            60.0,
        ),
        ("near_resonance", "omega 1.5 from rest", 1.5, 0.07, 1.0, REST, 60.0),
        ("above_resonance", "omega 2 with clearance 1 from rest", 2.0, 0.07, 1.0, REST, 60.0),
        (
            "ring_outwards",
            "starts on the ring, moving out: in contact at once, no event at 0",
            1.2,
            0.07,
            1.5,
            (1.5, 0.0, 0.7, 0.2),
            40.0,
        ),
        (
            "ring_inwards",
            "starts on the ring, moving in: in flight",
            1.2,
            0.07,
            1.5,
            (1.5, 0.0, -0.7, 0.2),
            40.0,
        ),
        (
            "ring_tangential_outwards",
            "starts on the ring along it, r'' > 0: in contact at once",
            1.2,
            0.07,
            1.5,
            (1.5, 0.0, 0.0, 0.6),
            40.0,
        ),
        (
            "ring_tangential_inwards",
            "starts on the ring along it, r'' < 0: in flight",
            1.2,
            0.07,
            1.5,
            (-1.5, 0.0, 0.0, 0.6),
            40.0,
        ),
        (
            "ring_tangential_free",
            "starts on the ring along it, held to it by nothing",
            0.0,
            0.02,
            1.0,
            (1.0, 0.0, 0.0, 0.5),
            60.0,
        ),
        (
            "ring_from_rest",
            "starts at rest on the ring, pushed outwards by the unbalance",
            1.5,
            0.05,
            1.0,
            (1.0, 0.0, 0.0, 0.0),
            40.0,
        ),
        (
            "ring_at_rest",
            "stands still on the ring for ever: no events",
            0.0,
            0.1,
            1.0,
            (1.0, 0.0, 0.0, 0.0),
            50.0,
        ),
        (
            "contact_inwards",
            "starts in contact, moving in",
            1.4,
            0.07,
            1.0,
            (0.9, -0.9, -1.1, 0.3),
            40.0,
        ),
        (
            "contact_outwards",
            "starts in contact, moving out",
            1.4,
            0.07,
            1.0,
            (0.9, -0.9, 1.1, 0.3),
            40.0,
        ),
        (
            "undamped_forced",
            "zeta = 0 with forcing: flights in a straight line plus a whirl",
            2.3,
            0.0,
            2.0,
            (0.2, 0.0, 0.0, 0.1),
            40.0,
        ),
        (
            "zeta_1e-8",
            "closed forms with 1/zeta lose 8 digits if written naively",
            2.3,
            1e-8,
            2.0,
            (0.2, 0.0, 0.0, 0.1),
            40.0,
        ),
        (
            "fast_forcing",
            "omega 8: many turns in each contact",
            8.0,
            0.05,
            0.8,
            (0.5, 0.0, 0.6, 0.3),
            40.0,
        ),
        (
            "slow_forcing",
            "omega 0.1: the rotor drifts to the ring and rolls along it",
            0.1,
            0.03,
            0.5,
            (0.0, 0.3, 0.05, 0.0),
            200.0,
        ),
        ("never_reached", "clearance 15: no events", 1.0, 0.1, 15.0, REST, 300.0),
        ("heavy_damping", "zeta 1.5", 1.0, 1.5, 0.4, (1.2, 0.3, -4.0, -1.0), 40.0),
        ("small_clearance", "delta0 0.05", 0.2, 0.02, 0.05, (1.0, 0.0, 0.0, 0.02), 60.0),
        (
            "tiny_clearance",
            "delta0 1e-6: flights of a millionth",
            0.0,
            0.02,
            1e-6,
            (0.5, 0.0, 0.0, 0.0),
            60.0,
        ),
        (
            "large_start",
            "starts three clearances out at rest",
            1.7,
            0.07,
            2.0,
            (6.0, 0.0, 0.0, 0.0),
            40.0,
        ),
        ("violent_start", "starts at a speed of 30", 1.7, 0.07, 3.0, (0.0, 0.0, 30.0, 0.0), 20.0),
        (
            "near_circular",
            "free whirl in contact whose radius hardly oscillates: no events",
            0.0,
            0.0,
            1.0,
            (2.0, 0.0, 0.0, 1.4),
            40.0,
        ),
    ]
    for name, tests, omega, zeta, delta0, start, duration in table:
        yield Case(name, tests, omega, zeta, delta0, start, duration)


def all_cases():
    """Every case of the table, in order."""
    return [*plain(), *grazes(), *departures()]
