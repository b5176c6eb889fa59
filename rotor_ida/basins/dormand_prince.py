"""Dormand and Prince's explicit Runge-Kutta method of order 8 (DOP853): its coefficients and sums.

The loops over stages have constant lengths: the compiler unrolls them, so that a loop over many
orbits that uses these sums becomes vector instructions.

References
----------
.. [1] Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd ed., 1993,
   section II.5 and the program DOP853, whose coefficients these are; those of the rates that a
   stage does not use are left out.
"""

from __future__ import annotations

from rotor_ida.compiling import inlined_for_lanes

State = tuple[float, float, float, float]

# fmt: off
# ruff: noqa: E501
STAGE_2 = (0.05260015195876773,)
STAGE_3 = (0.0197250569845379, 0.0591751709536137)
STAGE_4 = (0.02958758547680685, 0.08876275643042054)
STAGE_5 = (0.2413651341592667, -0.8845494793282861, 0.924834003261792)
STAGE_6 = (0.037037037037037035, 0.17082860872947386, 0.12546768756682242)
STAGE_7 = (0.037109375, 0.17025221101954405, 0.06021653898045596, -0.017578125)
STAGE_8 = (0.03709200011850479, 0.17038392571223998, 0.10726203044637328, -0.015319437748624402, 0.008273789163814023)
STAGE_9 = (0.6241109587160757, -3.3608926294469414, -0.868219346841726, 27.59209969944671, 20.154067550477894, -43.48988418106996)
STAGE_10 = (0.47766253643826434, -2.4881146199716677, -0.590290826836843, 21.230051448181193, 15.279233632882423, -33.28821096898486, -0.020331201708508627)
STAGE_11 = (-0.9371424300859873, 5.186372428844064, 1.0914373489967295, -8.149787010746927, -18.52006565999696, 22.739487099350505, 2.4936055526796523, -3.0467644718982196)
STAGE_12 = (2.273310147516538, -10.53449546673725, -2.0008720582248625, -17.9589318631188, 27.94888452941996, -2.8589982771350235, -8.87285693353063, 12.360567175794303, 0.6433927460157636)
ADVANCE = (0.054293734116568765, 4.450312892752409, 1.8915178993145003, -5.801203960010585, 0.3111643669578199, -0.1521609496625161, 0.20136540080403034, 0.04471061572777259)
ERROR_3 = (-0.18980075407240762, 4.450312892752409, 1.8915178993145003, -5.801203960010585, -0.4226823213237919, -0.1521609496625161, 0.20136540080403034, 0.02265179219836082)
ERROR_5 = (0.01312004499419488, -1.2251564463762044, -0.4957589496572502, 1.6643771824549864, -0.35032884874997366, 0.3341791187130175, 0.08192320648511571, -0.022355307863886294)
# fmt: on


@inlined_for_lanes
def weighted(weights: tuple[float, ...], rates: tuple[State, ...], part: int) -> float:
    """Return the weighted sum of one component of the rates."""
    total = 0.0
    for j in range(len(weights)):
        total += weights[j] * rates[j][part]
    return total


@inlined_for_lanes
def moved(z: State, h: float, weights: tuple[float, ...], rates: tuple[State, ...]) -> State:
    """Return ``z + h * sum(weights * rates)``."""
    return (
        z[0] + h * weighted(weights, rates, 0),
        z[1] + h * weighted(weights, rates, 1),
        z[2] + h * weighted(weights, rates, 2),
        z[3] + h * weighted(weights, rates, 3),
    )


@inlined_for_lanes
def size(weights: tuple[float, ...], rates: tuple[State, ...]) -> float:
    """Return the squared length of the weighted sum of the rates."""
    a, b = weighted(weights, rates, 0), weighted(weights, rates, 1)
    c, d = weighted(weights, rates, 2), weighted(weights, rates, 3)
    return a * a + b * b + c * c + d * d
