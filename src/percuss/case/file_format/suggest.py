"""The word that was probably meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["did_you_mean"]


def did_you_mean(word: object, known: Iterable[str]) -> str:
    """``did you mean 'kappa'?``, or nothing when no known word comes near.

    Examples
    --------
    >>> did_you_mean("kapa", ["amplitude", "kappa"])
    "did you mean 'kappa'?"
    """
    names = {name.lower(): name for name in known}
    close = difflib.get_close_matches(str(word).lower(), names, n=1, cutoff=0.6)
    return f"did you mean '{names[close[0]]}'?" if close else ""
