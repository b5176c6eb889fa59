"""The layout of the package in one picture, drawn from its imports.

python docs/_extensions/layout.py
"""

import tomllib
from pathlib import Path

import grimp

ROOT = Path(__file__).parents[2]
PICTURE = ROOT / "docs" / "layout.svg"
WIDTH, ROW, BOX_WIDTH, BOX_HEIGHT = 720, 58, 150, 30
STYLE = """
  rect { fill: #eef2f7; stroke: #5a6b7f; } text { font: 14px system-ui, sans-serif; fill: #1c2733; }
  path { fill: none; stroke: #5a6b7f; stroke-width: 1.2; opacity: 0.75; }
  svg { background: #ffffff; }
"""


def layers():
    """Return the layers that import-linter holds the package to, from the top."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    names = contracts["tool"]["importlinter"]["contracts"][0]["layers"]
    return [[part.strip().removeprefix("rotor_ida.") for part in row.split("|")] for row in names]


def arrows(rows):
    """Return who uses whom, but for what another arrow implies."""
    graph = grimp.build_graph("rotor_ida")
    parts = [part for row in rows for part in row]
    uses = {part: set() for part in parts}
    for part in parts:
        for other in parts:
            if part != other and graph.direct_import_exists(
                importer=f"rotor_ida.{part}", imported=f"rotor_ida.{other}", as_packages=True
            ):
                uses[part].add(other)
    reached = {}
    for part in reversed(parts):  # those below come first
        reached[part] = uses[part].union(*(reached.get(other, set()) for other in uses[part]))
    return [
        (part, other)
        for part in parts
        for other in sorted(uses[part])
        if not any(other in reached.get(third, set()) for third in uses[part])
    ]


def picture():
    """Return the picture as SVG."""
    rows = layers()
    places = {}
    for down, row in enumerate(rows):
        step = WIDTH / len(row)
        for across, part in enumerate(row):
            # rows of one part stand to the left, in the middle and to the right in turn, so that
            # arrows show
            lean = 0 if len(row) > 1 else (-170, 0, 170)[down % 3]
            places[part] = (step * (across + 0.5) + lean, ROW * (down + 0.6))
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {ROW * len(rows) + 12}" '
        f'width="{WIDTH}" role="img">',
        "<title>Layers of rotor_ida; an arrow leads from a part to what it uses</title>",
        f"<style>{STYLE}</style>",
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0 8 4 0 8z" '
        'style="fill:#5a6b7f;stroke:none"/></marker></defs>',
        f'<rect width="{WIDTH}" height="{ROW * len(rows) + 12}" style="fill:#fff;stroke:none"/>',
    ]
    for part, other in arrows(rows):
        (x, y), (to_x, to_y) = places[part], places[other]
        begin, end = y + BOX_HEIGHT / 2, to_y - BOX_HEIGHT / 2
        middle = 0.5 * (begin + end)
        lines.append(
            f'<path d="M{x:g} {begin:g} C{x:g} {middle:g} {to_x:g} {middle:g} {to_x:g} {end:g}" '
            'marker-end="url(#tip)"/>'
        )
    for part, (x, y) in places.items():
        lines.append(
            f'<rect x="{x - BOX_WIDTH / 2:g}" y="{y - BOX_HEIGHT / 2:g}" width="{BOX_WIDTH}" '
            f'height="{BOX_HEIGHT}" rx="6"/>'
            f'<text x="{x:g}" y="{y + 5:g}" text-anchor="middle">{part}</text>'
        )
    return "\n".join([*lines, "</svg>"]) + "\n"


if __name__ == "__main__":
    PICTURE.write_text(picture(), encoding="utf-8")
