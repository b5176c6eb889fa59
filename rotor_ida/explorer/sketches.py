"""What a sketch of a rotor system shows."""

from __future__ import annotations

from rotor_ida.model.rotor_system import RotorSystem


def sketch_of(system: RotorSystem) -> dict[str, object]:
    """Return nodes with their positions and masses, contacts, supports and unbalance."""
    places = system.positions or {n: float(i) for i, n in enumerate(system.nodes)}
    return {
        "nodes": list(places), "positions": list(places.values()),
        "has_positions": system.positions is not None, "units": system.units,
        "contacts": [{"node": each.node, "centre": each.centre, "clearance": each.clearance}
                     for each in system.contacts],
        "supports": [each.node for each in system.supports],
        "masses": [_mass(system, node) for node in system.nodes],
        "unbalance": [each.node for each in system.unbalance],
    }  # fmt: skip


def _mass(system: RotorSystem, node: str) -> float:
    """Return the mass that moves with a node where all others rest."""
    row = system.rows(node)[0]
    return float(row @ system.mass @ row)
