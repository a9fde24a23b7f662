"""What must be said of a load that switches as a valve does: here it keeps time by itself.

Every answer takes the load as a clock (B77): it comes at its phase whatever the hammer does. A valve that the piston
works is no clock; after a disturbed blow it comes earlier or later with the piston. The note goes to every load that
switches, the short one into the first lines only for a recording: who types a formula has chosen its clock, who brings
the record of a machine has not. Where the verdict turns on the clock, of a recording or of a load of steps, the first
lines say so: the same motion may be the steady one of a machine whose valve the piston works (theory, "The machine that
switches itself").
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal

from percuss.model.machine import switching_of

if TYPE_CHECKING:
    from percuss.model import Load

Clocked = Literal["no motion", "unstable", "near the fold"]
"""Why a verdict turns on the clock of the load."""

NEAR_FOLD = 0.02
"""Distance of the level from the greatest v_f, as a part of it, below which a motion counts as near the fold."""

CLOCKED = (
    "This verdict is for a load that keeps time by itself, whatever the piston does. If the piston works the valve, "
    "the phase, speed and energy of a motion hold, but its existence and stability do not follow from "
    'here: describe the valve instead (load kind = "valve").'
)
"""What the first lines say of a verdict that turns on the clock."""


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


def clocked_because(
    load: Load, levels: Iterable[tuple[float, float]], motions: Iterable[tuple[bool, bool]]
) -> Clocked | None:
    """Why the verdict on a load turns on its clock; None where it does not.

    It does for a recording or a load of steps without a stable motion, or within 2 % of the fold; and for one that
    switches as a valve does also when another possible motion is unstable, as that one may be the machine's.

    Parameters
    ----------
    load
        What drives the hammer.
    levels
        Of each number of load periods the level and the greatest v_f, which a motion needs to be no less.
    motions
        Of each motion whether it is possible, and whether it is stable.
    """
    if load.report is None and not load.is_piecewise:
        return None
    stable = [steady for possible, steady in motions if possible]
    if not stable:
        return "no motion"
    if not any(stable) or (not all(stable) and switching_of(load) is not None):
        return "unstable"
    return "near the fold" if any(abs(highest - level) < NEAR_FOLD * highest for level, highest in levels) else None
