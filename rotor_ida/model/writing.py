"""Write the C of the compiled core that is derived from the model.

For each mode: its field and Jacobian, the growth of small differences, the derivatives by the
parameters, and the recurrences of its Taylor series [1]_, one line per product. The files are
committed and readable, so that a build does not need Python for them. After a change of the model,

    python -m rotor_ida.model.writing

writes them again into `rotor_ida.core`; a test compares the two.

References
----------
.. [1] A. Jorba and M. Zou, "A software package for the numerical integration of ODEs by means of
   high-order Taylor methods", Experimental Mathematics 14, 2005, section 2.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace

from rotor_ida.model import contact, element, lanes
from rotor_ida.model.derivation import derive, factors_of, lanes_of, needed, needs_convolution
from rotor_ida.model.expressions import (
    LANES_A_VECTOR,
    Writer,
    given_in,
    is_idle,
    names_of,
    place_of,
    recurrences,
    values_of,
)
from rotor_ida.model.forces import Number
from rotor_ida.model.mode_functions import (
    products_in,
    write_differences,
    write_lighter,
    write_series,
    write_spent,
    write_table,
    write_values,
)
from rotor_ida.model.modes import PAPER, WHOLE, Mode, Model
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.spinning import OF_DRIVE, RUN_UP
from rotor_ida.model.symbols import Dual, Graph, named_as_in

MODELS = (PAPER, WHOLE, RUN_UP)
# Condition for compiling each.
CHOSEN_BY = {
    "paper": "#ifndef WHOLE_MODEL",
    "whole": "#if defined(WHOLE_MODEL) && !defined(RUN_UP)",
    "run_up": "#ifdef RUN_UP",
}
# Marks names that this model lacks. Code for all models may use them where the compiler removes it,
# or where the constant of this model makes no difference.
ABSENT = "/* of other models */"
# What the law of contact depends on, and what the rest of the core asks of it: the names of the
# functions, and what they are given.
OF_LAW = ("hertz", "linear", "contact_damping", "loose", "friction", "sigma")
GIVEN_LAW = ("q", "approach", "push", "of_q", "of_approach")
OF_DISC = {
    "the elastic force": ("spring_of_root", "q"),
    "its slope by the indentation": ("slope_of_root", "q"),
    "the elastic energy": ("energy_of_root", "q"),
    "the factor of contact damping, not clipped at 0": ("damping_factor", "approach"),
    "the radial velocity of a release": ("release_velocity",),
    "the normal force, not clipped at 0": ("normal_force", "q", "approach"),
    "the rate of the normal force": ("rate_of_force", "q", "approach", "of_q", "of_approach"),
}
OF_ELEMENT = {
    "its slope by the indentation": ("element_stiffness", "q"),
    "the elastic energy": ("element_energy", "q"),
    "the factor of contact damping, not clipped at 0": ("element_factor", "approach"),
    "the tangential force of surfaces that slide": ("element_drag", "push"),
}
COMMAND = "python -m rotor_ida.model.writing"
FOLDER = Path(__file__).parents[1] / "core"


def _parameters(model: Model) -> list[str]:
    """Return the structure of all parameters of a mode, and its conversion from a rotor."""
    head = "static inline struct parameters parameters_of(const struct rotor *rotor, double felt)"
    special = {
        "felt": "felt",
        "loose": "0.0",
        "hertz": "rotor->contact_exponent > 1.0 ? 1.0 : 0.0",
        "linear": "rotor->contact_exponent > 1.0 ? 0.0 : 1.0",
        "rim": "rotor->disc_radius * rotor->omega",
        "sigma": "0.0",
    }
    of_rotor = [f".{name} = {special.get(name, f'rotor->{name}')}" for name in model.parameters]
    absent = absent_from(model)
    fixed = {name: model.constants.get(name) for name in absent}
    of_rotor += [f".{name} = {value}" for name, value in fixed.items() if value]
    return [
        "struct parameters {",
        f"    double {', '.join(model.parameters)};",
        *([f"    double {', '.join(absent)}; {ABSENT}"] if absent else []),
        "};",
        "",
        head,
        "{",
        f"    return (struct parameters){{{', '.join(of_rotor)}}};",
        "}",
        *_is_plain(),
        "",
        "/* The law of contact, by the root q of the indentation and the radial velocity. */",
        *_law("parameters", model.constants, OF_DISC),
        *([] if model is RUN_UP else _in_lanes(model)),
    ]


def _in_lanes(model: Model) -> list[str]:
    """Return what the lanes of basins obey, as functions that become vector instructions.

    In contact the disc slides forwards in all of them; what is loose has the force 0 of a release.
    """
    parts = {
        "motion_in_lane": (lanes.motion_of, lanes.MOTION_GIVEN, lanes.MOTION),
        "rates_in_lane": (lanes.rates_of, lanes.RATES_GIVEN, lanes.RATES),
    }
    names = [f"LANE_{name.upper()}" for name in lanes.RATES_GIVEN]
    lines = ["", "/* The motion on the rotating axes: what a lane is given, and what follows. */"]
    lines += [f"enum {{ {', '.join([*names, 'LANE_GIVEN'])} }};"]
    for name, (law, given, answers) in parts.items():
        graph = Graph()
        every = {each: graph.parameter(each) for each in model.parameters}
        fixed = dict.fromkeys(absent_from(model), 0.0) | model.constants
        fixed |= {"sigma": 1.0, "loose": 0.0}
        every |= {each: graph.of(value) for each, value in fixed.items()}
        with named_as_in("lanes.py"):
            values = law([graph.state(each) for each in given], SimpleNamespace(**every))
        places = [f"answers[{number}]" for number in range(len(answers))]
        pairs = [(place, graph.of(value)) for place, value in zip(places, values, strict=True)]
        mode = Mode("lane", given, *(None,) * 3, (), None)  # type: ignore[arg-type]
        body = values_of(pairs, mode, fused=True)
        lines += [
            f"/* Of {', '.join(answers)}. */",
            f"static inline __attribute__((always_inline)) void {name}(",
            "    const struct parameters *m, const double *state, double *answers)",
            "{", *([] if any("m->" in line for line in body) else ["    (void)m;"]),
            *(f"    {line}" for line in body), "}",
        ]  # fmt: skip
    return lines


def _law(
    struct: str, constants: Mapping[str, float], names: Mapping[str, tuple[str, ...]]
) -> list[str]:
    """Return the law of contact as functions of a structure, by the names that they get.

    Those of `element` are of coefficients n of series.
    """
    graph = Graph()
    fixed = {name: graph.of(value) for name, value in constants.items()}
    law = SimpleNamespace(**{name: graph.parameter(name) for name in OF_LAW} | fixed)
    q, approach, push, *rates = (graph.state(name) for name in GIVEN_LAW)
    root, speed = (Dual(each, (rate,)) for each, rate in zip((q, approach), rates, strict=True))
    values = {
        "the elastic force": contact.spring_of_root(q, law),
        "its slope by the indentation": contact.slope_of_root(q, law),
        "the elastic energy": contact.energy_of_root(q, law),
        "the factor of contact damping, not clipped at 0": contact.damping_factor(
            approach, law.contact_damping
        ),
        "the radial velocity of a release": contact.release_velocity(law),
        "the normal force, not clipped at 0": contact.normal_force(q, approach, law),
        "the rate of the normal force": contact.normal_force(root, speed, law).parts[0],
        "the tangential force of surfaces that slide": contact.drag_of(push, law),
    }
    of_series = struct == "element"
    lines = []
    for what, (name, *given) in names.items():
        value = graph.of(values[what])
        nodes = needed([value])
        writer = Writer(lambda name: name, one="one" if of_series else "", kind="")
        body = []
        shared = {} if of_series else names_of(nodes, [])
        for node in nodes:
            if node.number in shared and node is not value:
                body.append(f"const double {shared[node.number]} = {writer(node)};")
                writer.names[node.number] = shared[node.number]
        body.append(f"return {writer(value)};")
        arguments = [f"const struct {struct} *m", *(f"double {each}" for each in given)]
        if "one * " in body[-1]:
            arguments.insert(1, "int n")
            body.insert(0, "const double one = n == 0 ? 1.0 : 0.0;")
        text = " ".join(body).replace("m->", "m ->")
        unused = [each for each in ("m", *given) if not re.search(rf"\b{each}\b", text)]
        lines += [
            "", f"/* {what[0].upper()}{what[1:]}. */",
            f"static inline double {name}({', '.join(arguments)})",
            "{", *(f"    (void){each};" for each in unused), *(f"    {line}" for line in body), "}",
        ]  # fmt: skip
    return lines


def _is_plain() -> list[str]:
    """Return the function that decides whether the lightest series of a run-up suffice."""
    fixed = RUN_UP.lighter["plain"]
    said = [f"m->{name} == {fixed[name]!r}" for name in RUN_UP.parameters if name in fixed]
    return [
        "",
        "/* Whether a rotor is the paper's, but for friction, and its speed prescribed. */",
        "static inline int is_plain(const struct parameters *m)",
        "{",
        f"    return {' && '.join(said)};",
        "}",
    ]


def absent_from(model: Model) -> list[str]:
    """Return the parameters of other models that this one lacks."""
    named = dict.fromkeys(name for other in MODELS for name in other.parameters)
    return [name for name in named if name not in model.parameters]


def _places_of(model: Model) -> dict[str, list[str]]:
    """Return the names of the places in the states of a model, by mode."""
    return {
        mode.name: [
            *(place_of(mode, name) for name in (*mode.state, "size")),
            *(f"{place_of(mode, guard.event)}_GUARD" for guard in mode.guards),
        ]
        for mode in model.modes
    }


def _declare_absent(model: Model) -> list[str]:
    """Declare names of other models that this one lacks: 0, in code that the compiler removes."""
    lines, own = [], _places_of(model)
    columns = dict.fromkeys(name for other in MODELS for name in other.columns)
    names = [f"BY_{name.upper()}" for name in columns if name not in model.columns]
    named: dict[str, list[str]] = {}
    for other in MODELS:
        for mode, places in _places_of(other).items():
            named[mode] = [*dict.fromkeys([*named.get(mode, []), *places])]
    absent = [place for mode in named for place in named[mode] if place not in own.get(mode, [])]
    if not model.columns:
        lines += ["enum { PARAMETERS = 1 };"]
    if names or absent:
        lines += [f"enum {{ {', '.join(f'{name} = 0' for name in [*names, *absent])} }}; {ABSENT}"]
    return lines


def sources() -> dict[str, str]:
    """Return the names and contents of all derived files."""
    files = {name: text for model in MODELS for name, text in sources_of(model).items()}
    return files | {"derived_rotor.h": _rotor(), "derived_element.h": _element()}


def _rotor() -> str:
    """Return the structure of a rotor, which is the same in all models."""
    lines = [
        f"/* Derived from rotor_ida/model/parameters.py by `{COMMAND}`. */",
        "/* clang-format off */",
        "#ifndef ROTOR_IDA_DERIVED_ROTOR_H",
        "#define ROTOR_IDA_DERIVED_ROTOR_H",
        "",
        "/* A rotor, and how its speed changes: at a rate, or by what a torque, which falls by a",
        " * slope with the speed, leaves against the reaction of the motion. Where it changes,",
        " * omega is that of the moment; else the last four are 0. */",
        "struct rotor {",
        f"    double {', '.join(ALL_PARAMETERS)};",
        f"    double {', '.join(OF_DRIVE)};",
        "};",
        "",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _element() -> str:
    """Return the laws of a contact of a rotor system: series, order by order, and values."""
    given, changed = (
        Mode(stem, names, *(None,) * 3, (), None)  # type: ignore[arg-type]
        for stem, names in (("element", element.GIVEN), ("slope", element.SLOPE_GIVEN))
    )
    names, slopes = (
        [place_of(each, name) for name in (*each.state, "given")] for each in (given, changed)
    )
    of_slopes = [f"SLOPE_BY_{name.upper()}" for name in element.SLOPES]
    of_centred = [f"CENTRED_{name.upper()}" for name in element.CENTRED_SLOPES]
    laws = {
        "element": (element.answers_of, element.ANSWERS),
        "rolling": (element.rolling_answers_of, element.ROLLING_ANSWERS),
        "massless": (element.massless_answers_of, element.MASSLESS_ANSWERS),
        "centred": (element.centred_answers_of, element.CENTRED_ANSWERS),
    }
    answers = list(dict.fromkeys(name for _, each in laws.values() for name in each))
    return "\n".join(
        [
            f"/* Derived from rotor_ida/model/element.py by `{COMMAND}`. */",
            "/* clang-format off */",
            "#ifndef ROTOR_IDA_DERIVED_ELEMENT_H",
            "#define ROTOR_IDA_DERIVED_ELEMENT_H",
            "",
            '#include "series.h"',
            "",
            "/* What the law of a contact knows. */",
            f"struct element {{\n    double {', '.join(element.PARAMETERS)};\n}};",
            *_law("element", {}, OF_ELEMENT),
            "",
            f"enum {{ {', '.join(names)} }};",
            f"enum {{ {', '.join(map(_answer, [*answers, 'answers']))} }};",
            f"enum {{ {', '.join(slopes)} }};",
            f"enum {{ {', '.join([*of_slopes, 'SLOPES'])} }};",
            f"enum {{ {', '.join([*of_centred, 'CENTRED_SLOPES'])} }};",
            "",
            *(
                line
                for stem, (law, asked) in laws.items()
                for line in _answering(stem, given, law, list(map(_answer, asked)))
            ),
            *_answering("slope", changed, element.slopes_of, of_slopes),
            *_answering("centred_slope", given, element.centred_slopes_of, of_centred),
            "#endif",
            "",
        ]
    )


def _answer(name: str) -> str:
    return f"ELEMENT_{name.upper()}"


def _answering(
    stem: str, given: Mode, law: Callable[..., list[Number]], places: Sequence[str]
) -> list[str]:
    """Return the functions of one law: coefficient n of what it answers, and values."""
    graph = Graph()
    parameters = {name: graph.parameter(name) for name in element.PARAMETERS}
    contact = SimpleNamespace(**parameters, felt=1.0)
    with named_as_in("element.py"):
        answers = law([graph.state(name) for name in given.state], contact)
    nodes = [node for node in needed(answers) if node.changes]
    names = names_of(nodes, answers)
    lanes = sum(lanes_of(node) for node in nodes if needs_convolution(node))
    before, lines = recurrences(given, nodes, names)
    writer = Writer(lambda name: name, names, one="one")
    pairs = list(zip(places, answers, strict=True))
    series = [
        f'_Static_assert({len(given.state)} <= WIDTH && {lanes} <= LANES, "no room");',
        "const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;",
        *[line for line in before if not is_idle(line, [*before, *lines])],
        f"sum_known(series, n, {-(-lanes // LANES_A_VECTOR)});",
        *given_in(nodes, given, "here"), *lines,
        *(f"answers[{place}] = {writer(answer)};" for place, answer in pairs),
    ]  # fmt: skip
    values = values_of([(f"answers[{place}]", answer) for place, answer in pairs], given)
    head = (
        "static inline __attribute__((always_inline)) void {}(\n"
        "    const struct element *m, {}, double *answers)"
    )
    as_values = [
        "/* What it answers, as values. */",
        head.format(f"{stem}_values", "const double *state"),
        "{", *(f"    {line}" for line in values), "}",
        "",
    ]  # fmt: skip
    whose = {
        "element": "a contact",
        "rolling": "one that rolls",
        "massless": "one with a stator without mass",
        "centred": "one without clearance",
        "slope": "a contact that is moved a little",
        "centred_slope": "one without clearance that is moved a little",
    }[stem]
    return [
        f"/* Coefficient n of what {whose} answers, from those up to n of what it is given:",
        f" * {lanes} lanes, which must be empty at n = 0. */",
        head.format(f"{stem}_order", "struct series *series, int n"),
        "{", *(f"    {line}" for line in series), "}",
        "",
        *(as_values if stem in {"element", "massless", "centred"} else []),
    ]  # fmt: skip


def sources_of(model: Model) -> dict[str, str]:
    """Return the names and contents of the files that are derived from a model.

    A library is compiled for one model; the files of the others are then empty.
    """
    source = "spinning" if model is RUN_UP else "modes"
    head = [
        f"/* Derived from rotor_ida/model/{source}.py by `{COMMAND}`. */",
        "/* clang-format off */",
    ]
    stem = "derived" if model is PAPER else f"derived_{model.name}"
    marker = f"ROTOR_IDA_{stem.upper()}_H"
    body = [*head, CHOSEN_BY[model.name], '#include "motion.h"', ""]
    declared = [*head, f"#ifndef {marker}", f"#define {marker}", ""]
    declared += ["#include <math.h>", "", '#include "core.h"', "", *_parameters(model), ""]
    own = {mode.name for mode in model.modes}
    columns = [f"BY_{name.upper()}" for name in model.columns]
    if columns:
        declared += [f"enum {{ {', '.join([*columns, 'PARAMETERS'])} }};"]
    for mode in {mode.name: mode for other in MODELS for mode in other.modes}.values():
        if mode.name not in own:
            body += [f"const struct mode {mode.name}_mode = {{0}}; {ABSENT}", ""]
    products, most_factors = 0, 1
    for mode in model.modes:
        derived = derive(mode, model)
        factors, _ = factors_of(derived) if mode.neighbour else ([], [])
        products = max(products, products_in(derived, factors))
        most_factors = max(most_factors, len(factors))
        names = ", ".join([*(place_of(mode, name) for name in mode.state), place_of(mode, "size")])
        declared.append(f"enum {{ {names} }};")
        for guard in mode.guards:
            declared.append(
                f"enum {{ {place_of(mode, guard.event)}_GUARD = {place_of(mode, guard.of)} }};"
            )
        body += [
            *write_values(derived, model.columns),
            *write_series(derived, []),
            *write_spent(derived),
            *(write_series(derived, factors) if mode.neighbour else []),
            *write_lighter(mode, model),
            *(write_differences(derived) if mode.neighbour else []),
            *write_table(derived, tuple(model.lighter)),
        ]
    whole_vectors = -(-products // LANES_A_VECTOR) * LANES_A_VECTOR
    declared += [
        "/* Products of a series, and series that differences are multiplied by, at most. */",
        f"enum {{ SERIES_PRODUCTS = {whole_vectors}, SERIES_FACTORS = {most_factors} }};",
        *_declare_absent(model),
    ]
    text = "\n".join([*body, "#endif", ""]).replace("\nvoid ", "\nstatic void ")
    return {f"{stem}.c": text, f"{stem}.h": "\n".join([*declared, "", "#endif", ""])}


def main() -> None:
    """Write all derived files."""
    for name, content in sources().items():
        (FOLDER / name).write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main()
