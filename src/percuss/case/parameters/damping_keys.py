"""Which keys of damping a case may be varied by: those of the law that it names."""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.case.file_format.plain_tables import json_tables
from percuss.errors import ParameterError
from percuss.model import External, Ratio
from percuss.model.body import Table

if TYPE_CHECKING:
    from percuss.case.case import Case

__all__ = ["DAMPING", "check_same_law"]

DAMPING = "damping"
"""The word of what the keys of damping set, and the key that names its law."""

_LAWS = {"damping_ratio": Ratio, "drag": External, "d": External}
"""The other keys of damping, and the laws whose number they are."""


def check_same_law(case: Case, name: str, key: str) -> None:
    """Refuse a key of damping as an axis where its law would take the place of the one that the case names.

    Parameters
    ----------
    name, key
        Of the axis: as it was given, and as a dotted key.

    Raises
    ------
    ParameterError
        With the key that varies the law of the case, where one does.
    """
    table, _, word = key.partition(".")
    tables, law = json_tables(case)[table], (case.machine() if case.is_machine else case.system()).body.damping
    held = [f"{table}.{other}" for other in (DAMPING, *_LAWS) if other in tables]
    if isinstance(law, Table):
        remedy = "a table of dampings has no single number to vary"
    else:
        remedy = f"vary {held[0]}" if held else "vary bar.damping_ratio or bar.drag"
    if word == DAMPING:
        if key not in held:
            raise ParameterError(name, "on an axis", 'a case with damping = {kind = "…", value = …}', remedy)
        if isinstance(law, Table):
            raise ParameterError(name, f"{law}", "a law of damping with one number")
    elif held and not (law.is_zero or isinstance(law, _LAWS[word])):
        own = _LAWS[word].kind
        wanted = f'a bar without damping, or with damping of the kind "{own}"'
        raise ParameterError(name, f"a bar with {law}", wanted, remedy)
