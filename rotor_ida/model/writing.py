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
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

from rotor_ida.model import element
from rotor_ida.model.derivation import (
    Derived,
    derive,
    factors_of,
    is_steady,
    lanes_of,
    needed,
    needs_convolution,
    operands,
)
from rotor_ida.model.modes import PAPER, WHOLE, Mode, Model, Number
from rotor_ida.model.parameters import ALL_PARAMETERS
from rotor_ida.model.spinning import OF_DRIVE, RUN_UP
from rotor_ida.model.symbols import Graph, Symbol, named_as_in, split

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
COMMAND = "python -m rotor_ida.model.writing"
FOLDER = Path(__file__).parents[1] / "core"
# Lanes in a vector, or differences of which a vector contains the same component.
LANES_A_VECTOR = 4
DIFFERENCE = ("x", "y", "vx", "vy")
# Components of a contact without a series: the energy spent, and the heat of sliding.
SPENT = ("spent", "heat")
# Columns of a line inside two levels of braces.
WIDEST = 100 - 9
# How strongly a piece of C binds.
SUM, PRODUCT, ATOM = range(3)


@dataclass(slots=True)
class Writer:
    """Writes expressions.

    Parameters
    ----------
    state : callable
        Returns the C expression of a component of the state, given by name.
    names : dict
        Names already given, by number of the symbol.
    one : str
        Coefficient n of the constant 1 where a series is written; empty for values.
    kind : str
        Type of the results: numbers, ``double``, or vectors of four, ``vec4``.
    """

    state: Callable[[str], str]
    names: dict[int, str] = field(default_factory=dict)
    one: str = ""
    kind: str = "double"

    def __call__(self, node: Symbol, binding: int = SUM) -> str:
        """Return a symbol, in parentheses where it binds less than its context."""
        text, own = self._operand(node)
        return text if own >= binding else f"({text})"

    def _operand(self, node: Symbol) -> tuple[str, int]:
        if self.one and not node.changes:
            return f"{self.one} * {Writer(self.state)(node, ATOM)}", PRODUCT
        if node.number in self.names:
            return self.names[node.number], ATOM
        if node.kind == "number":
            return repr(node.arguments[0]), ATOM if node.arguments[0] >= 0.0 else PRODUCT
        if node.kind == "parameter":
            return f"m->{node.name}", ATOM
        return (self.state(node.name), ATOM) if node.kind == "state" else self.operation(node)

    def operation(self, node: Symbol) -> tuple[str, int]:
        """Return the operation of a symbol, and how strongly it binds."""
        a, b = node.arguments
        if node.kind == "**":
            return _power(self(a), b, self.kind if a.changes else "double"), ATOM
        if node.kind == "*":
            factor = self(a, PRODUCT) if a.changes else Writer(self.state)(a, PRODUCT)
            minus = factor == "-1.0"
            return f"-{self(b, ATOM)}" if minus else f"{factor} * {self(b, ATOM)}", PRODUCT
        if node.kind == "/":
            form = "ratio({}, {})" if self.kind == "double" else "({}) / ({})"
            return form.format(self(a), self(b)), ATOM
        return f"{self(a)} {node.kind} {self(b, PRODUCT)}", SUM


def _power(base: str, exponent: float, kind: str) -> str:
    """Return a power, by roots where possible; that of a named vector lane by lane."""
    if kind != "double":
        lanes = [_power(f"{base}[{i}]", exponent, "double") for i in range(LANES_A_VECTOR)]
        return f"({kind}){{{', '.join(lanes)}}}"
    if exponent == 0.25:
        return f"sqrt(sqrt({base}))"
    return f"sqrt({base})" if exponent == 0.5 else f"pow({base}, {exponent!r})"


