"""What a strain gauge measured, laid over the blow that was computed."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from percuss.case.answers.blow_answer import BlowAnswer, MeasuredGauge
from percuss.case.answers.numerals import number, percent
from percuss.errors import HistoryError, ParameterError
from percuss.model.checks import choice, instance

if TYPE_CHECKING:
    from percuss.blow import GaugeWaves
    from percuss.blow.gauges import RecordFit
    from percuss.model.body.uniform import Piece
    from percuss.recordings import Recording

_SIGNS = {"auto": None, "positive": 1, "negative": -1}
_FEW = 10
"""Samples while a wave runs through the striker and back, below which the record says little of its shape."""
_PARTLY = 0.5
_UNLIKE = 0.15
"""Residual over the peak, after scaling, that is told of: a wrong place of the gauge gives more."""


def measured_gauge(
    answer: BlowAnswer,
    path: str | os.PathLike[str],
    *,
    column: str | int | None = None,
    unit: str | None = None,
    sample_rate: float | str | None = None,
    sign: Literal["auto", "positive", "negative"] = "auto",
) -> MeasuredGauge:
    """Lay a measured record over the computed force at the gauge of a blow.

    Parameters
    ----------
    answer
        What `blow_answer` gives, of a case in SI with a rod.
    path, column, unit, sample_rate
        As `percuss.recordings.read_recording` has them; strain, stress or force.
    sign
        How the record writes compression: "positive", "negative", or "auto" for the one that fits better.

    Raises
    ------
    HistoryError
        When the record cannot be read, is constant, or nothing in it resembles the computed force.
    ParameterError
        For a dimensionless case, for a wall, and where the area of the rod at the gauge is not known.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from percuss.case import blow_answer, load_case
    >>> answer = blow_answer(load_case("laboratory-striker"))
    >>> time = np.arange(0.0, answer.blow.until, 1e-6)
    >>> force = answer.waves.incident.at(time) + answer.waves.reflected.at(time)
    >>> with TemporaryDirectory() as folder:
    ...     file = Path(folder, "gauge.csv")
    ...     _ = file.write_text("t [s],force [N]\\n" + "".join(f"{t},{-1.02 * f}\\n" for t, f in zip(time, force)))
    ...     found = measured_gauge(answer, file)
    >>> found.sign, round(found.scale, 2)
    (-1, 1.02)
    """
    from percuss.blow.gauges import fitted_record
    from percuss.recordings import read_recording

    instance("answer", answer, BlowAnswer)
    choice("sign", sign, *_SIGNS)
    waves = _waves(answer)
    record = read_recording(path, column=column, unit=unit, sample_rate=sample_rate, sensor="gauge")
    force = record.values * _force_of_one(answer, record)
    try:
        fit = fitted_record(waves, answer.blow.until, record.time, force, sign=_SIGNS[sign])
    except ParameterError as error:
        raise HistoryError(f"expected {error.accepted}", error.remedy, str(record.path)) from None
    kind: Any = "stress" if record.quantity == "pressure" else record.quantity
    return MeasuredGauge(
        str(record.path),
        kind,
        fit.sign,
        fit.shift,
        fit.zero,
        fit.scale,
        fit.residual,
        fit.residual_scaled,
        fit.overlap,
        record.time + fit.shift,
        fit.sign * (force - fit.zero),
        (*record.notes, *_notes(answer, record, fit, sign == "auto")),
    )


def _waves(answer: BlowAnswer) -> GaugeWaves:
    waves = answer.waves
    if waves is None:
        raise ParameterError("measured", "a record", "a blow on a rod", "the target is a wall: give the case a [tool]")
    if not answer.is_si:
        remedy = "describe the bar and the rod by their sizes, in [bar] and [tool]"
        raise ParameterError("measured", "a record", "a case in SI: the case is dimensionless", remedy)
    return waves


def _force_of_one(answer: BlowAnswer, record: Recording) -> float:
    """The force in N, compression positive, that 1 in the record stands for."""
    if record.quantity == "force":
        return 1.0
    piece = _piece(answer)
    if piece is None:
        remedy = "give the rod sections with area and youngs_modulus in [tool], or a record of force"
        raise ParameterError("measured", record.quantity, "a rod whose area at the gauge is known", remedy)
    return piece.area * (piece.youngs_modulus if record.quantity == "strain" else 1.0)  # N = E A ε


def _piece(answer: BlowAnswer) -> Piece | None:
    """The section of the rod under the gauge; of two that meet there, the later one, as for the waves."""
    place, pieces = answer.gauge, answer.pieces[1]
    return next((p for p in pieces if place is not None and place < p.end), pieces[-1] if pieces else None)


def _notes(answer: BlowAnswer, record: Recording, fit: RecordFit, chosen: bool) -> list[str]:
    from percuss.blow.bodies import striker_sections

    found = []
    if chosen:
        which = "positive" if fit.sign > 0 else "negative"
        found.append(f"compression is taken as {which} in the record, which fits better")
    there_and_back = 2.0 * float(striker_sections(answer.blow.striker).transit.sum())
    seen = there_and_back / float(np.median(np.diff(record.time)))
    if seen < _FEW:
        found.append(f"only {number(seen, 2)} samples while a wave runs through the striker and back: sample faster")
    if fit.overlap < _PARTLY:
        found.append(f"the record covers only {percent(fit.overlap)} of the window: compare with a shorter --until")
    if fit.residual_scaled > _UNLIKE:
        found.append("the shapes differ: check the place of the gauge, the sections and the window")
    return found
