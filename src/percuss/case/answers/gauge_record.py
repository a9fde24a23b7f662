"""A record of a strain gauge, as it lies over the computed force of a blow."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from percuss.case.answers.numerals import number, percent, quantity
from percuss.model.checks import Array
from percuss.shown import Shown

__all__ = ["MeasuredGauge"]


@dataclass(frozen=True)
class MeasuredGauge(Shown):
    """A record of strain, stress or force at a gauge, laid over the computed force there.

    Attributes
    ----------
    file
        Where it was read.
    quantity
        "strain", "stress" or "force"; times E A, times A or as it is, it is the force at the gauge.
    sign
        1 where compression is positive in the record, −1 where it is negative.
    shift
        What is added to the record's time to make it that of the blow, s.
    zero
        What the record shows without a force, N in its own sign; it is taken off.
    scale
        The factor on the computed force that fits the record best; 1 where they agree.
    residual
        Root mean square of measured less computed force in the window, over the greatest computed force.
    residual_scaled
        The same with the factor.
    overlap
        Share of the blow's window that the record covers.
    time, force
        Shape (n,): the record on the clock of the blow, s, and N with compression positive.
    notes
        What was assumed, one sentence each.
    """

    file: str
    quantity: Literal["strain", "stress", "force"]
    sign: int
    shift: float
    zero: float
    scale: float
    residual: float
    residual_scaled: float
    overlap: float
    time: Array = field(repr=False)
    force: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    @property
    def rows(self) -> tuple[tuple[str, str], ...]:
        """The lines of a report."""
        compression = "positive" if self.sign > 0 else "negative"
        return (
            ("record", f"{self.file}, {self.quantity}, compression {compression}"),
            ("clock", f"{quantity(self.shift, 's', 5)} added to the time of the record"),
            ("zero", f"{quantity(self.zero, 'N')} taken off"),
            ("scale", f"the record is {number(self.scale)} times the computed force"),
            (
                "residual",
                f"{percent(self.residual)} of the computed peak (rms); {percent(self.residual_scaled)} after scaling",
            ),
            ("overlap", f"the record covers {percent(self.overlap)} of the window"),
            *(("note", note) for note in self.notes),
        )

    def to_json_dict(self) -> dict[str, Any]:
        """Its numbers in plain values, without the series."""
        names = ("file", "quantity", "sign", "shift", "zero", "scale", "residual", "residual_scaled", "overlap")
        return {name: getattr(self, name) for name in names} | {"notes": list(self.notes)}
