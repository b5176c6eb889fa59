"""Attractors keep one number along a parameter; those that no start hit are found by following."""

import numpy as np
import pytest

from rotor_ida import (
    Rotor,
    continue_attractors,
    folds,
    limit_cycle,
    synchronous_response,
)
from rotor_ida.basins.atlas.cells import Cell, Member
from rotor_ida.basins.atlas.identities import followed_whirl, identify
from rotor_ida.basins.attractors import disc_row
from rotor_ida.basins.disc import cycle_row
from rotor_ida.cycles.guess import guess_of
from rotor_ida.cycles.limit_cycle import cycle_from
from rotor_ida.schema import RESPONSE

GO_ON = np.zeros(1, np.uint8)


def cell_of(omega, *sizes):
    members = [Member(disc_row("synchronous", size, 0.0, size, size), 5) for size in sizes]
    return Cell(Rotor(omega=omega, zeta=0.07, delta0=0.0), members)


def whirls_at(omega):
    found = synchronous_response(omega=omega, zeta=0.07, delta0=0.0).squeeze()
    return found.amplitude.values[found.stability.values == 1].tolist()


def test_whirls_are_joined_along_the_response_curve():
    """Both exist between the folds; above the second only the small one."""
    low, high = np.sort(folds(zeta=0.07, delta0=0.0).fold_omega.values.ravel()).tolist()
    speeds = (low - 0.1, low + 0.05, high - 0.05, high + 0.1)
    cells = [cell_of(omega, *whirls_at(omega)) for omega in speeds]
    assert [len(cell.members) for cell in cells] == [1, 2, 2, 1]
    assert identify(cells, [[0, 1, 2, 3]], GO_ON) == 2
    large = cells[0].members[0].identity
    assert [each.identity for each in cells[1].members] == [1 - large, large]
    assert [each.identity for each in cells[2].members] == [1 - large, large]
    assert cells[3].members[0].identity == 1 - large


def test_a_whirl_is_followed_over_a_long_step_at_low_speed():
    """Without clearance its amplitude grows like omega**(4/3) there: twentyfold in all."""
    here, there = (Rotor(omega=omega, zeta=0.07, delta0=0.0) for omega in (0.1, 1.1))
    exact = max(whirls_at(1.1))
    assert followed_whirl(whirls_at(0.1)[0], here, there) == pytest.approx(exact, rel=1e-9)


def test_fading_touches_are_one_attractor_over_a_gap():
    """Of few starts none may end so at some speed; it is still the edge of the same family."""
    cells = [Cell(Rotor(omega=omega, zeta=0.07, delta0=2.0)) for omega in (1.0, 1.1, 1.2)]
    for place in (0, 2):
        cells[place].members.append(Member(disc_row("touching", 1.0, 3.0, 0.0, 2.0), 1))
    assert identify(cells, [[0, 1, 2]], GO_ON) == 1


def member_at(omega, delta0, start):
    rotor = Rotor(omega=omega, zeta=0.07, delta0=delta0)
    cycle = cycle_from(guess_of(rotor, np.array(start)))
    return rotor, Member(cycle_row(cycle, True), 3)


def test_an_attractor_that_no_start_hit_is_found_from_its_neighbour():
    """All starts lie close to rest; a neighbour knows the cycle that exists here too."""
    rotor, member = member_at(2.0, 2.0, (0.0, 0.0, 0.0, 0.0))
    cells = [Cell(rotor, [member]), Cell(Rotor(omega=2.1, zeta=0.07, delta0=2.0))]
    assert identify(cells, [[0, 1]], GO_ON) == 1
    (found,) = cells[1].members
    assert found.count == 0
    assert found.identity == member.identity
    exact = limit_cycle(cells[1].rotor, start=member.row["final_state"], period=4.35)
    assert found.row["period"] == pytest.approx(float(exact.period), rel=1e-12)


def test_round_a_cusp_two_whirls_stay_two():
    """Followed round the cusp each becomes the other; in no rotor do both get one number."""
    found = continue_attractors(
        omega=[1.3, 1.5, 1.7], zeta=[0.1, 0.14, 0.18], delta0=0.0, x=(-12, 12), y=(-12, 12),
        starts=60,
    )  # fmt: skip
    whirls = found.kind == RESPONSE["synchronous"]
    for omega in found.omega.values:
        for zeta in found.zeta.values:
            exact = synchronous_response(omega=omega, zeta=zeta, delta0=0.0)
            here = whirls.sel(omega=omega, zeta=zeta).sum()
            assert int(here) == int((exact.stability == 1).sum())
