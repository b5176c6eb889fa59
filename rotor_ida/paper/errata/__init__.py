"""Errors of the paper with evidence in numbers: the source of ``docs/errata.md``.

``python -m rotor_ida.paper.errata FILE`` writes the page.
"""

from rotor_ida.paper.errata.page import errata_page
from rotor_ida.paper.errata.scaling import check_scaling, deviations

__all__ = ["check_scaling", "deviations", "errata_page"]
