"""Formulas as MathML, which browsers show by themselves, names as links, sessions in colour."""

import importlib
from functools import lru_cache

from docutils import nodes
from latex2mathml.converter import convert
from sphinx import addnodes

# Words of the field that are names of functions too; as links they need their brackets or module.
WORDS = {
    *("basin", "cusp", "flight", "folds", "impact", "jumps", "load", "peaks"),
    *("rest", "rotating", "status"),
}
# Where a name in single backticks is looked for.
HOMES = ("rotor_ida", "rotor_ida.closed_forms", "rotor_ida.plot", "rotor_ida.testing")


def inline(translator, node):
    """Write a formula in a line."""
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def displayed(translator, node):
    """Write a formula that stands alone."""
    formula = convert(node.astext(), display="block")
    translator.body.append(f'<div class="formula">{formula}</div>\n')
    raise nodes.SkipNode


def name_role(_role, rawtext, text, _line, inliner, _options=None, _content=None):
    """Return a link to what is public, and plain code for any other name."""
    return [linked(nodes.literal(rawtext, text), inliner.document.settings.env.docname)], []


def link_names(app, doctree):
    """Make links of the public names that stand as code in prose."""
    for code in list(doctree.findall(nodes.literal)):
        is_link = isinstance(code.parent, nodes.reference | addnodes.pending_xref)
        if not is_link and code.astext() not in WORDS:
            code.replace_self(linked(code.deepcopy(), app.env.docname))


def colour_sessions(_app, doctree):
    """Say of blocks that begin with a prompt that they are Python; Markdown does not name them."""
    for block in doctree.findall(nodes.literal_block):
        if block.astext().lstrip().startswith(">>> "):
            block["language"] = "pycon"


def linked(code, page):
    """Return code as a link to what it names, or as it is if that is not public."""
    word = code.astext().removesuffix("()")
    for home in HOMES:
        short = word.removeprefix(f"{home}.")
        if short in public_names(home):
            return addnodes.pending_xref(
                "", code, refdomain="py", reftype="obj", reftarget=f"{home}.{short}",
                refexplicit=False, refwarn=True, refdoc=page,
            )  # fmt: skip
    return code


@lru_cache
def public_names(module):
    """Return the public names of a module: those it lists, or what it defines itself."""
    found = importlib.import_module(module)
    listed = getattr(found, "__all__", None)
    if listed is not None:
        return sorted(listed)
    return sorted(
        name
        for name, each in vars(found).items()
        if not name.startswith("_") and getattr(each, "__module__", None) == module
    )


def setup(app):
    """Register all."""
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.add_role("name", name_role)
    app.connect("doctree-read", link_names)
    app.connect("doctree-read", colour_sessions)
    return {"parallel_read_safe": True}
