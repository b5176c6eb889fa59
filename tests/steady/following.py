"""What rotors settle on, for the tests of this folder, and rotors whose cycles are known."""

from rotor_ida import Rotor
from rotor_ida.simulation.options import Options
from rotor_ida.steady.follow import settle_disc

REST = (0.0, 0.0, 0.0, 0.0)
SHAFT = {"delta0": 1.0, "shaft_stiffness": 0.25}


def followed(rotor, start=REST, method="taylor", **settings):
    return settle_disc(rotor, start, Options(method=method), **settings)


def of_paper(omega, delta0, start=REST, zeta=0.07, options=None, **settings):
    """What a rotor without a shaft, load or friction settles on."""
    rotor = Rotor(omega=omega, zeta=zeta, delta0=delta0)
    return settle_disc(rotor, start, options or Options(), **settings)


# Rotors under a load, and after how many revolutions the motion from rest comes again.
LOADED = {
    "once": (Rotor(omega=2.4, zeta=0.05, load=0.6, **SHAFT), 1),
    "twice": (Rotor(omega=2.0, zeta=0.05, load=0.6, **SHAFT), 2),
    "three times": (Rotor(omega=2.5, zeta=0.05, load=0.6, **SHAFT), 3),
    "four times": (Rotor(omega=1.6, zeta=0.05, load=0.6, **SHAFT), 4),
    "linear contact": (Rotor(omega=1.4, zeta=0.05, load=0.6, contact_exponent=1.0, **SHAFT), 3),
    "contact damping": (Rotor(omega=1.5, zeta=0.1, load=0.3, contact_damping=0.3, **SHAFT), 2),
    "no shaft": (Rotor(omega=1.8333333333333333, zeta=0.1, delta0=1.0, load=0.3), 4),
}
