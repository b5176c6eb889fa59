"""Symbols, made into numbers or whatever can be added, multiplied and divided like one."""

import operator

from rotor_ida.model.symbols import Symbol

OPERATIONS = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": operator.pow,
}


def value_of(symbol: Symbol, rotor, state):
    """Return the value of a symbol, of a rotor with attributes and a state by names."""
    known = {}

    def value(node):
        if not isinstance(node, Symbol):
            return node
        if node.number not in known:
            if node.kind == "number":
                known[node.number] = node.arguments[0]
            elif node.kind == "parameter":
                known[node.number] = getattr(rotor, node.arguments[0])
            elif node.kind == "state":
                known[node.number] = state[node.arguments[0]]
            else:
                known[node.number] = OPERATIONS[node.kind](*map(value, node.arguments))
        return known[node.number]

    return value(symbol)
