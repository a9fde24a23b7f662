"""Branches of orbits as a table of text, a line for each orbit and impact."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from percuss.explore import Branch

__all__ = ["branch_table"]


def branch_table(branch: Branch) -> str:
    """The branch and those that were switched to from it, as CSV: a line for each impact of each orbit.

    Examples
    --------
    >>> from percuss.case import branch_answer, load_case
    >>> branch = branch_answer(load_case("pneumatic-jackleg"), "1/1", "load_factor=0.39:0.41", modes=0)
    >>> branch_table(branch).splitlines()[0]
    'branch,label,point,load_factor,stable,impact,phase,speed'
    """
    lines = [f"branch,label,point,{branch.parameter},stable,impact,phase,speed"]
    for number, one in enumerate(branch.family(), 1):
        rows = zip(one.values.tolist(), one.phases.tolist(), one.speeds.tolist(), one.stable.tolist(), strict=True)
        for point, (value, phases, speeds, stable) in enumerate(rows, 1):
            for impact, (phase, speed) in enumerate(zip(phases, speeds, strict=True), 1):
                told = f"{one.label},{point},{value!r},{int(stable)},{impact},{phase!r},{speed!r}"
                lines.append(f"{number},{told}")
    return "\n".join([*lines, ""])
