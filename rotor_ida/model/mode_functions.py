"""Write the C functions of one mode: values, Taylor series, and small differences."""

from __future__ import annotations

from collections.abc import Sequence

from rotor_ida.model.derivation import (
    Derived,
    derive,
    factors_of,
    is_steady,
    lanes_of,
    needed,
    needs_convolution,
)
from rotor_ida.model.expressions import (
    LANES_A_VECTOR,
    PRODUCT,
    Writer,
    function_of,
    given_in,
    is_idle,
    names_of,
    place_of,
    recurrences,
    used_in,
    values_of,
)
from rotor_ida.model.modes import Mode, Model
from rotor_ida.model.symbols import Symbol, split

DIFFERENCE = ("x", "y", "vx", "vy")
# Components of a contact without a series: the energy spent, and the heat of sliding.
SPENT = ("spent", "heat")


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
    return [
        *function_of(
            f"{mode.name}_field",
            "const double *state, double *rate",
            f"The rates of change of {', '.join(mode.state)}{drawn}.",
            values_of([(f"rate[{place_of(mode, name)}]", rate) for name, rate in rates], mode),
        ),
        *function_of(
            f"{mode.name}_jacobian",
            "const double *state, double *matrix",
            "Their derivatives by each of these, column by column.",
            cleared + values_of(matrix, mode),
        ),
        *(_write_neighbour(derived, columns) if mode.neighbour else []),
        *_write_watched(derived),
    ]


def _write_neighbour(derived: Derived, columns: Sequence[str]) -> list[str]:
    """Return the functions of small differences and of the derivatives by the parameters."""
    mode = derived.mode
    growth, added = (
        [(f"{name}[{i}][{j}]", entry) for i, row in enumerate(rows) for j, entry in enumerate(row)]
        for name, rows in (("growth", derived.growth), ("added", derived.by_parameters))
    )
    return [
        *function_of(
            f"{mode.name}_growth",
            "const double *state, double growth[4][4]",
            "The rates of a small difference are this matrix times it.",
            values_of(growth, mode),
        ),
        *function_of(
            f"{mode.name}_by_parameters",
            "const double *state, double added[PARAMETERS][4]",
            f"What {', '.join(columns)} add to the rates by time of position and velocity.",
            values_of(added, mode),
        ),
    ]


def _write_watched(derived: Derived) -> list[str]:
    """Return the function of the watched quantities and their rates of change."""
    if not derived.watched:
        return []
    places = [(f"watched[{i}]", each) for i, each in enumerate(derived.watched)]
    places += [(f"rate[{i}]", each) for i, each in enumerate(derived.watched_rates)]
    return function_of(
        f"{derived.mode.name}_watched",
        "const double *state, double *watched, double *rate",
        "What is watched beside the state, and how it changes.",
        values_of(places, derived.mode),
    )


def write_spent(derived: Derived, way: str = "") -> list[str]:
    """Return the function of a contact's energy losses at eight points of a step, four at once."""
    mode = derived.mode
    rates = dict(zip(mode.state, derived.drawn_rates, strict=True))
    outputs = [(f"rate[v][{i}]", rates[name]) for i, name in enumerate(SPENT) if name in rates]
    if not outputs:
        return []
    used = used_in(needed(rate for _, rate in outputs), mode)
    lines = values_of(outputs, mode, "vec4")
    for place, name in enumerate(used):
        lines[place] = f"const vec4 {name} = read[{place}][v];"
    if len(outputs) < len(SPENT):
        lines.append("rate[v][1] = spread(0.0);")
    return function_of(
        f"{mode.name}_spent{way and f'_{way}'}",
        "const struct series *series, int order, const vec4 *parts, vec4 (*rate)[2]",
        "The rates of what damping, load and drive take, and of the heat, at parts of a step.",
        [
            f"static const int reads[] = {{{', '.join(place_of(mode, each) for each in used)}}};",
            f"vec4 read[{len(used)}][AT_ONCE];",
            f"read_parts(series, order, reads, {len(used)}, parts, read);",
            "for (int v = 0; v < AT_ONCE; v++) {",
            *(f"    {line}" for line in lines),
            "}",
        ],
    )


def products_in(derived: Derived, factors: Sequence[Symbol] = ()) -> int:
    """Return the number of products in the series of the state, and of factors of differences."""
    nodes = needed([*derived.rates, *factors, *derived.watched])
    return sum(lanes_of(node) for node in nodes if node.changes and needs_convolution(node))


def write_series(derived: Derived, factors: Sequence[Symbol], way: str = "") -> list[str]:
    """Return the function that expands the state, and the factors of differences.

    `way` names a lighter version.
    """
    mode = derived.mode
    outputs = [*derived.rates, *factors, *derived.watched]
    nodes = [node for node in needed(outputs) if node.changes]
    names = names_of(nodes, outputs)
    lanes = products_in(derived, factors)
    before, lines = recurrences(mode, nodes, names)
    writer = Writer(lambda name: name, names, one="one")
    for name, rate in zip(mode.state, derived.rates, strict=True):
        lines.append(f"terms[{place_of(mode, name)}] = {writer(rate, PRODUCT)} * share;")
    for number, factor in enumerate(factors):
        lines.append(f"series->factors[{number}][n] = {writer(factor)};")
    for number, watched in enumerate(derived.watched):
        lines.append(f"series->watched[n][{number}] = {writer(watched)};")
    changing = [*given_in(nodes, mode, "here"), *lines]
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
    body = [line for line in body if not is_idle(line, body)]
    fits = f"{len(mode.state)} <= WIDTH && {lanes} <= LANES && {len(factors)} <= FACTORS"
    body.insert(0, f'_Static_assert({fits}, "series.h has no room for this mode");')
    what = "the state, and the factors of differences" if factors else "the state"
    return function_of(
        f"{mode.name}_expand" + ("_with_factors" if factors else way and f"_{way}"),
        "struct series *series, int order",
        f"The Taylor series of {what}: {lanes} lanes.",
        body,
    )


def write_lighter(mode: Mode, model: Model) -> list[str]:
    """Return the functions that expand the state of a mode with fewer products."""
    lines = []
    for way, fixed in model.lighter.items():
        lighter = derive(mode, model, fixed)
        lines += write_series(lighter, [], way) + write_spent(lighter, way)
    return lines


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
    return function_of(
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