def _names_of(nodes: Sequence[Symbol], outputs: Sequence[Symbol]) -> dict[int, str]:
    """Return names for symbols that the model names or uses more than once, and for products."""
    used = Counter(operand.number for node in nodes for operand in operands(node))
    used.update(output.number for output in outputs)
    # the first coefficient of a base is needed separately
    bases = {node.arguments[0].number for node in nodes if node.kind == "**"}
    of_state = {node.name for node in nodes if node.kind == "state"}
    names: dict[int, str] = {}
    for node in nodes:
        if node.kind in {"number", "parameter", "state"} or not node.changes:
            continue
        name = node.name
        is_asked = used[node.number] > 1 or node.number in bases or needs_convolution(node)
        if not name and is_asked:
            name = f"w{len(names)}"
        while name in of_state or name in names.values():
            name += "_"
        if name:
            names[node.number] = name
    return names


def _values(outputs: Sequence[tuple[str, Symbol]], mode: Mode, kind: str = "double") -> list[str]:
    """Return the lines that compute outputs, given as pairs of target and value.

    They are numbers, or vectors of numbers.
    """
    symbols = [symbol for _, symbol in outputs]
    nodes = needed(symbols)
    names = _names_of(nodes, [])
    lines = _given(nodes, mode, "state", kind)
    writer = Writer(lambda name: name, kind=kind)
    for node in nodes:
        if node.number in names:
            lines.append(f"const {kind} {names[node.number]} = {writer(node)};")
            writer.names[node.number] = names[node.number]
    for place, symbol in outputs:
        scalar = kind != "double" and not symbol.changes
        said = writer(symbol)
        lines.append(f"{place} = spread({said});" if scalar else f"{place} = {said};")
    return lines


def _given(nodes: Sequence[Symbol], mode: Mode, row: str, kind: str = "double") -> list[str]:
    """Return the lines that name the required components of a state."""
    return [f"const {kind} {name} = {row}[{_place(mode, name)}];" for name in _used(nodes, mode)]


def _used(nodes: Sequence[Symbol], mode: Mode) -> list[str]:
    """Return the required components of a state."""
    used = {node.name for node in nodes if node.kind == "state"}
    return [name for name in mode.state if name in used]


def _place(mode: Mode, name: str) -> str:
    return f"{mode.name}_{name}".upper()


def _function(name: str, given: str, comment: str, lines: Sequence[str]) -> list[str]:
    """Return a function."""
    head = f"void {name}(const struct parameters *m,\n    {given})"
    unused = [] if any("m->" in line for line in lines) else ["(void)m;"]
    return [f"/* {comment} */", head, "{", *(f"    {line}" for line in [*unused, *lines]), "}", ""]


def write_values(derived: Derived, columns: Sequence[str]) -> list[str]:
    """Return field, Jacobian, growth and parameter derivatives, as functions of the state."""
    mode, size = derived.mode, len(derived.mode.state)
    rates = zip(mode.state, derived.drawn_rates, strict=True)
    drawn = "" if derived.drawn_rates == derived.rates else ", drawn back to where they belong"
    matrix = [
        (f"matrix[{size * column + row}]", derived.jacobian[row][column])
        for column in range(size)
        for row in range(size)
        if not derived.jacobian[row][column].is_number(0.0)
    ]
    cleared = [f"for (int i = 0; i < {size * size}; i++)", "    matrix[i] = 0.0;"]
    growth = [
        (f"growth[{i}][{j}]", entry)
        for i, row in enumerate(derived.growth)
        for j, entry in enumerate(row)
    ]
    rows = range(len(derived.by_parameters))
    added = [(f"added[{i}][{j}]", derived.by_parameters[i][j]) for i in rows for j in range(4)]
    of_neighbours = [
        *_function(
            f"{mode.name}_growth",
            "const double *state, double growth[4][4]",
            "The rates of a small difference are this matrix times it.",
            _values(growth, mode),
        ),
        *_function(
            f"{mode.name}_by_parameters",
            "const double *state, double added[PARAMETERS][4]",
            f"What {', '.join(columns)} add to the rates by time of position and velocity.",
            _values(added, mode),
        ),
    ]
    return [
        *_function(
            f"{mode.name}_field",
            "const double *state, double *rate",
            f"The rates of change of {', '.join(mode.state)}{drawn}.",
            _values([(f"rate[{_place(mode, name)}]", rate) for name, rate in rates], mode),
        ),
        *_function(
            f"{mode.name}_jacobian",
            "const double *state, double *matrix",
            "Their derivatives by each of these, column by column.",
            cleared + _values(matrix, mode),
        ),
        *(of_neighbours if mode.neighbour else []),
        *_write_watched(derived),
    ]


