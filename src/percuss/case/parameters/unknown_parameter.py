"""The refusal of a parameter that a case does not have, with those that it has."""

from __future__ import annotations

import re
from collections.abc import Sequence

from percuss.case.file_format.suggest import did_you_mean
from percuss.case.parameters.case_keys import with_generic_places
from percuss.errors import ParameterError

__all__ = ["unknown_parameter"]


def unknown_parameter(name: str, keys: Sequence[str], plain: Sequence[str]) -> ParameterError:
    """The refusal; a size of the bar has its places in a bar of sections.

    Parameters
    ----------
    name
        That there is not.
    keys, plain
        The keys of the case, and the dimensionless parameters.
    """
    last = name.rpartition(".")[2].partition("[")[0]
    in_lists = [
        key for key in keys if "[" in key and not key.startswith("load.") and last in re.split(r"[.\[\]]+", key)[1:]
    ]
    struck = name.startswith("tool.")
    in_list = next((key for key in in_lists if key.startswith("tool.") == struck), None)
    if in_list:
        whose, where = ("tool", "struck face") if struck else ("bar", "driven end")
        hint = f"the {whose} has sections, counted from 0 at the {where}: {in_list}"
    else:
        hint = did_you_mean(name, [*plain, *keys, *(key.partition(".")[2] for key in keys)])
    words = with_generic_places([*plain, *keys])
    return ParameterError("parameter", name, f"one of {', '.join(words)}", hint)
