"""Formulas as MathML, which browsers show by themselves, and names in prose as links."""

import importlib

from docutils import nodes
from latex2mathml.converter import convert
from sphinx import addnodes

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
    code = nodes.literal(rawtext, text)
    word = text.removesuffix("()").removeprefix("~")
    for home in HOMES:
        short = word.removeprefix(f"{home}.")
        if short in public_names(home):
            target = addnodes.pending_xref(
                "", code, refdomain="py", reftype="obj", reftarget=f"{home}.{short}",
                refexplicit=False, refwarn=True, refdoc=inliner.document.settings.env.docname,
            )  # fmt: skip
            return [target], []
    return [code], []


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
    """Register both."""
    app.add_html_math_renderer("mathml", (inline, None), (displayed, None))
    app.add_role("name", name_role)
    return {"parallel_read_safe": True}
