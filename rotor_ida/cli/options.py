"""Options that several commands share, with their help."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter

Words = list[str]


def _one_word_a_start(_kind: type, tokens: Sequence[Any]) -> Words:
    """Return the words after each ``--start`` as one, so that several starts keep apart."""
    starts: Words = []
    for token in tokens:
        if token.index == 0:
            starts.append(token.value)
        else:
            starts[-1] += f" {token.value}"
    return starts


def _several(text: str) -> Parameter:
    return Parameter(help=text, consume_multiple=True, negative=())


Omega = Annotated[str, Parameter(help="Spin speed over the reference frequency.")]
Zeta = Annotated[str, Parameter(help="Damping ratio.")]
Delta0 = Annotated[str, Parameter(help="Radial clearance over eccentricity.")]

Omegas = Annotated[Words, _several("Spin speeds: numbers, or START:STOP:COUNT.")]
Zetas = Annotated[Words, _several("Damping ratios: numbers, or START:STOP:COUNT.")]
Delta0s = Annotated[Words, _several("Clearances: numbers, or START:STOP:COUNT.")]

Start = Annotated[
    Words,
    Parameter(
        help="Start X Y VX VY.",
        consume_multiple=True,
        negative=(),
        converter=_one_word_a_start,
    ),
]
Starts = Annotated[
    Words,
    Parameter(
        help="Start X Y VX VY; may be given several times. Without it, from rest.",
        consume_multiple=True,
        negative=(),
        converter=_one_word_a_start,
        show_default=False,
    ),
]

Component = Annotated[str, Parameter(help="Component of the start: number or START:STOP:COUNT.")]
Duration = Annotated[str, Parameter(help="Time to simulate.")]
Samples = Annotated[str, Parameter(help="Number of times at which the motion is kept.")]
Direction = Annotated[
    str | None,
    Parameter(help="Follow the response from speed to speed: up, down or both."),
]
Workers = Annotated[str | None, Parameter(help="Jobs done at a time; by default one a core.")]
Executor = Annotated[
    str,
    Parameter(
        help="What does the work: auto, serial, threads, processes, dask, or an address of dask."
    ),
]
Rtol = Annotated[str, Parameter(help="Relative tolerance.")]
Atol = Annotated[str, Parameter(help="Absolute tolerance.")]
Method = Annotated[str, Parameter(help="Solver of the contact: adams, bdf or ida.")]
Flight = Annotated[str, Parameter(help="Motion inside the clearance: exact or cvode.")]
Backend = Annotated[str, Parameter(help="How the solver is called: auto, python or compiled.")]

File = Annotated[str, Parameter(name="FILE", help="An archive that this program wrote.")]
Study = Annotated[
    str | None,
    Parameter(help="Keep what is done in this folder, so that it can go on; result in result.nc."),
]
Folder = Annotated[str, Parameter(name="FOLDER", help="The folder of a study.")]
Seed = Annotated[str, Parameter(help="Seed of the random numbers.")]
StartCount = Annotated[str, Parameter(help="Number of random starts.")]
Range = Annotated[str, Parameter(help="Component of the starts: number, or range LOW:HIGH.")]
Out = Annotated[str | None, Parameter(help="Write the result to this new netCDF file.")]
Figure = Annotated[
    str | None, Parameter(help="Draw the result into NAME.png and NAME.svg; give either name.")
]
AsJson = Annotated[
    bool, Parameter(name="--json", help="Print one JSON object, not tables.", negative=())
]
Force = Annotated[bool, Parameter(help="Replace files that are there.", negative=())]
