"""Names, units and categories of the variables of all datasets.

`quantities` is the one table of variables, `flags` the words and numbers of categories, `datasets`
makes what is labelled by both, and `tolerances` says how exactly a result must come back.
"""

from rotor_ida.arrays import Column
from rotor_ida.schema.datasets import (
    CONVENTIONS,
    RESULT_KIND,
    along,
    check_as_computed,
    check_variables,
    labelled,
    labelled_dataset,
    origin_of,
    spread,
)  # fmt: skip
from rotor_ida.schema.flags import (
    DAMPED_EVENT_KIND,
    END,
    ENDING,
    ENDS_IN_WORDS,
    EVENT_KIND,
    EXACT,
    FATE,
    LINE_KIND,
    MODE,
    NO_YES,
    OF_FRICTION_EVENT_KIND,
    RESPONSE,
    SPECIAL,
    STABILITY,
    STATUS,
    TRAPPING,
    VERDICT,
    WHIRL_DIRECTION,
    WHIRL_KIND,
    by_number,
    decode_flags,
    flags_of,
    words_of,
)  # fmt: skip
from rotor_ida.schema.quantities import (
    OF_BEARING,
    OF_DROP,
    QUANTITIES,
    WITH_EXTENTS,
    Quantity,
    unit_of,
)  # fmt: skip

__all__ = [
    "CONVENTIONS", "DAMPED_EVENT_KIND", "END", "ENDING", "ENDS_IN_WORDS", "EVENT_KIND", "EXACT",
    "FATE", "LINE_KIND", "MODE", "NO_YES", "OF_BEARING", "OF_DROP", "OF_FRICTION_EVENT_KIND",
    "QUANTITIES", "RESPONSE", "RESULT_KIND", "SPECIAL", "STABILITY", "STATUS", "TRAPPING",
    "VERDICT", "WHIRL_DIRECTION", "WHIRL_KIND", "WITH_EXTENTS", "Column", "Quantity",
    "along", "by_number", "check_as_computed", "check_variables", "decode_flags", "flags_of",
    "labelled", "labelled_dataset", "origin_of", "spread", "unit_of", "words_of",
]  # fmt: skip