def _write_watched(derived: Derived) -> list[str]:
    """Return the function of the watched quantities and their rates of change."""
    if not derived.watched:
        return []
    places = [(f"watched[{i}]", each) for i, each in enumerate(derived.watched)]
    places += [(f"rate[{i}]", each) for i, each in enumerate(derived.watched_rates)]
    return _function(
        f"{derived.mode.name}_watched",
        "const double *state, double *watched, double *rate",
        "What is watched beside the state, and how it changes.",
        _values(places, derived.mode),
    )


def write_spent(derived: Derived, way: str = "") -> list[str]:
    """Return the function of a contact's energy losses at eight points of a step, four at once."""
    mode = derived.mode
    rates = dict(zip(mode.state, derived.drawn_rates, strict=True))
    outputs = [(f"rate[v][{i}]", rates[name]) for i, name in enumerate(SPENT) if name in rates]
    if not outputs:
        return []
    used = _used(needed(rate for _, rate in outputs), mode)
    lines = _values(outputs, mode, "vec4")
    for place, name in enumerate(used):
        lines[place] = f"const vec4 {name} = read[{place}][v];"
    if len(outputs) < len(SPENT):
        lines.append("rate[v][1] = spread(0.0);")
    return _function(
        f"{mode.name}_spent{way and f'_{way}'}",
        "const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2]",
        "The rates of what damping, load and drive take, and of the heat, at parts of a step.",
        [
            f"static const int reads[] = {{{', '.join(_place(mode, each) for each in used)}}};",
            f"vec4 read[{len(used)}][AT_ONCE];",
            f"read_parts(series, order, reads, {len(used)}, parts, read);",
            "for (int v = 0; v < AT_ONCE; v++) {",
            *(f"    {line}" for line in lines),
            "}",
        ],
    )


def write_series(derived: Derived, factors: Sequence[Symbol], way: str = "") -> list[str]:
    """Return the function that expands the state, and the factors of differences.

    `way` names a lighter version.
    """
    mode = derived.mode
    outputs = [*derived.rates, *factors, *derived.watched]
    nodes = [node for node in needed(outputs) if node.changes]
    names = _names_of(nodes, outputs)
    lanes = sum(lanes_of(node) for node in nodes if needs_convolution(node))
    before, lines = _recurrences(mode, nodes, names)
    writer = Writer(lambda name: name, names, one="one")
    for name, rate in zip(mode.state, derived.rates, strict=True):
        lines.append(f"terms[{_place(mode, name)}] = {writer(rate, PRODUCT)} * share;")
    for number, factor in enumerate(factors):
        lines.append(f"series->factors[{number}][n] = {writer(factor)};")
    for number, watched in enumerate(derived.watched):
        lines.append(f"series->watched[n][{number}] = {writer(watched)};")
    changing = [*_given(nodes, mode, "here"), *lines]
    if any("one * " in line for line in changing):
        before.append("double one = 1.0; /* coefficient n of 1 */")
        changing.append("one = 0.0;")
    body = [
        *before,
        "begin_lanes(series);",
        "for (int n = 0; n < order; n++) {",
        f"    sum_known(series, n, {-(-lanes // LANES_A_VECTOR)});",
        "    const double *here = series->terms[n];",
        "    double *terms = series->terms[n + 1];",
        "    const double share = 1.0 / (n + 1);",
        *(f"    {line}" for line in changing),
        "}",
    ]
    body = [line for line in body if not _is_idle(line, body)]
    fits = f"{len(mode.state)} <= WIDTH && {lanes} <= LANES && {len(factors)} <= FACTORS"
    body.insert(0, f'_Static_assert({fits}, "series.h has no room for this mode");')
    what = "the state, and the factors of differences" if factors else "the state"
    return _function(
        f"{mode.name}_expand" + ("_with_factors" if factors else way and f"_{way}"),
        "struct series *series, int order",
        f"The Taylor series of {what}: {lanes} lanes.",
        body,
    )


