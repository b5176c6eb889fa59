"""docs/errors.md says what each message of the code means, and lists no others."""

import ast
import re
from pathlib import Path

from rotor_ida.core.faults import FAULTS
from rotor_ida.core.interface import MESSAGES

ROOT = Path(__file__).resolve().parents[2]
ROW = re.compile(r"^\| (?P<messages>`.*?`) \| (?P<cause>.*?) \| (?P<cure>.*?) \|$", re.MULTILINE)
# What reaches a user; a ValueError of the core, say, is a fault of the package itself.
CLASSES = {
    *("InputError", "ArchiveError", "SimulationError", "InvariantError", "BudgetError"),
    *("InstallationError", "MissingFileError", "RotorError", "Unfit"),
}


def text_of(node):
    """Return the text of a message, with … for what is inserted."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(text_of(part) for part in node.values)
    if isinstance(node, ast.BinOp):
        return text_of(node.left) + text_of(node.right)
    return "…"


def messages():
    """Return all messages with words of their own."""
    found = set()
    for path in (ROOT / "rotor_ida").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and node.exc.args:
                name = getattr(node.exc.func, "id", "")
                if name in CLASSES:
                    found.add(text_of(node.exc.args[0]))
    # those of one word only say where, and what another function has said
    found = {each for each in found if len(re.findall(r"[a-z]{2,}", each)) > 1}
    return sorted((found | {*MESSAGES.values(), *FAULTS}) - {""})


def patterns():
    """Return the patterns of the page, in order, as text and regular expression."""
    page = (ROOT / "docs" / "errors.md").read_text(encoding="utf-8")
    texts = [text for row in ROW.finditer(page) for text in re.findall("`(.+?)`", row["messages"])]
    texts = [text for text in texts if not text.endswith("Error")]
    return {text: re.compile(".*".join(map(re.escape, text.split("…")))) for text in texts}


def test_each_message_is_on_the_page_and_each_line_of_the_page_is_one():
    known, found = patterns(), {}
    for message in messages():
        found[message] = next((text for text, each in known.items() if each.fullmatch(message)), "")
    assert [message for message, text in found.items() if not text] == []
    assert [text for text in known if text not in found.values()] == []
