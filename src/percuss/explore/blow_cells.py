"""The cells of a map that tell of one blow, resolved by waves."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from percuss.blow.figures import FIGURES
from percuss.blow.parts import Outcome
from percuss.errors import ConvergenceError, PercussError
from percuss.explore.cells import failure
from percuss.explore.jobs.job import Columns

if TYPE_CHECKING:
    from percuss.blow import Blow

__all__ = ["StrikingFamily", "blow_columns"]


@runtime_checkable
class StrikingFamily(Protocol):
    """A family of hammers that know what they strike, such as `percuss.case.CaseFamily`."""

    @property
    def is_si(self) -> bool:
        """Whether its blows are in SI."""
        ...

    def blow(self, values: Mapping[str, float]) -> Blow:
        """One blow of the hammer at these values; PercussError where there is none."""
        ...


def blow_columns(
    out: Columns, family: StrikingFamily, cells: Sequence[Mapping[str, float]], stopped: Callable[[], bool]
) -> None:
    """Fill in the columns of the blow; where it fails they stay NaN, and the outcome says so.

    Parameters
    ----------
    out
        Columns of these cells, changed.
    cells
        The parameters of each.
    """
    names = [name for name in FIGURES if name in out]
    for i, values in enumerate(cells):
        if stopped():
            return
        try:
            blow = family.blow(values)
            if blow.outcome is Outcome.TOO_MANY_PIECES:
                raise ConvergenceError("the waves of this blow have too many pieces", "leave short sections out")
            found = {name: FIGURES[name].value(blow) for name in names}
        except (PercussError, ArithmeticError) as error:
            out["outcome"][i] = out["outcome"][i] or failure(error)
            continue
        for name, value in found.items():
            if value is not None:
                out[name][i] = value
