"""Pages of the reference that come from the code: the public names, and the command line."""

import io
import re
import shutil
from pathlib import Path

from notation import public_names
from rich.console import Console

from rotor_ida import schema
from rotor_ida.cli.program import COMMANDS, application

HERE = Path(__file__).parents[1]
PARTS = {
    "rotor_ida": "The main functions",
    "rotor_ida.closed_forms": "Closed forms",
    "rotor_ida.plot": "Figures",
    "rotor_ida.testing": "For tests of one's own",
    "rotor_ida.paper.printed": "The paper's formulas, as printed",
}
HEAD = """Functions and classes
=====================

Every public name, from its docstring. Quantities are dimensionless where a docstring says ``[1]``;
:doc:`/model` says by what they are divided.

"""


def write_names():
    """Write the page of names; autosummary makes a page of each."""
    text = HEAD
    for module, title in PARTS.items():
        names = [f"   {name}" for name in public_names(module) if not name.isupper()]
        text += f"{title}\n{'-' * len(title)}\n\n.. currentmodule:: {module}\n\n"
        text += ".. autosummary::\n   :toctree: api\n   :template: name.rst\n\n"
        text += "\n".join(names) + "\n\n"
    write(HERE / "functions.rst", text)


def write_commands():
    """Write the page of commands from their own help."""
    console = Console(file=io.StringIO())
    found = application(console).generate_docs(output_format="markdown")
    found = re.sub(r"## Table of Contents\n\n(?:- .*\n)+\n", "", found)
    for commands in COMMANDS.values():
        for command, short in commands.items():
            name = command.__name__.replace("_", "-")
            link = f"[`{name}`](#rotor-ida-{name})"
            found = found.replace(link, f"{link} (`{short}`)" if short else link)
    write(HERE / "command_line.md", found.replace("# rotor-ida\n", "# The command line\n", 1))


def write(path, text):
    """Write a file if it is to change, so that what is up to date stays so."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def write_categories():
    """Write the page of the words of categories, and the numbers that stand for them."""
    lines = [
        "# Categories",
        "",
        "Categories are small integers; `flag_values` and `flag_meanings` of a variable say so in",
        "every dataset, and `rotor_ida.schema` has them as dictionaries.",
        "",
    ]
    for name, flags in vars(schema).items():
        if name.isupper() and isinstance(flags, dict) and set(map(type, flags.values())) == {int}:
            words = ", ".join(f"{word} {number}" for word, number in flags.items())
            lines.append(f"- `{name}`: {words}")
    write(HERE / "categories.md", "\n".join(lines) + "\n")


def setup(_app):
    """Write the pages before Sphinx looks for its sources; what an older build wrote goes."""
    for folder in ("api", "gallery", "tutorials"):
        shutil.rmtree(HERE / folder, ignore_errors=True)
    write_names()
    write_categories()
    write_commands()
    return {"parallel_read_safe": True}
