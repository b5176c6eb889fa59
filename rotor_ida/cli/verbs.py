"""What the functions of the package say of their arguments, read from their source.

The command line answers ``--help`` without importing a solver: types, choices, defaults and texts
of its options are those of signatures and docstrings, which are parsed instead of imported.
"""

from __future__ import annotations

import ast
import inspect
import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

PACKAGE = Path(__file__).parents[1]
NEEDED = inspect.Parameter.empty
# An entry of the section on parameters: names, and the indented text below them.
ENTRY = re.compile(r"^(\S[^\n]*?)(?: : ([^\n]*))?\n((?:    [^\n]*\n?)+)", re.MULTILINE)
DEFAULT = re.compile(r"[Dd]efault\b|By default\b")
# Words of Python and of formulas, and those of the command line for them.
MARKUP = (
    (r" \[rad\]", ", in radians"), (r" \[degree\]", ", in degrees"),
    (r" \[[^]|]+\](?=[ ,.;:])", ""), (r"``|\*\*", ""),
    (r"`(\w+)`", r"\1"), (r"RotorSystem", "rotor system"),
)  # fmt: skip


class Argument(NamedTuple):
    """A keyword of a function: its annotation, choices, default (`NEEDED` if none), and text."""

    name: str
    kind: str
    choices: tuple[str, ...]
    default: object
    text: str


@cache
def arguments_of(verb: str) -> dict[str, Argument]:
    """Return the keywords of a public function by name; others are in ``**`` of a kind.

    The function is one of the package, or of a room of it such as ``plot.plot_orbit``.

    Examples
    --------
    >>> skip = arguments_of("poincare_section")["skip"]
    >>> skip.kind, skip.default, skip.text
    ('int', 0, 'Number of earlier revolutions to skip as a transient, at most 10 million.')
    >>> arguments_of("sweep")["direction"].choices
    ('up', 'down', 'both')
    """
    place, found = _function(verb)
    texts = _texts(verb)
    told = {}
    for each, default in zip(found.args.kwonlyargs, found.args.kw_defaults, strict=True):
        assert each.annotation is not None
        value = NEEDED if default is None else _value(place, default)
        kind, (text, words) = ast.unparse(each.annotation), texts.get(each.arg, ("", ()))
        if not kind.startswith("str"):
            has_words = each.arg not in {"start", "starts", "progress"}
            words = _choices(place, each.annotation) if has_words else ()
        told[each.arg] = Argument(each.arg, kind, words, value, text)
    if found.args.kwarg is not None and found.args.kwarg.annotation is not None:
        name = found.args.kwarg.arg
        kind = ast.unparse(found.args.kwarg.annotation)
        told[f"**{name}"] = Argument(f"**{name}", kind, (), NEEDED, "")
    return told


def short_text(text: str) -> str:
    """Return the first sentence of a text for the command line, and those on the default.

    Examples
    --------
    >>> short_text("Time to simulate [dimensionless]. It is long. Default: ``100``.")
    'Time to simulate. Default: 100.'
    """
    text = re.sub(r"`rotor_ida\.(\w+)`", lambda named: named[1].replace("_", "-"), text)
    for markup, plain in MARKUP:
        text = re.sub(markup, plain, text)
    first, *others = re.split(r"(?<=\.) (?=[A-Z])", text)
    return " ".join([first, *(each for each in others if DEFAULT.match(each))])


def _function(verb: str) -> tuple[str, ast.FunctionDef]:
    """Return the module that defines a public function, and the function."""
    room, _, name = f"rotor_ida.{verb}".rpartition(".")
    place, found = _definition(room, name)
    assert isinstance(found, ast.FunctionDef)
    return place, found


@cache
def _texts(verb: str) -> dict[str, tuple[str, tuple[str, ...]]]:
    """Return text and choices of the arguments of a function, or of another one it refers to."""
    room = verb[: verb.rfind(".") + 1]
    section = (ast.get_docstring(_function(verb)[1]) or "").partition("Parameters\n----------\n")[2]
    texts: dict[str, tuple[str, tuple[str, ...]]] = {}
    for names, kind, text in ENTRY.findall(section.partition("\nReturns\n")[0]):
        line = " ".join(text.split())
        only = re.fullmatch(r"\{(.*)\}(?:, optional)?", kind)
        words = tuple(re.findall(r'"(\w+)"', only[1])) if only else ()
        other = re.match(r"As (?:in|for) `(rotor_ida\.)?(\w+)`", line)
        of = other and (other[2] if other[1] else room + other[2])
        for name in names.split(", "):
            texts[name] = (of and _texts(of).get(name)) or (line, words)
    return texts


@cache
def _tree(module: str) -> ast.Module:
    """Return the syntax tree of a module; of the package that of its stub, which has all names."""
    place = PACKAGE.joinpath(*module.split(".")[1:])
    files = (place / "__init__.pyi", place / "__init__.py", place.with_suffix(".py"))
    file = next(each for each in files if each.is_file())
    return ast.parse(file.read_text(encoding="utf-8"))


def _definition(module: str, name: str) -> tuple[str, ast.AST]:
    """Return the module that defines a name, and the function or the value; follow its imports."""
    for node in _tree(module).body:
        if isinstance(node, ast.FunctionDef) and node.name == name:
            return module, node
        if isinstance(node, ast.Assign | ast.AnnAssign) and node.value is not None:
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            if any(isinstance(each, ast.Name) and each.id == name for each in targets):
                return module, node.value
    imported = _imports(module).get(name)
    if imported is None:
        raise LookupError(f"{module} does not define {name}")
    return _definition(*imported)


@cache
def _imports(module: str) -> dict[str, tuple[str, str]]:
    """Return what a module imports from the package: for each name, module and name there."""
    body = _tree(module).body
    body = body + [node for each in body if isinstance(each, ast.If) for node in each.body]
    return {
        alias.asname or alias.name: (f"{module}.{of}" if node.level else of, alias.name)
        for node in body
        if isinstance(node, ast.ImportFrom)
        and ((of := node.module or "").startswith(PACKAGE.name) or node.level)
        for alias in node.names
    }


def _choices(module: str, annotation: ast.AST) -> tuple[str, ...]:
    """Return the words of a Literal in an annotation, or of one that it names."""
    annotation = annotation.left if isinstance(annotation, ast.BinOp) else annotation  # X | None
    for node in ast.walk(annotation):
        if isinstance(node, ast.Name):
            if node.id == "Literal":
                return tuple(
                    each.value for each in ast.walk(annotation)
                    if isinstance(each, ast.Constant) and isinstance(each.value, str)
                )  # fmt: skip
            try:
                place, value = _definition(module, node.id)
            except LookupError:
                continue
            if isinstance(value, ast.Subscript) and ast.unparse(value.value) == "Literal":
                return _choices(place, value)
    return ()


def _value(module: str, default: ast.AST) -> object:
    """Return a default value; that of a name is where it is defined."""
    try:
        while isinstance(default, ast.Name):
            module, default = _definition(module, default.id)
        return ast.literal_eval(ast.unparse(default))
    except (LookupError, ValueError):
        return None
