"""What must be said of a load that switches as a valve does: here it keeps time by itself.

Every answer takes the load as a clock (B77): it comes at its phase whatever the hammer does. A valve that the piston
works is no clock; after a disturbed blow it comes earlier or later with the piston. The note goes to every load that
switches, the short one into the first lines only for a recording: who types a formula has chosen its clock, who brings
the record of a machine has not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from percuss.model.switching import switching_of

if TYPE_CHECKING:
    from percuss.model import Load

__all__ = ["clock_in_short", "clock_note"]


def clock_note(load: Load) -> str:
    """The sentence for a load that switches, or ""."""
    found = switching_of(load)
    if found is None:
        return ""
    unit = "" if load.frequency is None else " N"
    return (
        f"the load switches between two levels, {found.high:.4g}{unit} and {found.low:.4g}{unit}, as a valve does: it "
        f"is at one of them for {100.0 * found.share:.0f} % of the time. Stability is judged as if the load kept time "
        "by itself; a valve operated by the piston would re-time it after every blow, so such a machine can run "
        "steadily where no stable motion is found here"
    )


def clock_in_short(load: Load) -> str:
    """The shorter sentence that the first lines of an answer have for a recorded load that switches; else ""."""
    if load.report is None or switching_of(load) is None:
        return ""
    return (
        "The recorded load switches as a valve does: stability is judged as if it kept time by itself, and a valve "
        "would re-time it (see the note)."
    )