def _write_lighter(mode: Mode, model: Model) -> list[str]:
    """Return the functions that expand the state of a mode with fewer products."""
    lines = []
    for way, fixed in model.lighter.items():
        lighter = derive(mode, model, fixed)
        lines += write_series(lighter, [], way) + write_spent(lighter, way)
    return lines


def _is_idle(line: str, body: Sequence[str]) -> bool:
    """Return whether a line names a first value that no other line needs."""
    name = line.removeprefix("const double ").split(" = ")[0]
    if not name.endswith("_first"):
        return False
    return not any(re.search(rf"\b{name}\b", other) for other in body if other != line)


def _recurrences(
    mode: Mode, nodes: Sequence[Symbol], names: dict[int, str]
) -> tuple[list[str], list[str]]:
    """Return the lines computed once, and those of coefficient n of each named symbol."""
    first = Writer("{}_first".format)
    writer, shown = Writer(lambda name: name, names, one="one"), Writer(lambda name: name, names)
    before = [line.replace(" = ", "_first = ") for line in _given(nodes, mode, "series->terms[0]")]
    lines: list[str] = []
    lane = 0

    def at_first(node: Symbol, what: str) -> str:
        name = f"{what}_{names[node.number]}"
        said = first(node) if what == "first" else f"inverse({first(node)})"
        line = f"const double {name} = {said};"
        before.extend([line] if line not in before else [])
        return name

    for node in nodes:
        if node.number not in names:
            continue
        a, b = node.arguments
        end = ""
        if not needs_convolution(node):
            said, _ = writer.operation(node)
        elif node.kind == "*":
            said, end = (
                f"times(series, {lane}, n, {writer(a)}, {writer(b)})",
                shown.operation(node)[0],
            )
        elif node.kind == "/":
            said = f"over(series, {lane}, n, {writer(a)}, {writer(b)}, {at_first(b, 'inverse')})"
            end = f"{shown(a, PRODUCT)} / {shown(b, ATOM)}"
        else:
            known = f"one * {at_first(node, 'first')}, {at_first(a, 'inverse')}"
            said = f"raised(series, {lane}, n, {writer(a)}, {b!r}, {known})"
            end = f"{shown(a, ATOM)}**{b!r}"
        line = f"const double {names[node.number]} = {said};"
        comment = f"/* {end} */".replace("m->", "") if end else ""
        fits = len(line) + len(comment) < WIDEST
        lines += [f"{line} {comment}".rstrip()] if fits else [*filter(None, [comment]), line]
        lane += lanes_of(node) if needs_convolution(node) else 0
    return before, lines


