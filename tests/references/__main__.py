"""Make tests/data/contact_events.json anew: `python -m tests.references [NAME ...]`.

The cases are those of the table itself: parameters, start and duration. The clearances of its
grazes were chosen by the first peak of the flight that they share, and the speeds of its departures
by the least radius of theirs. Needs python-flint. With names, solve those cases only and print
them; nothing is written.
"""

import json
import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, fields
from math import floor, inf, log10
from pathlib import Path

from flint import arb, ctx

from . import regularised_taylor
from .motion import Case, UnresolvedError, rests_on_ring, start_of

TABLE = Path(__file__).resolve().parent.parent / "data" / "contact_events.json"
HEAD = json.loads(TABLE.read_text(encoding="utf-8"))
GIVEN = [field.name for field in fields(Case)]
CASES = [Case(**{name: row[name] for name in GIVEN}) for row in HEAD.pop("cases")]
WORKERS = int(os.environ.get("WORKERS", "1"))  # processes that share the cases
SHIFT = 1e-16  # of the start, for the sensitivities
SOON = 1e-6  # a moved start may cross the ring once more within this time: no event of the case


def digits_agreed(mine, others):
    """Return the fewest relative digits to which two lists of events agree."""
    if [kind for kind, _ in mine] != [kind for kind, _ in others]:
        raise UnresolvedError("the two orders do not find the same events")
    fewest = inf
    for (_, a), (_, b) in zip(mine, others, strict=True):
        apart = float(abs((a - b) / a).mid())
        fewest = min(fewest, -log10(max(apart, 1e-50)))
    return fewest


def sensitivities(case, base):
    """Return K of each event; one-sided where the other side touches the ring exactly."""
    largest = [0.0] * len(base)
    for component in range(4):
        sides = []
        for sign in (1, -1):
            shift = [arb(0)] * 4
            shift[component] = arb(SHIFT) * sign
            try:
                found = regularised_taylor.events(case, regularised_taylor.COARSE, shift)[1]
            except UnresolvedError:
                sides.append((0, base))
                continue
            if len(found) > len(base):
                found = [event for event in found if event[1] > SOON]
            if len(found) != len(base):
                raise UnresolvedError(
                    f"{len(found)} events, not {len(base)}, from a start moved a bit"
                )
            sides.append((sign, found))
        (plus, ups), (minus, downs) = sides
        if plus == minus:
            raise UnresolvedError("neither side of a start can be followed")
        for number, ((_, up), (_, down)) in enumerate(zip(ups, downs, strict=True)):
            slope = abs(float((up - down).mid())) / ((plus - minus) * SHIFT)
            largest[number] = max(largest[number], slope)
    return largest


def solve(case):
    """Return the row of the table for one case."""
    row = asdict(case)
    ctx.prec = regularised_taylor.FULL.bits
    if rests_on_ring(case, start_of(case)):
        return row | {
            "starts_in_contact": 0, "method": "by inspection", "digits": None, "events": []
        }  # fmt: skip
    in_contact, mine, depths = regularised_taylor.events(case)
    _, others, _ = regularised_taylor.events(case, regularised_taylor.OTHER)
    digits = digits_agreed(mine, others)
    K = sensitivities(case, mine) if mine else []
    ctx.prec = regularised_taylor.FULL.bits
    return row | {
        "starts_in_contact": int(in_contact),
        "method": "regularised Taylor series",
        "digits": min(25, floor(digits)) if mine else None,
        **({"shallowest": float(f"{min(depths):.3g}")} if depths else {}),
        "events": [
            [kind, moment.str(25, radius=False), float(f"{slope:.3g}")]
            for (kind, moment), slope in zip(mine, K, strict=True)
        ],
    }


def attempt(name):
    """Solve one case and print a line on it; return its row, or None if it stays open."""
    case = next(case for case in CASES if case.name == name)
    started = time.perf_counter()
    try:
        row = solve(case)
    except UnresolvedError as why:
        print(f"{name:28s} UNRESOLVED {why}", flush=True)
        return None
    largest = max((event[2] for event in row["events"]), default=0.0)
    last = row["events"][-1][1] if row["events"] else "-"
    print(
        f"{name:28s} {len(row['events']):4d} events, {row['digits']} digits, "
        f"K {largest:.2g}, last {last}, {time.perf_counter() - started:.1f} s",
        flush=True,
    )
    return row


def lay_out(rows):
    """Return the table as JSON with one event a line."""
    lines = ["{"] + [f" {json.dumps(key)}: {json.dumps(value)}," for key, value in HEAD.items()]
    lines.append(' "cases": [')
    for number, row in enumerate(rows):
        lines.append("  {")
        lines += [
            f"   {json.dumps(key)}: {json.dumps(value)},"
            for key, value in row.items()
            if key != "events"
        ]
        events = ",\n    ".join(json.dumps(event) for event in row["events"])
        lines.append(f'   "events": [\n    {events}\n   ]' if events else '   "events": []')
        lines.append("  }," if number < len(rows) - 1 else "  }")
    return "\n".join([*lines, " ]", "}"]) + "\n"


def main(names):
    """Solve the cases, print a line for each, and write the table when all were solved."""
    began = time.perf_counter()
    wanted = [case.name for case in CASES if not names or case.name in names]
    with ProcessPoolExecutor(max_workers=WORKERS) as pool:
        rows = [row for row in pool.map(attempt, wanted) if row is not None]
    print(f"{len(rows)} cases, {time.perf_counter() - began:.0f} s")
    if names:
        return 0
    if len(rows) < len(CASES):
        return 1
    TABLE.write_text(lay_out(rows), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