def write_differences(derived: Derived) -> list[str]:
    """Return the function that expands four differences at a time."""
    _, places = factors_of(derived)
    moving = derived.pace.changes
    body = ["for (int n = 0; n < order; n++) {"]
    body += [f"    {line}" for line in _steady_part(derived)]
    if moving:
        body += [f"    vec4 sum_{name} = spread(0.0);" for name in DIFFERENCE]
    body += ["    /* the row written last comes last, as it is waited for */"]
    body += ["    for (int k = 0; k <= n; k++) {"]
    if moving:
        body += ["        const vec4 pace = spread(series->factors[0][n - k]);"]
        body += [_added(name, "pace", f"steady[k][{4 * i}]") for i, name in enumerate(DIFFERENCE)]
    for number in sorted({place.factor for place in places}):
        body += [f"        const vec4 f{number} = spread(series->factors[{number}][n - k]);"]
        for place in places:
            if place.factor == number:
                factor = f"-f{number}" if place.negative else f"f{number}"
                body += [_added(DIFFERENCE[place.row], factor, f"apart[k][{4 * place.column}]")]
    body += ["    }", "    const vec4 share = spread(1.0 / (n + 1));"]
    body += [
        f"    store(&series->apart[n + 1][{4 * i}], share * sum_{name});"
        for i, name in enumerate(DIFFERENCE)
    ]
    return _function(
        f"{derived.mode.name}_expand_differences",
        "struct series *series, int order",
        "The Taylor series of four differences, from the factors that the state has given.",
        [*body, "}"],
    )


def _added(name: str, factor: str, row: str) -> str:
    return f"        sum_{name} = fma4({factor}, load(&series->{row}), sum_{name});"


def _steady_part(derived: Derived) -> list[str]:
    """Return the lines of terms that the pace multiplies, or of their sums if it is constant."""
    moving, used, lines = derived.pace.changes, set[int](), ["/* what does not change in time */"]
    for i, name in enumerate(DIFFERENCE):
        terms = []
        for j, entry in enumerate(derived.growth[i]):
            if is_steady(entry, derived.pace) and not entry.is_number(0.0):
                factor = Writer(lambda name: name)(split(entry)[0] if moving else entry)
                terms.append(
                    DIFFERENCE[j] if factor == "1.0" else f"spread({factor}) * {DIFFERENCE[j]}"
                )
                used.add(j)
        said = " + ".join(terms) or "spread(0.0)"
        if moving:
            lines.append(f"store(&series->steady[n][{4 * i}], {said});")
        else:
            lines.append(f"vec4 sum_{name} = {said};")
    rows = [
        f"const vec4 {name} = load(&series->apart[n][{4 * j}]);"
        for j, name in enumerate(DIFFERENCE)
        if j in used
    ]
    return rows + lines


def write_table(derived: Derived, lighter: Sequence[str]) -> list[str]:
    """Return the table of the functions derived from a mode."""
    name = derived.mode.name
    near = derived.mode.neighbour is not None
    functions = [
        *("field", "jacobian"),
        *(("growth", "by_parameters") if near else ()),
        *("expand", *(f"expand_{way}" for way in lighter)),
        *(("expand_with_factors", "expand_differences") if near else ()),
        *(["watched"] if derived.watched else []),
    ]
    ways = ["spent", *(f"spent_{way}" for way in lighter)]
    return [
        f"const struct mode {name}_mode = {{",
        f"    .size = {name.upper()}_SIZE,",
        *(f"    .{each} = {name}_{each}," for each in functions),
        *(f"    .{each} = {name}_{each}," for each in ways if SPENT[0] in derived.mode.state),
        "};",
        "",
    ]


def _parameters(model: Model) -> list[str]:
    """Return the structure of all parameters of a mode, and its conversion from a rotor."""
    head = "static inline struct parameters parameters_of(const struct rotor *rotor, double felt)"
    special = {
        "felt": "felt",
        "pressed": "1.0",
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
    ]


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
            *(_place(mode, name) for name in (*mode.state, "size")),
            *(f"{_place(mode, guard.event)}_GUARD" for guard in mode.guards),
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
        [_place(each, name) for name in (*each.state, "given")] for each in (given, changed)
    )
    of_slopes = [f"SLOPE_BY_{name.upper()}" for name in element.SLOPES]
    laws = {
        "element": (element.answers_of, element.ANSWERS),
        "rolling": (element.rolling_answers_of, element.ROLLING_ANSWERS),
        "massless": (element.massless_answers_of, element.MASSLESS_ANSWERS),
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
            "",
            f"enum {{ {', '.join(names)} }};",
            f"enum {{ {', '.join(map(_answer, [*answers, 'answers']))} }};",
            f"enum {{ {', '.join(slopes)} }};",
            f"enum {{ {', '.join([*of_slopes, 'SLOPES'])} }};",
            "",
            *(
                line
                for stem, (law, asked) in laws.items()
                for line in _answering(stem, given, law, list(map(_answer, asked)))
            ),
            *_answering("slope", changed, element.slopes_of, of_slopes),
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
    contact = SimpleNamespace(**{name: graph.parameter(name) for name in element.PARAMETERS})
    with named_as_in("element.py"):
        answers = law([graph.state(name) for name in given.state], contact)
    nodes = [node for node in needed(answers) if node.changes]
    names = _names_of(nodes, answers)
    lanes = sum(lanes_of(node) for node in nodes if needs_convolution(node))
    before, lines = _recurrences(given, nodes, names)
    writer = Writer(lambda name: name, names, one="one")
    pairs = list(zip(places, answers, strict=True))
    series = [
        f'_Static_assert({len(given.state)} <= WIDTH && {lanes} <= LANES, "no room");',
        "const double *here = series->terms[n], one = n == 0 ? 1.0 : 0.0;",
        *[line for line in before if not _is_idle(line, [*before, *lines])],
        f"sum_known(series, n, {-(-lanes // LANES_A_VECTOR)});",
        *_given(nodes, given, "here"), *lines,
        *(f"answers[{place}] = {writer(answer)};" for place, answer in pairs),
    ]  # fmt: skip
    values = _values([(f"answers[{place}]", answer) for place, answer in pairs], given)
    head = "static inline void {}(const struct element *m,\n    {}, double *answers)"
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
        "slope": "a contact that is moved a little",
    }[stem]
    return [
        f"/* Coefficient n of what {whose} answers, from those up to n of what it is given:",
        f" * {lanes} lanes, which must be empty at n = 0. */",
        head.format(f"{stem}_order", "struct series *series, int n"),
        "{", *(f"    {line}" for line in series), "}",
        "",
        *(as_values if stem in {"element", "massless"} else []),
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
    declared += ['#include "core.h"', "", *_parameters(model), ""]
    own = {mode.name for mode in model.modes}
    columns = [f"BY_{name.upper()}" for name in model.columns]
    if columns:
        declared += [f"enum {{ {', '.join([*columns, 'PARAMETERS'])} }};"]
    for mode in {mode.name: mode for other in MODELS for mode in other.modes}.values():
        if mode.name not in own:
            body += [f"const struct mode {mode.name}_mode = {{0}}; {ABSENT}", ""]
    for mode in model.modes:
        derived = derive(mode, model)
        factors, _ = factors_of(derived)
        names = ", ".join([*(_place(mode, name) for name in mode.state), _place(mode, "size")])
        declared.append(f"enum {{ {names} }};")
        for guard in mode.guards:
            declared.append(
                f"enum {{ {_place(mode, guard.event)}_GUARD = {_place(mode, guard.of)} }};"
            )
        body += [
            *write_values(derived, model.columns),
            *write_series(derived, []),
            *write_spent(derived),
            *(write_series(derived, factors) if mode.neighbour else []),
            *_write_lighter(mode, model),
            *(write_differences(derived) if mode.neighbour else []),
            *write_table(derived, tuple(model.lighter)),
        ]
    declared += _declare_absent(model)
    text = "\n".join([*body, "#endif", ""]).replace("\nvoid ", "\nstatic void ")
    return {f"{stem}.c": text, f"{stem}.h": "\n".join([*declared, "", "#endif", ""])}


def main() -> None:
    """Write all derived files."""
    for name, content in sources().items():
        (FOLDER / name).write_text(content, encoding="utf-8")


if __name__ == "__main__":
    main()
